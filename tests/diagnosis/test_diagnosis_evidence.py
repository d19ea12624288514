"""Charges of the evidence against the integrals that they stand for."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import quad

from sstl_cli.diagnosis.constants import LOG_RANGE
from sstl_cli.diagnosis.evidence import shape_charge, strengths_charge
from sstl_cli.diagnosis.free import Free
from sstl_cli.physics.effect import Parameter
from sstl_cli.physics.effects import get


@pytest.mark.parametrize("d", [5.0, 20.0, 60.0])
def test_one_strength_costs_what_its_prior_gives_away(d):
    # likelihood exp(-(x - d)^2 / 2) over its peak, prior 1 / (2 L |x|) for 0.1 < |x| < 100
    area, _ = quad(lambda x: np.exp(-0.5 * (x - d) ** 2) / (2.0 * LOG_RANGE * x), max(0.1, d - 12.0), d + 12.0)
    assert strengths_charge(1, d * d) == pytest.approx(-np.log(area), abs=0.05)


def test_two_strengths_cost_what_their_prior_gives_away():
    d = 30.0
    # radius as before, direction even on the circle: prior 1 / (2 pi r^2 L)
    area, _ = quad(
        lambda x: quad(lambda y: np.exp(-0.5 * ((x - d) ** 2 + y * y)) / (2 * np.pi * (x * x + y * y) * LOG_RANGE), -8, 8)[0],
        d - 8.0,
        d + 8.0,
    )
    assert strengths_charge(2, d * d) == pytest.approx(-np.log(area), abs=0.02)


def test_no_strength_costs_nothing_and_more_cost_more():
    assert strengths_charge(0, 100.0) == 0.0
    costs = [strengths_charge(k, 400.0) for k in (1, 2, 3, 4)]
    assert costs == sorted(costs) and costs[0] > 0.0


def test_a_shape_costs_the_logarithm_of_range_over_width():
    effect = get("stribeck")
    shape = Free(effect, Parameter("v", "mm/s", 1.0, 0.1, 10.0, "", shape=True))
    # known to 10 % on a logarithmic range of two decades
    assert shape_charge(shape, 2.0, 0.2) == pytest.approx(np.log(np.log(100.0) / (np.sqrt(2 * np.pi) * 0.1)))
    assert shape_charge(shape, 2.0, 1e3) == 0.0
