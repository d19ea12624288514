"""Places on a grid, stretches that nobody recorded and corners between samples, by hand."""

from __future__ import annotations

import numpy as np
import pytest

from sstl_cli.core.runs import Run
from sstl_cli.diagnosis import clock
from sstl_cli.diagnosis.clock import blurred, cornered, hiding, on_grid

RNG = np.random.default_rng(2)


def run(time, **extra):
    return Run("r", "act", time, 2.0 * time, 1.0 - time, position_in_mm=3.0 * time, extra=extra)


def test_an_even_clock_stays_as_it_is():
    even = run(0.1 * np.arange(200))
    assert on_grid(even, np.ones(200, bool)) is even
    # steps within a hundredth are written with few digits
    near = run(0.1 * np.arange(200) + 0.0004 * (np.arange(200) % 2))
    assert on_grid(near, np.ones(200, bool)) is near
    assert on_grid(run(0.1 * np.arange(200) + 0.006 * (np.arange(200) % 2)), np.ones(200, bool)) is not near


def test_samples_that_do_not_count_are_filled_on_the_same_grid():
    finite = np.ones(200, bool)
    finite[[50, 120, 121, 122, 123, 124]] = False
    every = (np.arange(200) % 2 == 0) | (np.arange(200) == 199)
    one = run(5.0 + 0.1 * np.arange(200), known_tension_out_n=every.astype(float))
    found = on_grid(one, finite)
    assert found.time_s == pytest.approx(one.time_s) and found.tension_in_n == pytest.approx(one.tension_in_n)
    assert found.tension_out_n == pytest.approx(one.tension_out_n) and found.position_in_mm == pytest.approx(one.position_in_mm)
    # one sample is within two steps of a reading; of five the one in the middle is not
    assert np.flatnonzero(found.extra["gap"]).tolist() == [120, 121, 122, 123, 124]
    assert found.extra["early_s"] == pytest.approx(np.zeros(200), abs=1e-9)
    assert np.array_equal(found.extra["known_tension_out_n"], (every & finite).astype(float))


@pytest.mark.parametrize(("steps", "begin"), [(0.1, 0.0), (0.1, 70.0)])
def test_places_are_those_of_the_steady_clock_behind_the_stamps(steps, begin):
    at = np.delete(np.arange(3000), np.arange(1000, 1007))
    time = begin + steps * at + 0.01 * RNG.standard_normal(len(at))
    # told a step that is a thousandth too long, which is three samples at the end
    found, slope, start = clock._places(time, 1.001 * steps)
    assert np.array_equal(found, at) and slope == pytest.approx(steps, rel=1e-4) and start == pytest.approx(begin, abs=2e-3)


def test_a_clock_that_is_far_from_steady_has_no_places():
    assert clock._places(np.cumsum(RNG.exponential(0.1, 500)), 0.07) is None
    twice = np.sort(np.concatenate((np.arange(200.0), np.arange(0.0, 200.0, 10.0) + 0.01)))
    # one reading in eleven has no place of its own
    assert clock._places(twice, 1.0) is None
    assert clock._places(np.array([0.0, 0.1, 0.2]), 10.0) is None


def test_two_readings_of_one_instant_at_the_beginning_hide_no_clock():
    time = np.arange(300.0) + 0.05 * np.random.default_rng(8).standard_normal(300)
    time[1] = time[0] + 0.01
    at, step, begin = clock._places(time, 1.0)
    # the second of them has no place of its own, all that follow have
    assert (
        at[:4].tolist() == [0, 0, 2, 3] and at[-1] == 299 and step == pytest.approx(1.0, abs=1e-3) and begin == pytest.approx(0.0, abs=0.05)
    )


@pytest.mark.parametrize(("twice", "placed"), [(5, True), (6, False)])
def test_so_many_readings_have_to_have_a_place_of_their_own(twice, placed):
    # of 100 steps five may be none
    time = np.sort(np.concatenate((np.arange(101.0 - twice), 10.0 * np.arange(1, twice + 1) + 0.001)))
    assert len(time) == 101 and (clock._places(time, 1.0) is not None) is placed


@pytest.mark.parametrize(("jitter", "steady"), [(0.19, True), (0.21, False)])
def test_a_clock_is_near_a_steady_one_by_a_fifth_of_a_step(jitter, steady):
    off = np.tile([1.0, -1.0], 300) * jitter
    assert (clock._places(np.arange(600.0) + off, 1.0) is not None) is steady


def test_what_is_far_from_steady_is_a_straight_line_between_readings():
    time = np.cumsum(RNG.exponential(0.1, 300))
    one = run(time, known_tension_in_n=(np.arange(300) % 3 > 0).astype(float))
    found = on_grid(one, np.ones(300, bool))
    dt = np.median(np.diff(time))
    assert np.diff(found.time_s) == pytest.approx(np.full(len(found) - 1, dt)) and found.time_s[0] == time[0]
    assert time[-1] - 0.5 * dt <= found.time_s[-1] < time[-1] + 0.5 * dt
    assert found.tension_in_n[:-1] == pytest.approx(2.0 * found.time_s[:-1]) and set(found.extra) == {"gap", "known_tension_in_n"}
    marked = np.flatnonzero(found.extra["known_tension_in_n"])
    at = np.unique(np.rint((time[np.arange(300) % 3 > 0] - time[0]) / dt).astype(int).clip(0, len(found) - 1))
    # a straight line turns nowhere: every reading stands for the sample beside it
    assert np.array_equal(marked, at)


@pytest.mark.parametrize(("end", "samples"), [(20.4, 21), (20.6, 22)])
def test_such_a_grid_ends_next_to_the_last_reading(end, samples):
    time = np.append(np.arange(0.0, 20.0, 0.7), end)
    assert len(clock._between(run(time), np.ones(len(time), bool), time, 1.0)) == samples


def test_a_stretch_is_bridged_where_it_is_further_than_two_steps_from_any_reading():
    grid = np.arange(0.0, 20.0)
    # 4 steps apart: the middle is 2 away; 5 apart: 2.5
    time = np.array([0.0, 1.0, 2.0, 3.0, 7.0, 8.0, 9.0, 14.0, 15.0, 16.0, 17.0, 18.0, 19.0])
    assert np.flatnonzero(clock._bridged(grid, time)).tolist() == []
    later = np.where(time > 9.0, time + 0.4, time)
    assert np.flatnonzero(clock._bridged(grid, later)).tolist() == [10, 11, 12, 13]


def test_a_reading_at_a_turn_stands_for_no_other_instant():
    grid = np.arange(0.0, 60.0)
    time = grid + 0.3
    readings = 0.01 * RNG.standard_normal(60) + np.where(np.arange(60) < 30, np.arange(60.0), 60.0 - np.arange(60.0))
    found = clock._marked(grid, time, readings)
    assert np.flatnonzero(found == 0.0).tolist() == [30]
    # exactly at its instant it stands for it
    assert clock._marked(grid, grid, readings).all()


def test_a_moved_reading_may_be_off_where_the_signal_turned():
    moved = np.array([0.1, -0.2, 0.0, 0.3, 0.0, 0.1, 0.2, 0.0])
    rate = np.array([1.0, 1.0, -3.0, -3.0])
    found = blurred(run(np.arange(8.0), early_s=moved), rate, 2)
    assert found == pytest.approx([0.5 * 0.2 * 0.0, 0.5 * 0.3 * 4.0, 0.5 * 0.1 * 4.0, 0.0])
    assert blurred(run(np.arange(8.0)), rate, 2).tolist() == [0.0] * 4


def test_a_corner_is_where_the_lines_meet_by_hand():
    # 2 N a sample up to 3.4 samples, then 1 N a sample down: the lines meet at 6.8 N
    k = np.arange(9.0)
    u = np.where(k <= 3.4, 2.0 * k, 6.8 - (k - 3.4))
    assert cornered(u, 0.5).beyond == pytest.approx([0.0] * 4 + [0.6] + [0.0] * 4) and not cornered(u, 0.5).back.any()
    assert cornered(-u, 0.5).beyond == pytest.approx([0.0] * 4 + [-0.6] + [0.0] * 4)
    # slopes of 4 N/s before and 2 N/s behind it
    assert cornered(u, 0.5).short[4] == pytest.approx(2.0 * np.log(3.0))
    # the same the other way round: the highest sample is the last before the corner, the first one after it 0.2 N below
    late = cornered(u[::-1], 0.5)
    assert late.beyond == pytest.approx([0.0] * 5 + [0.6] + [0.0] * 3) and late.back[5] == pytest.approx(0.2)
    # three samples on either side are needed
    assert [cornered(x, 0.5) is not None for x in (u[1:], u[2:], u[:8], u[:7])] == [True, False, True, False]
    # a corner at a sample is beyond nothing, and a step within a ramp is no turn
    assert cornered(np.minimum(k, 8.0 - k), 0.5) is None and cornered(k - 1.5 * (k > 4), 0.5) is None


@pytest.mark.parametrize(("after", "hidden"), [(6.0, False), (6.9, False), (9.0, True), (4.0, True)])
def test_an_input_goes_on_behind_a_gap_if_it_came_as_far_as_its_rate_takes(after, hidden):
    # 1 N a sample up to 2 N; behind a gap of three samples 4 N on is usual
    u = np.array([0.0, 1.0, 2.0, 3.0, 4.0, 5.0, after, after + 1.0])
    gap = np.array([0, 0, 0, 1, 1, 1, 0, 0], bool)
    assert hiding(gap, u, np.ones(8), 0.0) == ([(3, 6)] if hidden else [])
    # within three standard deviations it is the same
    assert hiding(gap, u, np.ones(8), 1.1) == []


def test_a_gap_behind_which_the_input_comes_back_hides_a_turn():
    u, gap = np.arange(8.0), np.array([1, 0, 0, 1, 1, 0, 0, 0], bool)
    step = np.where(np.arange(8) < 4, 1.0, -1.0)
    assert hiding(gap, u, step, 0.0) == [(3, 5)]
    # a bridge that has bent the last sample before the gap hides nothing
    bent = np.array([-1.0] * 9 + [0.9] + [1.0] * 12)
    away, out = np.concatenate((9.0 - np.arange(10), np.arange(12.0))), (np.arange(22) >= 10) & (np.arange(22) < 12)
    assert hiding(out, away, bent, 0.0) == [(10, 12)]
    # at its ends a record goes on by itself
    assert hiding(gap, u, np.ones(8), 0.0) == hiding(np.arange(8) > 5, u, np.ones(8), 0.0) == []
    assert hiding(np.array([0, 0, 0, 1, 1, 0, 0, 0], bool), np.zeros(8), np.zeros(8), 0.1) == [(3, 5)]
