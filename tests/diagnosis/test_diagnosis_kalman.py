"""The innovations filter's kernels against a dense covariance made by hand."""

from __future__ import annotations

import numpy as np
import pytest

from sstl_cli.diagnosis.kalman import BOTH_FROM, ERRORS, MEAN_NEW, STATES, TURN, filtered, gains
from sstl_cli.diagnosis.smoother import LAW, MOVES

N, SIGMA = 6, 0.3
PHASES, OWN = ("slide", "left", "gain", "doubt_n"), ("decay", "fresh", "shown", "both", "mean")


def plain(n: int) -> dict[str, np.ndarray]:
    """Arguments of ``gains`` for an output with white noise alone."""
    zero = np.zeros(n)
    first = np.zeros(n, bool)
    first[0] = True
    return {k: zero.copy() for k in (*PHASES, *OWN, "start")} | {
        "law": np.zeros((n, LAW)),
        "white_n": np.full(n, SIGMA),
        "keep": np.ones(n, bool),
        "first": first,
    }


def whitened(a: dict[str, np.ndarray], x: np.ndarray) -> tuple[np.ndarray, float]:
    phases, own = (np.column_stack([a[k] for k in names]) for names in (PHASES, OWN))
    weights, scale, log_det = gains(phases, a["law"], own, a["white_n"], a["keep"], a["first"], a["start"])
    return filtered(x, np.ascontiguousarray(a["law"][:, :MOVES]), own, weights, scale, phases, a["first"]), log_det


def agrees(a: dict[str, np.ndarray], covariance: np.ndarray) -> None:
    z, log_det = whitened(a, np.eye(len(covariance)))
    assert z.T @ z == pytest.approx(np.linalg.inv(covariance), rel=1e-9, abs=1e-9)
    assert log_det == pytest.approx(np.linalg.slogdet(covariance)[1], rel=1e-12)


def test_white_noise_is_divided_by_its_size() -> None:
    agrees(plain(N), SIGMA**2 * np.eye(N))


def test_what_was_read_before_a_hold_is_common_to_all_of_it() -> None:
    a = plain(N)
    a["start"][0] = 0.5
    agrees(a, SIGMA**2 * np.eye(N) + 0.5)


def test_own_noise_of_first_order_is_remembered() -> None:
    a, kept, power = plain(N), 0.8, 2.0
    a["decay"][1:], a["shown"][1:] = kept, kept
    # sampled, not averaged: what is new in the state is all new in the reading
    for k in ("fresh", "both", "mean"):
        a[k][:] = power * (1.0 - kept**2)
        a[k][0] = power
    lag = np.abs(np.subtract.outer(np.arange(N), np.arange(N)))
    agrees(a, SIGMA**2 * np.eye(N) + power * kept**lag)


def test_an_error_of_the_input_enters_while_the_line_slides_and_stays_while_it_holds() -> None:
    a, new, gain = plain(N), 0.7, 1.5
    a["law"][:, MEAN_NEW] = new
    a["gain"][:] = gain
    a["slide"][:3] = a["left"][:3] = 1.0
    c = SIGMA**2 * np.eye(N)
    power = gain**2 * new
    c[:3, :3] += power * np.eye(3)
    # the error of the last slide
    c[2:, 2:] += power * (np.ones((4, 4)) - np.pad(np.ones((1, 1)), (0, 3)))
    agrees(a, c)


def test_a_hold_keeps_the_error_of_the_end_of_its_slide_not_of_its_mean() -> None:
    a, apart, gain = plain(N), 0.4, 1.5
    a["law"][:, TURN], a["gain"][:] = apart, gain
    a["slide"][:] = a["left"][:] = [1.0, 1.0, 1.0, 0.25, 0.0, 0.0]
    c = SIGMA**2 * np.eye(N)
    # three quarters of the slide end with the third sample, all that is left of it with the fourth
    c[3:, 3:] += 0.75 * gain**2 * apart * np.ones((3, 3))
    c[4:, 4:] += gain**2 * apart * np.ones((2, 2))
    agrees(a, c)


def test_a_masked_sample_says_nothing_and_moves_the_state_on() -> None:
    a = plain(N)
    a["start"][0], a["keep"][2] = 0.5, False
    z, log_det = whitened(a, np.eye(N))
    left = np.delete(np.arange(N), 2)
    c = (SIGMA**2 * np.eye(N) + 0.5)[np.ix_(left, left)]
    assert not z[2].any()
    assert not z[:, 2].any()
    assert (z.T @ z)[np.ix_(left, left)] == pytest.approx(np.linalg.inv(c), rel=1e-9)
    assert log_det == pytest.approx(np.linalg.slogdet(c)[1], rel=1e-12)


def test_states_and_columns_stand_where_the_law_has_them() -> None:
    assert (STATES, ERRORS, LAW - 1, BOTH_FROM + ERRORS) == (6, 4, TURN, MEAN_NEW)
