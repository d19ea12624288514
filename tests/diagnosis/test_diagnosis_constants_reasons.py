"""Chosen numbers against the reasons that stand above them: what follows from another number, a law or an instrument."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.stats import norm

import sstl_cli.diagnosis
from sstl_cli.diagnosis import constants as c

DOCS = (Path(sstl_cli.diagnosis.__file__).parents[2] / "docs" / "diagnosis.md").read_text("utf-8")


def test_odds_are_those_that_the_manual_states():
    assert "49 to 1" in DOCS and np.exp(c.DECIDES_NATS) == pytest.approx(49.0)
    assert "5 nats (150 to 1)" in DOCS and c.JOINS_NATS == 5.0 and np.exp(c.JOINS_NATS) == pytest.approx(150.0, rel=0.02)
    assert "beyond doubt (25 nats)" in DOCS and c.DOUBT_NATS == 25.0
    # a cause without a name has odds against it
    assert np.exp(c.UNNAMED) == pytest.approx(1.0 / 20.0)
    assert "(1, 2, 4 or 8, or none)" in DOCS and c.ROUNDINGS == (1.0, 2.0, 4.0, 8.0)


def test_the_decidable_distance_tells_19_of_20_cases():
    """The log ratio of two simple hypotheses a distance d2 apart is normal with mean d2 / 2 and variance d2."""

    def told(d2):
        return norm.sf(c.DECIDES_NATS, 0.5 * d2, np.sqrt(d2))

    assert c.TOLD == 0.95 and told(c.DECIDABLE) >= c.TOLD > told(c.DECIDABLE - 1.0) and round(c.DECIDABLE) == c.DECIDABLE


def test_shares_of_a_law_s_error_rise_from_none_to_a_third():
    assert c.SHARES[0] == 0.0 and np.ptp(np.diff(np.log10(c.SHARES[1:]))) < 0.05 and c.SHARES[1] == 0.01 and c.SHARES[-1] == 0.3
    # no share, the middle one and the next: neither the least nor the most
    assert (0.0, c.SHARES[2], c.SHARES[3]) == c.MISFITS and len(c.SHARES) == 5
    # a jump is never exact, and a regular sawtooth scatters by 1 / sqrt(3) of what it loses on average
    assert c.JUMPS[0] < 1.0 / np.sqrt(3.0) < c.JUMPS[-1] == 1.0 and list(c.JUMPS) == sorted(c.JUMPS)


def test_a_region_is_worse_by_the_size_of_a_gap():
    assert pytest.approx(1.1 * 1.1) == c.WORSE and c.LEAST_GAP == 0.1
    # half is half, of the error and of a promise
    assert c.HALF == 0.5 and 2.0 * c.KEPT_PROMISE == 1.0


def test_lengths_in_samples_are_those_of_the_rates():
    assert c.MIN_SAMPLES == 2 * c.ANALYSIS_HZ == 100 and c.MIN_STREAM == 2 * c.MIN_SAMPLES and c.LEAST_MAPPED == c.ANALYSIS_HZ
    # a reading of the slow noise of an input stands for half of a step of the analysis
    assert pytest.approx(0.5) == c.HEARD_S * c.ANALYSIS_HZ
    # nothing faster than half of the simulation's rate can be planned
    assert 2.0 * c.FASTEST_HZ == c.SIMULATION_HZ == 1000.0
    # all places of one corner, and one sample more on either side
    assert c.SHORTEST_SMOOTHED == c.SHORTEST_WINDOW == 2 * c.ELSEWHERE + 2
    assert c.STRETCHES == 2 * c.PARTS and c.BASE_ITERATIONS == 2 * c.SHORT_ITERATIONS and pytest.approx(0.2) == c.BEFORE_TURN


def test_as_many_held_samples_as_the_spread_of_white_noise_asks_for():
    # the standard deviation of n normal numbers is known to 1 / sqrt(2 n); third differences know less
    assert c.WHITE == 0.05 and 1.0 / np.sqrt(c.ENOUGH_HELD) == pytest.approx(c.WHITE)
    # what no hold shows is known to a factor of e; what a hold shows better than that, and two sensors are as alike
    assert c.UNMEASURED == 1.0 > c.ALIKE > c.MEASURED > c.SMOOTHER > c.WHITE
    assert pytest.approx(1.0) == c.ALIKE_FROM * c.ALIKE_TO and c.ALIKE_TO > 1.0


def test_a_log_range_is_three_decades():
    assert pytest.approx(np.log(100.0 / 0.1)) == c.LOG_RANGE
    # friction of the loop cannot be less than none
    assert c.LOOP_LIMITS[0] > -1.0 and 1.0 + c.LOOP_LIMITS[0] == pytest.approx(1.0 / (1.0 + c.LOOP_LIMITS[1]))
    # what anything moves through: from a thousandth of its tension lost to all but a hundredth
    assert np.exp(-c.THETA_LOW) == pytest.approx(0.999, abs=1e-4) and np.exp(-c.THETA_HIGH) < 0.01 < np.exp(-c.THETA_HIGH + 0.5)


def test_a_draw_of_the_bootstrap_stands_for_its_two_and_a_half_percent():
    # the 25th of them is its 2.5 % quantile
    assert 0.025 * c.DRAWS == 25.0
