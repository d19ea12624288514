"""The charts: false alarms as rare as stated on data of their own kind and worse, changes found soon."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import lfilter

from sstl_cli.identification.change import Chart

SIDES = (0, 0, 0, 0, 1)


def series(rng, length, correlation, tails):
    shape = (length + 60, len(SIDES))
    noise = rng.standard_normal(shape) if tails == "normal" else rng.standard_t(5, shape)
    return lfilter([1.0], [1.0, -correlation], noise, axis=0)[60:]


def alarms(rng, loops, learn, per, correlation, tails):
    """Alarms and judged loops of one watch that learns anew after every alarm, as ``sstl watch`` does."""
    chart, found, judged = Chart(SIDES, learn, per), 0, 0
    for values in series(rng, loops, correlation, tails) * [1.0, 7.0, 0.01, 3.0, 0.2] + [5.0, 0.0, -1.0, 2.0, 1.0]:
        judged += not chart.learning
        if chart.add(values) is not None:
            found += 1
            chart = Chart(SIDES, learn, per)
    return found, judged


@pytest.mark.parametrize("correlation", [0.0, 0.3, 0.5])
@pytest.mark.parametrize(("learn", "per"), [(20, 200), (10, 100), (50, 500)])
def test_no_more_false_alarms_than_stated(learn, per, correlation):
    rng = np.random.default_rng(learn + int(10 * correlation))
    counts = np.array([alarms(rng, per + learn, learn, per, correlation, "normal") for _ in range(24)])
    found, judged = counts.sum(axis=0)
    # one in ``per`` loops is stated; three standard deviations of a Poisson count above it would refute that
    expected = judged / per
    assert found <= expected + 3.0 * np.sqrt(expected)
    assert judged > 20 * per


def test_heavy_tails_stay_near_the_stated_rate():
    rng = np.random.default_rng(3)
    found, judged = np.sum([alarms(rng, 520, 20, 500, 0.5, "t5") for _ in range(12)], axis=0)
    assert found <= 2.0 * judged / 500


@pytest.mark.parametrize(("shift", "within"), [(3.0, 8), (6.0, 5)])
def test_a_step_is_found_soon_with_its_begin(shift, within):
    late = []
    for seed in range(30):
        chart = Chart(SIDES, 20, 500)
        x = series(np.random.default_rng(seed), 80, 0.0, "normal")
        x[40:, 2] -= shift
        for i, values in enumerate(x):
            change = chart.add(values)
            if change is not None:
                assert (change.component, change.direction) == (2, -1)
                assert abs(change.began - 40) <= 2
                late.append(i - 39)
                break
    assert len(late) >= 29
    assert np.median(late) <= within


def test_one_loop_alone_raises_nothing():
    for sign in (1.0, -1.0):
        chart = Chart(SIDES, 20, 500)
        x = series(np.random.default_rng(1), 60, 0.5, "normal")
        x[30] += sign * 1e6
        assert all(chart.add(values) is None for values in x)


def test_what_only_grows_is_watched_upwards_only():
    for sign, found in ((1.0, True), (-1.0, False)):
        chart = Chart(SIDES, 20, 500)
        x = series(np.random.default_rng(2), 60, 0.0, "normal")
        x[30:, 4] += sign * 8.0
        assert any(chart.add(values) is not None for values in x) == found


def test_unknown_values_are_passed_over():
    chart = Chart(SIDES, 20, 500)
    x = series(np.random.default_rng(4), 60, 0.0, "normal")
    x[::3, 1] = np.nan
    x[40:, 1] += 10.0
    assert any(chart.add(values) is not None for values in x)
