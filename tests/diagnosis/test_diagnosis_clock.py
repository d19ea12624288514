"""Clocks that are stamped but not steady, sensors with a clock of their own, and stretches that nobody recorded."""

from dataclasses import replace

import numpy as np
import pytest

from sstl_cli.core.runs import Run
from sstl_cli.diagnosis.clock import before, cornered, hiding, on_grid, paced, since_first, tops
from sstl_cli.diagnosis.gathering import gather
from sstl_cli.diagnosis.question import Question
from sstl_cli.diagnosis.readings import _alike
from sstl_cli.diagnosis.recorder import slow_noise, white_noise
from sstl_cli.diagnosis.records import prepare
from sstl_cli.diagnosis.simulator import Simulator
from sstl_cli.physics.effect import Mechanics
from sstl_cli.physics.transmission import play

PERIOD = 0.02


def movement(time):
    """Return a smooth input (N) with reversals every two seconds."""
    return 12.0 + 8.0 * np.sin(0.5 * np.pi * time)


def jittered(share, seed=0, n=3000):
    rng = np.random.default_rng(seed)
    time = PERIOD * (np.arange(n) + np.clip(share * rng.standard_normal(n), -0.45, 0.45))
    time[0] = 0.0
    return time, rng


@pytest.mark.parametrize("share", [0.02, 0.13])
def test_a_stamped_jitter_moves_readings_and_leaves_their_noise(share):
    time, rng = jittered(share)
    noise = 0.01 * rng.standard_normal((2, len(time)))
    run = on_grid(Run("a", "act", time, movement(time) + noise[0], 0.5 * movement(time) + noise[1]), np.ones(len(time), bool))
    assert np.ptp(np.diff(run.time_s)) < 1e-9 and np.diff(run.time_s)[0] == pytest.approx(PERIOD, rel=1e-5)
    left = run.tension_in_n - movement(run.time_s)
    # straight lines between noisy neighbours would take up to half of the variance away
    assert np.std(left) == pytest.approx(0.01, rel=0.05)
    # a reading at an end has one neighbour only: along which slope to move it nobody knows
    assert len(run) == len(time) - 2
    assert np.corrcoef(left, noise[0][1:-1])[0, 1] > 0.95


@pytest.mark.parametrize("stamped", [False, True])
def test_a_command_belongs_to_the_steps_of_its_loop_or_to_the_stamps(stamped):
    """Moved along its slope though it was none of the stamps', a steady ramp trembles, and a limit of its rate seems to smooth it."""
    time, _ = jittered(0.13)
    even = PERIOD * np.arange(len(time))
    ramp = 10.0 + 8.0 * np.abs((time if stamped else even) / 4.0 % 2.0 - 1.0)
    run = on_grid(Run("a", "act", time, movement(time), movement(time), tension_ref_n=ramp), np.ones(len(time), bool))
    assert np.median(np.abs(np.diff(run.tension_ref_n, 2))) < 1e-4


def test_a_clock_keeps_its_places_over_missing_stretches():
    time, _ = jittered(0.13)
    there = (time < 20.0) | (time > 23.7)
    run = Run("a", "act", time[there], movement(time[there]), movement(time[there]))
    found = on_grid(run, np.ones(len(run), bool))
    assert len(found) == len(time) - 2
    assert found.time_s[found.extra["gap"] > 0.5] == pytest.approx(np.arange(20.0, 23.69, PERIOD), abs=0.005)


def test_a_gap_hides_a_turn_or_does_not():
    time = np.arange(0.0, 8.0, PERIOD)
    u, step = movement(time), np.gradient(movement(time))
    gap = ((time > 0.9) & (time < 1.2)) | ((time > 2.0) & (time < 2.1))
    assert [time[a] for a, _ in hiding(gap, u, step, 0.001)] == pytest.approx([0.92])


def test_what_follows_a_hidden_turn_is_judged_from_the_output_that_was_read_there():
    """The input rises and comes back while nobody records: the model that knows theta meets all that was recorded."""
    time, theta = np.arange(0.0, 30.0, PERIOD), 0.8
    u = np.interp(time, [0.0, 10.0, 12.0, 14.0, 22.0, 30.0], [4.0, 12.0, 24.0, 12.0, 20.0, 6.0])
    y = play.play_operator(u, np.exp(-theta), 0.0, np.exp(theta), 0.0, 4.0)
    there = (time < 10.5) | (time > 13.5)
    rng = np.random.default_rng(1)
    noisy = [c[there] + 0.002 * rng.standard_normal(there.sum()) for c in (u, y)]
    problem = prepare([Run("a", "act", time[there], *noisy)])
    (record,) = problem.records
    assert [s.at * record.dt_s for s in record.again] == pytest.approx([13.5], abs=0.05)
    left = (Simulator(problem, Mechanics()).predict(np.array([theta]), {}) - record.y)[record.weight > 0]
    assert len(left) > 0.85 * len(record) and np.abs(left).max() < 0.02


def test_a_slow_sensor_on_a_clock_of_its_own_shows_its_noise_and_not_the_motion_between():
    rng = np.random.default_rng(2)
    at = np.cumsum(rng.choice([3, 4], 4000))
    readings = 0.3 * at + 0.03 * rng.standard_normal(len(at))
    assert slow_noise(readings, at.astype(float)) == pytest.approx(0.03, rel=0.1)
    assert white_noise(readings) > 3.0 * 0.03


@pytest.mark.parametrize("share", [0.1, 0.3])
@pytest.mark.parametrize("late", ["stamps", "readings"])
def test_readings_say_whether_they_or_their_stamps_jitter(late, share):
    """Moved to where their stamps say, the readings of a steady converter were off by as much as the tension moves meanwhile."""
    time, rng = jittered(share)
    steady = PERIOD * np.arange(len(time))
    read = steady if late == "stamps" else time
    u, y = (movement(read) + 0.01 * rng.standard_normal(len(time)) for _ in range(2))
    run, finite = Run("a", "act", time, u, 0.6 * y), np.ones(len(time), bool)
    found = paced(run, finite)
    if late == "readings":
        assert found is run
    else:
        assert np.abs(found.time_s - steady).max() < 0.1 * share * PERIOD
        lost = paced(replace(run, time_s=time + PERIOD * (time > 9.0)), finite).time_s
        # with a reading missing, places tell where the clock is near a steady one, else nothing does
        assert np.ptp(np.diff(lost)) == pytest.approx(PERIOD if share < 0.2 else np.ptp(np.diff(time + PERIOD * (time > 9.0))), rel=1e-3)


def test_renewals_that_change_nothing_are_readings_and_a_stuck_sensor_is_none():
    fresh = np.zeros(60, bool)
    fresh[[0, 4, 8, 16, 20, 59]] = True
    assert np.flatnonzero(_alike(fresh, np.arange(60.0), 4.0)).tolist() == [12]


@pytest.mark.parametrize("period", [1.5, 2.4, 7.3])
def test_a_renewal_that_changes_nothing_comes_at_its_own_sample(period):
    """One sample late it would be a copy of what was read before: an output on the move was off by a step there, at 18 stated errors."""
    renewals = np.arange(0.3, 400.0, period)
    at = np.ceil(renewals).astype(int)
    fresh = np.zeros(401, bool)
    fresh[at] = True
    for k in range(20, len(at) - 20, 3):
        shown = fresh.copy()
        shown[at[k]] = False
        assert np.flatnonzero(_alike(shown, np.arange(401.0), period)).tolist() == [at[k]]


def test_a_renewal_where_nothing_was_recorded_is_no_reading_that_happens_to_be_equal():
    """A stale reading before a gap stood for what was renewed inside it: 20 stated errors on a steep ramp."""
    time = np.delete(np.arange(60.0), slice(18, 31))
    fresh = np.isin(time, [0.0, 8.0, 16.0, 40.0, 48.0, 56.0])
    # one due at 24 and one at 32, of which the second was recorded
    assert time[_alike(fresh, time, 8.0)].tolist() == [32.0]


def test_a_corner_between_two_samples_is_where_the_lines_meet_and_a_smooth_turn_is_none():
    dt = 0.02
    time = np.arange(400) * dt
    # corners at 2.005 s, 4.013 s (between samples) and 6 s (at one)
    ideal = np.array([0.0, 2.005, 4.013, 6.0, 8.0]), np.array([0.0, 20.0, 3.0, 25.0, 5.0])
    u = np.interp(time, *ideal)
    found = cornered(u, dt)
    at = np.flatnonzero(found.beyond)
    # the first samples after them: a corner that comes after a sample shows at the next
    assert time[at] == pytest.approx([2.02, 4.02], abs=1e-9)
    assert (u + found.moved(0.0))[at] == pytest.approx([20.0, 3.0], abs=1e-6)
    assert (u + found.back)[at] == pytest.approx([u[100], u[201]], abs=1e-9)
    # behind a lag the extreme stays off the corner by tau b ln(1 + a / b), at most by all that lies beyond the sample
    a, b = 20.0 / 2.005, 17.0 / 2.008
    assert (u + found.moved(0.001))[at[0]] == pytest.approx(20.0 - 0.001 * b * np.log1p(a / b), abs=1e-6)
    assert (u + found.moved(1.0))[at] == pytest.approx([u[100], u[201]], abs=1e-9)
    assert cornered(movement(time), dt) is None


def test_the_top_of_a_parabola_is_found_between_its_samples_and_half_a_sample_is_the_farthest():
    for late in (0.0, 0.2, 0.4):
        x = np.arange(9.0) - 4.0 - late
        beyond, most = tops(5.0 - 3.0 * x**2)
        assert beyond[4] == pytest.approx(3.0 * late**2) and most[4] == pytest.approx(6.0 / 8.0)
        low, _ = tops(3.0 * x**2)
        assert low[4] == pytest.approx(-3.0 * late**2)
    # where it rises, rests or stands still nothing is passed
    assert not np.any(tops(np.array([0.0, 1.0, 2.0, 2.0, 2.0]))[0])


@pytest.mark.parametrize("between", [True, False])
def test_the_extreme_that_a_hold_keeps_may_lie_between_two_samples(between):
    rng = np.random.default_rng(5)
    fine = np.arange(0.0, 24.0, 0.001)
    u = np.interp(fine, np.arange(9) * 3.0 + 0.0071, [4.0, 20.0, 5.0, 24.0, 6.0, 18.0, 4.0, 22.0, 5.0])
    if not between:
        # a controller of the same rate never goes beyond its samples
        u = np.interp(fine, fine[::20], u[::20])
    y = play.play_operator(u, np.exp(-0.6), 0.0, np.exp(0.6), 0.0, 4.0)
    time = np.arange(2 * len(fine) // 20) * PERIOD
    y = play.play_operator(np.concatenate((u, u[::-1])), np.exp(-0.6), 0.0, np.exp(0.6), 0.0, 4.0)[::20][: len(time)]
    u = np.concatenate((u, u[::-1]))[::20][: len(time)]
    run = Run("a", "act", time, *(c + 0.005 * rng.standard_normal(len(time)) for c in (u, y)))
    # 6 N/s: a sample misses up to 60 mN of a peak, the hold half of that, six times the noise
    assert gather([run], Question(effects=("crosstalk",), max_effects=1)).rows.log.base_chi2 < 1.2


def test_a_clock_that_goes_on_tells_when_each_run_began():
    first, second, third = (Run(str(a), "act", a + np.arange(5.0), np.ones(5), np.ones(5)) for a in (0.0, 100.0, 250.0))
    assert since_first([second, first, third]) == [100.0, 0.0, 250.0]
    # each file has a clock of its own
    assert since_first([first, replace(second, time_s=first.time_s)]) == [0.0, 0.0] and since_first([third]) == [0.0]


def test_what_went_before_is_of_the_same_tendon_and_began_earlier():
    assert before([1.0, 10.0, 100.0, 1000.0], [200.0, 0.0, 100.0, 300.0], ["act", "act", "sstl", "act"]) == [10.0, 0.0, 0.0, 11.0]
    # without a clock that went on all begin at once
    assert before([1.0, 10.0], [0.0, 0.0], ["act", "act"]) == [0.0, 0.0]
