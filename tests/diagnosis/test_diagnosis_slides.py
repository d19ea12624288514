"""Where a simulated line slides, and where it breaks away."""

from __future__ import annotations

import numpy as np
import pytest

from sstl_cli.diagnosis.slides import SHIFT_N, STEEPEST, Grid, breakaways, phases_of
from sstl_cli.physics.transmission.play import play_operator

PULL, RELEASE, SPAN = 0.5, 2.0, 12


def test_phases_are_the_share_of_sliding_and_the_mean_slope():
    u = np.array([0.0, 1.0, 2.0, 3.0, 3.0, 3.0, 0.0, 1.0])
    slope = np.array([0.5, 0.5, 0.5, 0.5, 0.5, 0.0, 2.0 * STEEPEST, -1.0])
    here = np.array([0.0, 0.5, 1.0, 1.25, 1.25, 1.25, 7.0, 8.0])
    rest = u, np.full(8, 0.5), Grid(np.array([0, 6, 8]), np.array([0, 3, 4]), np.array([2, 2]))
    slide, left, gain = phases_of(here, here + SHIFT_N * slope, *rest, np.array([False, False]))
    # of a slide that slackens nothing is left that was held; an input that rests asks for nothing; of two runs none follows the other
    assert slide == pytest.approx([0.5, 1.0, 0.0, 0.0]) and left == pytest.approx([1.0, 1.0, 0.0, 0.0])
    assert gain == pytest.approx([0.5, 0.5, 0.25, 0.5 * STEEPEST])
    driven, _, _ = phases_of(here, here, *rest, np.array([True, False]))
    assert driven.tolist() == [1.0, 1.0, 1.0, 0.0]
    assert phases_of(here, here * np.nan, *rest, np.array([False, False]))[2].tolist() == [0.0] * 4


def test_a_slide_counts_from_the_reading_that_it_has_reached_and_what_it_leaves_is_held():
    u = np.array([0.0, 0.0, 0.4, 0.4, 0.4, 0.4])
    # a tenth of the way to the third reading is left of what the line had to wait for
    here = np.array([0.0, 0.0, 0.02, 0.02, 0.02, 0.02])
    whole, gain = np.array([False]), here + SHIFT_N * 0.5
    slide, left, _ = phases_of(here, gain, u, np.full(6, 0.5), Grid(np.array([0, 6]), np.array([0, 3]), np.array([2])), whole)
    assert slide.tolist() == left.tolist() == [0.0, 1.0, 0.0]
    # the mean is half of the hold before, the end is none of it
    slide, left, _ = phases_of(here, gain, u, np.full(6, 1.0 / 3.0), Grid(np.array([0, 6]), np.array([0, 2]), np.array([3])), whole)
    assert slide == pytest.approx([1.0 / 3.0, 0.0]) and left.tolist() == [1.0, 0.0]


def broken(u: np.ndarray, start: float, factor: int = 1, driven: bool = False) -> tuple[np.ndarray, ...]:
    """Phases, outputs and breakaways of a play operator."""
    here, moved = (play_operator(u + by, PULL, 0.0, RELEASE, 0.0, start) for by in (0.0, SHIFT_N))
    n = len(u) // factor
    grid = Grid(np.array([0, len(u)]), np.array([0, n]), np.array([factor]))
    told = np.array([driven])
    share = np.full(len(u), 1.0 / factor)
    phases = phases_of(here, moved, u, share, grid, told)
    return here, phases[1], breakaways(here, u, share, phases, (np.array([0]), np.array([start])), grid, told)


def test_a_line_that_slides_moves_and_lies_beyond_what_is_held_before_it_does():
    u = np.concatenate((np.linspace(4.0, 10.0, SPAN), np.linspace(10.0, 1.0, SPAN)[1:]))
    here, left, found = broken(u, start=3.0)
    step, average, ahead, gain = found.T
    slides = left > 0.5
    assert slides[[SPAN - 1, -1]].all() and not slides[[0, 1, SPAN, SPAN + 1]].any()
    assert step[slides] == pytest.approx(np.diff(here, prepend=3.0)[slides])
    assert set(gain[slides].round(9)) == {PULL, RELEASE} and not ahead[slides].any() and np.array_equal(average[slides], step[slides])
    # in the holds before them the lines are where the input would put them
    waits = ~slides & (step == 0.0)
    lines = np.where(np.arange(len(u)) < SPAN, PULL, RELEASE) * u
    assert ahead[waits] == pytest.approx((lines - here)[waits]) and np.count_nonzero(waits) > 4


def test_a_start_that_the_input_has_elsewhere_has_broken_away():
    u = np.linspace(1.0, 9.0, SPAN)
    # its release line is at 2
    clamped, free = broken(u, start=2.5)[2], broken(u, start=1.5)[2]
    assert clamped[0].tolist() == pytest.approx([-0.5, -0.5, 0.0, RELEASE])
    # where it may start, it waits for the line on which it slides
    assert free[0].tolist() == pytest.approx([0.0, 0.0, PULL * 1.0 - 1.5, PULL])


def test_a_hold_that_ends_in_no_slide_and_a_line_that_a_motion_drives_are_not_asked():
    u = np.concatenate((np.linspace(4.0, 5.0, SPAN), np.linspace(5.0, 4.5, SPAN)))
    assert np.isnan(broken(u, start=3.0)[2][:, 0]).all()
    assert np.isnan(broken(np.linspace(1.0, 9.0, SPAN), start=1.5, driven=True)[2][:, 0]).all()


def test_a_step_of_several_samples_moves_by_what_its_end_does():
    u = np.linspace(4.0, 15.0, 2 * SPAN)
    here, left, found = broken(u, start=3.0, factor=2)
    ends = here[1::2]
    slides = left > 0.5
    assert found[slides, 0] == pytest.approx(np.diff(ends, prepend=3.0)[slides])
    means = here.reshape(-1, 2).mean(axis=1) - np.concatenate(([3.0], ends[:-1]))
    assert found[slides, 1] == pytest.approx(means[slides])
    waits = ~slides
    assert found[waits, 2] == pytest.approx((PULL * u[1::2] - ends)[waits])


def test_an_answer_that_is_no_number_breaks_away_nowhere():
    u = np.linspace(1.0, 9.0, SPAN)
    here = np.where(np.arange(SPAN) > 5, np.inf, 0.5 * u)
    grid, still = Grid(np.array([0, SPAN]), np.array([0, SPAN]), np.array([1])), np.array([False])
    found = breakaways(here, u, np.ones(SPAN), (np.ones(SPAN),) * 3, (np.array([0]), np.array([0.1])), grid, still)
    assert np.isfinite(found[:6]).all() and np.isnan(found[6:, 0]).all()
