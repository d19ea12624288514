"""The interval of a noise floor and of the numbers of a sensor: there, or null with a reason, never of no width."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from sstl_cli.diagnosis import floor as floor_module
from sstl_cli.diagnosis.floor import interval
from sstl_cli.diagnosis.verdict import UNDECIDED
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


@pytest.mark.parametrize(("status", "left"), [(UNDECIDED, 0.03), ("none", 0.1)])
def test_what_no_model_explains_is_no_noise(status, left, monkeypatch):
    """The error of a bench whose friction rippled was its own floor: 0.141 N beside 0.138 N, where the readings hold 0.08 N."""
    base = object()
    search = SimpleNamespace(noise=Noise({}, {}, {"act": 0.1}, {}), read=Noise({}, {}, {"act": 0.03}, {}), base=base)
    judged = SimpleNamespace(problem=SimpleNamespace(scatters=False), verdict=SimpleNamespace(status=status), search=search, accepted=base)
    monkeypatch.setattr(floor_module, "_analysed_n", lambda g, noise: noise.smoother["act"])
    assert floor_module.floor(judged, 0.0).value_n == pytest.approx(left)
