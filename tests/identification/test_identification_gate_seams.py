"""Several seams in one run are told; a movement that goes its way by jumps has none."""

from __future__ import annotations

import numpy as np
import pytest
from identification_loops import play
from identification_slips import lines

from sstl_cli.core.runs import Run
from sstl_cli.identification import gate
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
