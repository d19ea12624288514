"""A sensor's law that changes at a tension: something was read on either side of it, else it would be a gain, or nothing."""

from __future__ import annotations

import numpy as np
import pytest
from made_fits import NOISE_N, THETA, simulator

from sstl_cli.diagnosis.fit import fit
from sstl_cli.diagnosis.hypotheses import Hypothesis, laws
from sstl_cli.diagnosis.whitening import white

SIM = simulator()
WHITEN = white(NOISE_N, SIM.weight, [s.start for s in SIM.slices()])


def of(effect_id: str, *names: str) -> Hypothesis:
    return next(h for h in laws(effect_id, ("act",)) if [f.parameter.name for f in h.free] == list(names))


def test_readings_span_both_ends_of_the_line() -> None:
    # the input swings from 3 to 21 N, the output by six tenths of that; a hundredth of the readings is left out at either end
    assert SIM.read_n == pytest.approx((1.85, 20.97), abs=0.1)


@pytest.mark.parametrize(("begin", "found"), [(0.7, SIM.read_n[0]), (8.0, 8.0), (44.0, SIM.read_n[1])])
def test_a_knee_begins_between_readings(begin: float, found: float) -> None:
    done = fit(SIM, WHITEN, of("sensor_nonlinearity", "b_out", "knee_n"), THETA, np.array([0.01, begin]), 0)
    assert done.values == pytest.approx([0.01, found])


def test_a_knee_ends_between_readings() -> None:
    done = fit(SIM, WHITEN, of("saturation", "soft_out", "knee_n", "width_n"), THETA, np.array([0.8, 45.0, 5.0]), 6)
    assert SIM.read_n[0] <= done.values[1] <= SIM.read_n[1]
