"""Several seams in one run are told; a movement that goes its way by jumps has none."""

from __future__ import annotations

import numpy as np
import pytest
from identification_loops import play
from identification_slips import lines

from sstl_cli.core.runs import Run
from sstl_cli.identification import gate
from sstl_cli.identification.gate.leaps import leap_of
from sstl_cli.identification.gate.seam import seam_of

T = np.arange(4000) / 100.0


def recorded(x, y):
    scatter = 0.02 * np.random.default_rng(1).standard_normal((2, len(x)))
    return Run("r", "act", np.arange(len(x)) / 100.0, x + scatter[0], y + scatter[1])


def joined(x, y):
    return "joined" in [r.rule for r in gate.remarks([recorded(x, y)])]


@pytest.mark.parametrize("order", [(0, 2, 1, 3), (0, 3, 2, 1), (2, 1, 3, 0)])
def test_blocks_of_rows_in_another_order_are_told(order):
    x = 2.0 + 8.0 * (1.0 - np.cos(2.0 * np.pi * T / 6.2))
    y = play(x, lines(0.3))
    rows = np.concatenate([np.arange(1000 * k, 1000 * (k + 1)) for k in order])
    assert joined(x[rows], y[rows])
    assert not joined(x, y)


def test_blocks_whose_jumps_are_most_of_the_way_are_told_and_steps_with_slow_ones_between_are_not():
    # most of the way between the joints is gone by them
    x = 2.0 + 8.0 * (1.0 - np.cos(2.0 * np.pi * T / 21.0))
    y = play(x, lines(0.3))
    ends = [0, 700, 1300, 2200, 2900, 4000]
    rows = np.concatenate([np.arange(ends[k], ends[k + 1]) for k in (0, 3, 2, 1, 4)])
    assert joined(x[rows], y[rows])
    assert not joined(x, y)
    steps = np.array([4.0, 12.0, 22.0, 9.0, 17.0, 5.0])[(T / 7.0).astype(int) % 6] + 0.3 * np.sin(T)
    assert not joined(steps, play(steps, lines(0.3)))


@pytest.mark.parametrize(
    "x",
    [
        4.0 + 18.0 * (T / 5.0 % 1.0),
        np.array([4.0, 12.0, 22.0, 9.0, 17.0, 5.0])[(T / 3.0).astype(int) % 6],
        np.where(T % 10.0 < 5.0, 4.0 + 1.6 * (T % 5.0), 22.0 - 1.6 * (T % 5.0)),
    ],
)
def test_a_movement_in_steps_has_no_seam(x):
    assert not joined(x, play(x, lines(0.3)))


def test_an_input_in_steps_whose_output_rests_has_no_seam():
    x = np.array([4.0, 12.0, 22.0, 9.0, 17.0, 5.0])[(T / 3.0).astype(int) % 6]
    scatter = 0.02 * np.random.default_rng(1).standard_normal((2, len(T)))
    assert seam_of(T, (x + scatter[0], 3.0 + scatter[1]), (18.0, 0.1))[0][1] <= 0.0


SLOW = 3.0 + 9.0 * (1.0 - np.cos(2.0 * np.pi * T / 9.7))


def without(run, first, number):
    """Return a run some rows of which are lost, under a clock that does not know of it."""
    kept = np.r_[0:first, first + number : len(run)]
    return Run(run.run_id, run.system, run.time_s[: len(kept)], run.tension_in_n[kept], run.tension_out_n[kept])


@pytest.mark.parametrize("number", [100, 150])
def test_rows_lost_while_the_output_rests_are_told_by_the_input_alone(number):
    # from its highest on the input goes back within the backlash
    whole = recorded(SLOW, play(SLOW, lines(0.6)))
    lost = without(whole, 500, number)
    assert float(np.ptp(whole.tension_out_n[495 : 500 + number])) < 0.15
    assert [r.rule for r in gate.remarks([whole])] == []
    said = [r for r in gate.remarks([lost]) if r.rule == "joined"]
    assert said and "rows were probably lost" in said[0].sentence and "at 5 s" in said[0].sentence


def test_a_preload_in_one_step_and_a_sensor_that_was_tared_are_no_lost_rows():
    preload = np.where(T < 1.5, 0.5, SLOW)
    assert leap_of(T, preload, ()) is None
    assert leap_of(T, np.where(T < 6.0, SLOW, SLOW + 5.0), ()) is not None
    tared = recorded(SLOW, play(SLOW, lines(0.6)))
    tared.tension_in_n[500:] += 5.0
    assert "joined" not in [r.rule for r in gate.remarks([tared])]


@pytest.mark.parametrize("ends", [(1700, 4000), (2100, 2480)])
def test_channels_that_change_places_within_a_run_are_told_where_they_do(ends):
    run = recorded(SLOW, play(SLOW, lines(0.3)))
    a, b = ends
    run.tension_in_n[a:b], run.tension_out_n[a:b] = run.tension_out_n[a:b].copy(), run.tension_in_n[a:b].copy()
    first = gate.remarks([run])[0]
    assert first.rule == "swapped" and first.failed and f"exchanged from {a / 100:.4g} s" in first.sentence
    assert (f"to {b / 100:.4g} s" in first.sentence) is (b < 4000)
