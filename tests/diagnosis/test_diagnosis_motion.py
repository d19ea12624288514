"""Runs that a motion drives, on movements of a few samples."""

from __future__ import annotations

import numpy as np
import pytest

from sstl_cli.core.runs import Run
from sstl_cli.diagnosis.constants import BEFORE_TURN, BREAKAWAY_SHARE, EXPLAINED, LEAST_REVERSALS, SWING
from sstl_cli.diagnosis.motion import _sliding, slip_of

STROKE = np.concatenate([np.arange(0.0, 10.0), np.arange(10.0, 0.0, -1.0)])
X = np.append(np.tile(STROKE, 3), 0.0)
WAY = np.sign(np.diff(X, prepend=-1.0))


def run(position=X, out=None, tension=None):
    n = len(X)
    # friction takes away while the position grows: it pulls
    out = 10.0 - 2.0 * WAY if out is None else out
    return Run("r", "act", 0.01 * np.arange(n), np.full(n, 10.0) if tension is None else tension, out, position_in_mm=position)


def test_a_motion_slides_once_it_is_clear_of_its_turning_point():
    # the span is 10: clear after more than 1, over again within 0.2 of the next turning point
    assert _sliding(X[:21]).tolist() == [0.5, 0.5, *[1] * 8, -0.5, -0.5, *[-1] * 8, -0.5]


def test_what_wiggles_less_than_the_clearance_does_not_turn():
    wiggled = X + 0.4 * np.cos(np.pi * np.arange(len(X)))
    slip = _sliding(wiggled)
    assert set(slip[3:9]) == {1.0} and set(slip[13:19]) == {-1.0}


def test_a_motion_that_rests_does_not_slide():
    assert not _sliding(np.full(20, 3.0)).any()


def test_pulling_is_the_way_in_which_friction_takes_away():
    forth, back = slip_of(run(), 1, len(X)), slip_of(run(out=10.0 + 2.0 * WAY), 1, len(X))
    assert np.array_equal(forth, _sliding(X)) and np.array_equal(back, -_sliding(X))


def test_the_motion_is_averaged_to_the_grid_of_the_simulation():
    slip = slip_of(run(), 2, 30)
    assert len(slip) == 30 and set(slip) == {-1.0, -0.5, 0.5, 1.0}


@pytest.mark.parametrize(
    "other",
    [
        run(position=None),
        run(position=np.where(np.arange(len(X)) == 5, np.nan, X)),
        run(position=np.linspace(0.0, 10.0, len(X))),
        run(position=np.full(len(X), 4.0)),
        # the input moves as much as the output: tension drives
        run(tension=10.0 - 2.0 * WAY),
        # the output swings, but not with the direction
        run(out=10.0 + 4.0 * np.sin(np.arange(len(X)))),
    ],
    ids=["no position", "gaps in it", "one stroke", "no motion", "driven by tension", "output of another cause"],
)
def test_tensions_drive_all_other_runs(other):
    assert slip_of(other, 1, len(X)) is None


def test_clear_of_a_turning_point_is_further_than_the_clearance_and_over_before_the_next():
    # a span of 100: clear beyond 10, over within 2 of the end
    x = np.array([0.0, 10.0, 10.5, 50.0, 97.5, 98.5, 100.0, 90.0, 89.5, 0.0])
    assert _sliding(x).tolist() == [0.5, 0.5, 1, 1, 1, 0.5, -0.5, -0.5, -1, -0.5]
    assert (BREAKAWAY_SHARE * 100.0, BEFORE_TURN * 10.0) == (10.0, 2.0)
    # a return by just the clearance is no turn, and the furthest point is where one begins
    assert _sliding(np.array([0.0, 50.0, 40.0, 100.0]))[1:3].tolist() == [1, 1]
    assert _sliding(np.array([0.0, 50.0, 39.0, 100.0])).tolist() == [0.5, -0.5, 0.5, 0.5]
    # beginning with a fall, which a small rise does not hide
    assert _sliding(np.array([50.0, 55.0, 0.0, 100.0, 0.0, 50.0])).tolist() == [-0.5, -0.5, 0.5, -0.5, 0.5, 0.5]


def driven(strokes, swing=4.0, share=1.0):
    """Return a run of so many strokes whose output swings, a share of it by direction, beside an input of unit swing."""
    x = np.append(np.tile(STROKE, (strokes + 1) // 2), 0.0)[: 10 * strokes + 1]
    n = len(x)
    way = np.sign(np.diff(x, prepend=-1.0))
    # a quarter period apart: alike in no stroke
    other = np.sqrt(2.0) * np.sin(2.0 * np.pi * np.arange(n) / 5.0)
    out = 10.0 + swing * (np.sqrt(share) * -way + np.sqrt(1.0 - share) * other)
    tension = 10.0 + np.where(np.arange(n) % 2, 1.0, -1.0)
    return Run("r", "act", 0.01 * np.arange(n), tension, out, position_in_mm=x), n


def test_so_many_reversals_are_motion_and_fewer_are_a_stroke():
    for strokes, seen in ((LEAST_REVERSALS + 1, True), (LEAST_REVERSALS, False)):
        run, n = driven(strokes)
        assert (slip_of(run, 1, n) is not None) is seen


def test_the_output_has_to_swing_more_than_the_input_and_by_the_direction():
    for swing, seen in ((1.05 * SWING, True), (0.95 * SWING, False)):
        run, n = driven(20, swing)
        assert (slip_of(run, 1, n) is not None) is seen
    for share, seen in ((EXPLAINED + 0.06, True), (EXPLAINED - 0.06, False)):
        run, n = driven(20, 8.0, share)
        assert (slip_of(run, 1, n) is not None) is seen
