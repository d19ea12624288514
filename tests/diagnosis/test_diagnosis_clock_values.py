"""Clocks, bridges and turns by hand, at their thresholds."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from sstl_cli.core.runs import Run
from sstl_cli.diagnosis import clock
from sstl_cli.diagnosis.clock import before, cornered, hiding, since_first, tops


def run(time, values=None, **extra):
    values = np.asarray(time, float) if values is None else values
    return Run("r", "act", np.asarray(time, float), values, values, extra=extra)


def test_a_bridge_is_marked_by_one_and_all_else_by_nothing():
    # the middle of a stretch of five steps is two and a half from any reading, of one of four two
    time = np.array([0.0, 1.0, 2.0, 6.0, 7.0, 12.0, 13.0])
    assert clock._bridged(np.arange(14.0), time).tolist() == [0.0] * 14
    time[-2:] += 0.125
    assert clock._bridged(np.arange(14.0), time).tolist() == [0.0] * 8 + [1.0] * 4 + [0.0] * 2


@pytest.mark.parametrize(
    ("begun", "since"), [((5.0, 0.0, 12.0), [5.0, 0.0, 12.0]), ((4.0, 0.0, 12.0), [4.0, 0.0, 12.0]), ((3.9, 0.0, 12.0), [0.0] * 3)]
)
def test_a_clock_went_on_where_no_run_began_before_the_last_one_ended(begun, since):
    runs = [run(b + np.arange(5.0)) for b in begun]
    assert since_first(runs) == since and since_first(runs[:1]) == [0.0]


def test_what_went_before_is_of_the_same_kind_and_began_earlier():
    assert before([1.0, 2.0, 4.0, 8.0], [3.0, 0.0, 1.0, 3.0], ["a", "a", "b", "a"]) == [2.0, 0.0, 0.0, 2.0]


def test_a_top_between_samples_is_that_of_the_parabola_and_half_a_sample_off_at_most():
    for shift in (0.0, 0.3, -0.3, 0.499):
        x = np.arange(7.0) - 3.0 - shift
        beyond, most = tops(5.0 - 2.0 * x**2)
        # shift squared by half of the curvature of 4; an eighth of that at most
        assert beyond == pytest.approx([0.0] * 3 + [2.0 * shift**2] + [0.0] * 3) and most == pytest.approx([0.0] * 3 + [0.5] + [0.0] * 3)
        down, most = tops(2.0 * x**2)
        assert down[3] == pytest.approx(-2.0 * shift**2) and most[3] == pytest.approx(0.5)
    assert not np.any(tops(np.arange(5.0)))


@pytest.mark.parametrize("dt", [0.5, 0.25])
@pytest.mark.parametrize("at", [3.6, 4.3])
def test_a_corner_lies_where_chords_on_both_sides_meet(dt, at):
    k = np.arange(10.0)
    u = np.where(k <= at, 3.0 * k, 3.0 * at - 2.0 * (k - at))
    found = cornered(u, dt)
    top, place = int(np.argmax(u)), int(np.ceil(at))
    assert np.flatnonzero(found.beyond).tolist() == [place] and found.beyond[place] == pytest.approx(3.0 * at - u[top])
    assert found.back[place] == pytest.approx(u[top] - u[place]) and found.short[place] == pytest.approx(2.0 / dt * np.log(2.5))
    # behind a drive the extreme is so much nearer, and never on the other side of the sample
    assert found.moved(0.0)[place] == pytest.approx(3.0 * at - u[place])
    lag = 0.5 * found.beyond[place] / found.short[place]
    assert found.moved(lag)[place] == pytest.approx(found.back[place] + 0.5 * found.beyond[place])
    assert found.moved(9.0)[place] == pytest.approx(found.back[place])
    low = cornered(-u, dt)
    assert low.beyond[place] == pytest.approx(-found.beyond[place]) and low.moved(lag)[place] == pytest.approx(-found.moved(lag)[place])
    assert low.short == pytest.approx(found.short)


def test_a_smooth_turn_leaves_its_tangents_before_they_meet():
    x = np.arange(11.0) - 5.2
    assert cornered(9.0 - x**2, 0.1) is None


def test_the_rate_of_an_input_beside_a_gap_is_the_mean_of_five_samples_and_no_others():
    gap = (np.arange(40) >= 20) & (np.arange(40) < 24)
    u = np.arange(40.0)
    step = np.ones(40)
    # what was before the last five and is behind the first five counts for nothing
    step[:15], step[29:] = -99.0, -99.0
    assert hiding(gap, u, step, 0.0) == []
    for at, hidden in ((15, True), (19, True), (24, True), (28, True), (14, False), (29, False)):
        other = step.copy()
        other[at] = -99.0
        assert (hiding(gap, u, other, 0.0) == [(20, 24)]) is hidden, at
    # nor does what lies behind another gap
    two = gap | ((np.arange(40) >= 26) & (np.arange(40) < 30))
    other = np.ones(40)
    other[26:30] = -99.0
    assert (20, 24) not in hiding(two, u, other, 0.0)


def test_an_input_that_rests_on_one_side_of_a_gap_may_have_turned_there():
    gap = (np.arange(20) >= 8) & (np.arange(20) < 12)
    assert hiding(gap, np.arange(20.0), np.where(np.arange(20) < 10, 1.0, 0.0), 9.0) == [(8, 12)]


@pytest.mark.parametrize(("off", "steady"), [(0.49, True), (0.51, False)])
def test_stamps_within_half_a_step_of_a_steady_clock_are_its_own(off, steady):
    time = np.arange(200.0)
    time[::2] += off
    time[1::2] -= off
    time[[0, -1]] = [0.0, 199.0]
    found = clock._steady(time, 1.0)
    assert (found is not None) is steady
    if found is not None:
        assert found == pytest.approx(np.arange(200.0), abs=0.02)


@pytest.mark.parametrize(("late", "inner"), [(0.0, 0), (0.02, 1)])
def test_the_ends_of_a_grid_to_which_readings_were_moved_are_left_out(late, inner):
    time = np.delete(np.arange(300.0), [100, 101, 102, 103, 104, 105])
    time = time + late * np.random.default_rng(1).choice([-1.0, 1.0], len(time))
    found = clock.on_grid(run(time, 5.0 + 0.01 * np.random.default_rng(0).standard_normal(len(time))), np.ones(len(time), bool))
    assert len(found) == 300 - 2 * inner and found.time_s[0] == pytest.approx(inner, abs=0.05)
    assert np.flatnonzero(found.extra["gap"]).tolist() == list(range(100 - inner, 106 - inner))
    assert found.extra["early_s"].max() == pytest.approx(late, abs=5e-3)


def test_marks_go_with_their_readings():
    time = np.delete(np.arange(300.0), [100, 101, 102, 103, 104, 105])
    known = (np.arange(len(time)) % 3 == 0).astype(float)
    one = replace(run(time, np.sin(time / 40.0)), extra={"known_tension_in_n": known})
    found = clock.on_grid(one, np.ones(len(time), bool))
    places = np.rint(time).astype(int)[known > 0.5]
    assert np.flatnonzero(found.extra["known_tension_in_n"]).tolist() == places.tolist() and found.extra["known_tension_in_n"].max() == 1.0
    assert found.tension_out_n[places] == pytest.approx(np.sin(places / 40.0), abs=1e-3)
