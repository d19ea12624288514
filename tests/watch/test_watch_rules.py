"""Lower turns of a growing recording and the charts, worked by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.stats import norm
from scipy.stats import t as student

from sstl_cli.identification.change import Chart, _began, correlation, limit, normal_of_t
from sstl_cli.identification.loops import LoopCutter, usual_step


def cut(x, dt=0.1):
    """Lower turns, each with the sample that confirms it, and the final ``falling_to``."""
    cutter, found = LoopCutter(), []
    for k, v in enumerate(x):
        found += [(at, k) for at in cutter.add(np.array([v]), dt)]
    whole = LoopCutter()
    assert whole.add(np.asarray(x, float), dt) == [at for at, _ in found]
    assert whole.falling_to == cutter.falling_to
    return found, cutter.falling_to


def triangle(n, period=40, high=10.0, begin=0):
    return np.interp((np.arange(n) + begin) % period, [0, period / 2, period], [0.0, high, 0.0])


def test_turns_of_a_triangle():
    # range 10 N: confirmed once 3 N above the turn; the middle of three samples flattens the corner, whose last sample is
    # one late; the first turn is told after the sixteen samples that show the noise
    found, falling = cut(triangle(130))
    assert found == [(0, 17), (41, 48), (81, 88), (121, 128)] and falling is None
    assert cut(triangle(116))[1] == 114
    # falling at first: the start is no turn
    assert cut(triangle(80, begin=20))[0] == [(21, 28), (61, 68)]


def test_a_hold_of_one_period_of_samples():
    # 10 ms: a stay beyond the swing must last 4 samples; dropouts of 3 turn nothing, of 5 do
    for length, turns in ((3, 0), (4, 1), (5, 1)):
        x = np.concatenate((np.linspace(0.0, 10.0, 200), np.full(100, 10.0)))
        x[250 : 250 + length] = 2.0
        assert len(cut(x, 0.01)[0]) - 1 == turns, length
    assert [at for at, _ in cut(np.concatenate((np.linspace(0, 10, 100), np.linspace(10, 0, 100), np.linspace(0, 10, 100))), 0.0)[0]] == [
        0,
        200,
    ]


def test_a_short_stay_turns_nothing_in_any_state():
    # at 10 ms a stay must last 4 samples, and the middle of three shortens none that lasts two or more
    rest, fall = np.full(60, 5.0), np.concatenate((np.linspace(0.0, 10.0, 200), np.linspace(10.0, 5.0, 100), np.full(60, 5.0)))
    for begin, before in ((rest, 0), (fall, 1)):
        for length in (3, 4, 5):
            x = begin.copy()
            x[-30 : len(x) - 30 + length] += 4.0
            found, falling_to = cut(x, 0.01)
            assert len(found) == before + (length >= 4) and falling_to is not None
        # two stays of three samples are not one of six
        x = begin.copy()
        for at in (-30, -20):
            x[at : len(x) + at + 3] += 4.0
        assert len(cut(x, 0.01)[0]) == before


def test_a_flat_bottom_ends_with_its_last_sample():
    x = np.concatenate((np.linspace(0, 10, 41), np.linspace(9.75, 0.0, 40), np.zeros(12), np.linspace(0.25, 10.0, 40)))
    assert [at for at, _ in cut(x)[0]] == [0, 92]


def rough(size, high):
    """A triangle under noise of alternating sign, whose second difference is 4 ``size`` at every sample."""
    return triangle(400, 100, high) + size * (-1.0) ** np.arange(400)


def test_noise_alone_turns_nothing():
    # sd = 4 a / 1.954, and twelve of them is 24.6 a: with a = 0.1 N a movement of 2 N is noise, one of 3 N is none
    assert cut(rough(0.1, 2.0))[0] == []
    assert [at // 100 for at, _ in cut(rough(0.1, 3.2))[0]] == [0, 1, 2, 3]


def test_ties_within_three_deviations_belong_to_the_turn():
    # jumps of 0.1 N either way are an sd of 0.205 N: ten samples 0.35 N above the lowest, -0.1 N, are within three of them,
    # at 0.95 N they are beyond
    down, up = np.arange(100, 0, -1) * 0.3, 1.0 + np.arange(60) * 0.3
    for height, at in ((0.35, 110), (0.95, 101)):
        x = np.concatenate((np.zeros(20), np.arange(100) * 0.3, down, [0.0], np.full(10, height), up))
        x = x + 0.1 * (-1.0) ** np.arange(len(x))
        assert abs(cut(x)[0][1][0] - 120 - at) <= 1


def test_usual_step():
    assert usual_step(np.array([0.0, 0.1, 0.3, 0.4])) == pytest.approx(0.1)
    assert math.isnan(usual_step(np.array([1.0])))
    # the first sixteen samples tell
    assert usual_step(np.concatenate((np.arange(16.0), 16.0 + 5.0 * np.arange(40)))) == 1.0


def test_normal_of_t_is_as_probable():
    for degrees in (7, 17, 47, 97):
        for t in (0.3, 1.0, 2.0, 3.5, 6.0):
            z = normal_of_t(t, degrees)
            assert z == pytest.approx(norm.isf(student.sf(t, degrees)), rel=0.006) and normal_of_t(-t, degrees) == -z


def test_correlation_of_hand_worked_series():
    # d = -1 -1 1 1 (power 4), lagged products 1 - 1 + 1: r = 1/4, corrected by (1 + 4 r) / 4
    assert correlation(np.array([1.0, 1.0, 3.0, 3.0])) == pytest.approx(0.25 + 0.5)
    assert correlation(np.array([1.0, 3.0] * 10)) == 0.0
    assert correlation(np.ones(9)) == 0.0
    assert correlation(np.arange(30.0)) == 0.8


LEARNED = np.array([5.0, 7.0, 4.0, 8.0, 5.0, 6.0, 3.0, 8.0, 5.0, 7.0])


def chart(values=LEARNED, sides=(0,), errors=None, per=500.0):
    c = Chart(sides, len(values), per)
    for v in values:
        assert c.learning and c.mean(0) is None
        assert c.add(np.full(len(sides), v), None if errors is None else np.full(len(sides), errors)) is None
    assert not c.learning
    return c


def expected_z(value, last, values=LEARNED, error=0.0):
    """Standardised value after learning, straight from the definition of a regression on the value before."""
    n = len(values)
    d = values - values.mean()
    r = float(d[1:] @ d[:-1] / (d @ d))
    phi = min(max(r + (1 + 4 * r) / n, 0.0), 0.8)
    e = values[1:] - phi * values[:-1]
    variance = max(float(((e - e.mean()) ** 2).sum()) / (n - 3), error**2 * (1 - phi**2))
    t = (value - phi * last - e.mean()) / math.sqrt(variance * (1 + 1 / (n - 1)))
    return normal_of_t(t, n - 3), phi, float(e.mean())


RISING = np.array([1.0, 2.5, 2.0, 3.0, 4.0, 3.8, 5.0, 4.5, 3.5, 4.0, 3.0, 2.0])


@pytest.mark.parametrize(("values", "error"), [(LEARNED, 0.0), (RISING, 0.0), (LEARNED, 4.0), (RISING, 3.0)])
def test_sums_follow_page_s_recursion(values, error):
    c = chart(values, errors=error)
    up = down = 0.0
    last = values[-1]
    _, phi, mean = expected_z(0.0, last, values, error)
    assert c.mean(0) == pytest.approx(mean / (1 - phi))
    spread = values.std()
    for step in (1.5, 2.2, -0.5, 2.5, -2.0, -2.8, 1.0):
        value = values.mean() + step * spread * (1 + 0.7 * error)
        z = expected_z(value, last, values, error)[0]
        assert abs(z) < 4.0
        c.add(np.array([value]))
        up, down = max(0.0, up + z - 1.0), max(0.0, down - z - 1.0)
        last = value
        assert c.sums[0].tolist() == pytest.approx([up, down])
        assert c.level == pytest.approx(max(up, down) / limit(len(values), 500))


def test_one_value_counts_no_more_than_four_deviations_and_is_remembered_so():
    c = chart(RISING)
    c.add(np.array([1e9]))
    assert c.sums[0].tolist() == [3.0, 0.0]
    z0, phi, mean = expected_z(0.0, RISING[-1], RISING)
    # the value remembered lies four deviations off; the next one is judged from there
    sd = (0.0 - phi * RISING[-1] - mean) / t_of(z0, len(RISING) - 3)
    last = phi * RISING[-1] + mean + 4.0 * sd
    c.add(np.array([6.0]))
    assert c.sums[0, 0] == pytest.approx(max(0.0, 3.0 + expected_z(6.0, last, RISING)[0] - 1.0))
    c = chart(RISING)
    c.add(np.array([-1e9]))
    assert c.sums[0].tolist() == [0.0, 3.0]


def t_of(z, degrees):
    scale = (8 * degrees + 1) / (8 * degrees + 3)
    return math.copysign(math.sqrt(degrees * math.expm1((z / scale) ** 2 / degrees)), z)


def test_an_alarm_tells_component_direction_begin_and_score():
    c = Chart((0, 1), 10, 50)
    for v in LEARNED:
        c.add(np.array([v, v]))
    # three sound values, then four deviations down in both: 3 a step, over the limit of 6.1 with the third
    for v in (5.8, 6.0, 5.7):
        assert c.add(np.array([v, v])) is None
    found = [c.add(np.array([-1e9, -1e9])) for _ in range(3)]
    assert found[:2] == [None, None] and found[2] is not None
    assert (found[2].component, found[2].direction, found[2].began) == (0, -1, 13)
    assert found[2].score == pytest.approx(9.0)
    # what is watched upwards only has no sum downwards
    assert c.sums[1].tolist() == [0.0, 0.0]


def test_the_higher_of_two_charts_is_told():
    c = Chart((0, 0), 10, 50)
    for v in LEARNED:
        c.add(np.array([v, v]))
    c.add(np.array([5.8, 1e9]))
    for _ in range(2):
        found = c.add(np.array([1e9, 1e9]))
    assert found is not None and (found.component, found.direction, found.score) == (1, 1, pytest.approx(9.0))
    found = c.add(np.array([1e9, 1e9]))
    assert found is not None and (found.component, found.score) == (1, pytest.approx(12.0))


def test_components_learn_each_on_their_own_and_pass_over_gaps():
    c = Chart((0, 0), 10, 50)
    for k, v in enumerate(LEARNED):
        c.add(np.array([v, v if k % 2 else math.nan]))
    assert not c.learning and c.mean(0) is not None and c.mean(1) is None
    assert c.seen == 10 and c.sums[1].tolist() == [0.0, 0.0]


def test_identical_loops_have_the_spread_of_their_rounding():
    c = chart(np.full(10, 3.0))
    # a billionth of the mean: a change of ten of them is one
    c.add(np.array([3.0 + 3e-8]))
    assert c.sums[0, 0] == 3.0
    c = chart(np.full(10, 3.0))
    c.add(np.array([3.0 + 3e-9 * math.sqrt(1 + 1 / 9)]))
    assert c.sums[0, 0] == 0.0
    c.add(np.array([3.0 + 2.0 * 3e-9 * math.sqrt(1 + 1 / 9)]))
    assert c.sums[0, 0] == pytest.approx(normal_of_t(2.0, 7) - 1.0, rel=1e-3)
    # near zero a thousandth counts as the mean
    c = chart(np.zeros(10))
    c.add(np.array([2e-12 * math.sqrt(1 + 1 / 9)]))
    assert c.sums[0, 0] == pytest.approx(normal_of_t(2.0, 7) - 1.0, rel=1e-3)


@pytest.mark.parametrize("at", range(2, 9))
def test_a_spike_in_the_first_samples_is_no_movement(at):
    x = np.full(60, 5.0)
    x[at] = 9.0
    assert cut(x) == ([], None)


def test_a_fall_is_told_with_its_fourth_sample():
    # the middle of three samples sees it one later
    x = np.concatenate((np.full(40, 5.0), np.full(5, 1.0)))
    assert cut(x[:44], 0.01)[1] is None and cut(x, 0.01)[1] == 43


def test_a_change_began_where_half_of_its_level_was_reached():
    # the last values lie 4 deviations off: what lies beyond 2 belongs to it
    assert _began([(3, 1.2), (4, 0.1), (5, 1.3), (6, 4.0), (7, 4.0), (8, 4.0)]) == 6
    assert _began([(1, 1.0), (2, 2.5), (3, 4.0), (4, 9.0), (5, 3.0)]) == 2
    assert _began([(1, 1.9), (2, 2.5), (4, 4.0), (5, 4.0), (6, 4.0), (7, 1.0)]) == 2
