"""Runs that a motion drives, on movements of a few samples."""

from __future__ import annotations

import numpy as np
import pytest

from sstl_cli.core.runs import Run
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
