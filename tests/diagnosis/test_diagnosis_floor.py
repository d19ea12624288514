"""The interval of a noise floor and of the numbers of a sensor: there, or null with a reason, never of no width."""

from __future__ import annotations

import numpy as np
import pytest

from sstl_cli.diagnosis.floor import interval
from sstl_cli.diagnosis.whitening import Noise
from sstl_cli.steps.diagnose_document import _estimated


def floor_of(spread):
    """Return the interval of a floor that is what the smoother leaves."""
    return interval(Noise({}, {}, {"act": 0.02}, {"act": {"smoother": spread}}), lambda noise: noise.smoother["act"])


def test_a_floor_is_known_as_well_as_its_noise():
    assert floor_of(0.1) == pytest.approx((0.02 * np.exp(-0.196), 0.02 * np.exp(0.196)))


@pytest.mark.parametrize("spread", [0.0, np.nan])
def test_readings_without_noise_have_no_interval(spread):
    assert floor_of(spread) == (None, None)
    found = _estimated("output", "white_n", 1e-6, spread)
    assert found.ci95 is None and found.why == "the readings show no noise"
