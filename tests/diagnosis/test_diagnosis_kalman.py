"""The innovations filter's kernels against a dense covariance made by hand."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.special import logsumexp

from sstl_cli.diagnosis.kalman import BOTH_FROM, ERRORS, MEAN_NEW, STATES, TURN, _broken, filtered, gains
from sstl_cli.diagnosis.smoother import LAW, MOVES

N, SIGMA = 6, 0.3
PHASES, OWN = (
    ("slide", "left", "gain", "doubt_n", "jumps_n", "step", "average", "ahead", "steep"),
    ("decay", "fresh", "shown", "both", "mean"),
)


def plain(n: int) -> dict[str, np.ndarray]:
    """Arguments of ``gains`` for an output with white noise alone."""
    zero = np.zeros(n)
    first = np.zeros(n, bool)
    first[0] = True
    return {k: zero.copy() for k in (*PHASES, *OWN, "start")} | {
        "step": np.full(n, np.nan),
        "law": np.zeros((n, LAW)),
        "white_n": np.full(n, SIGMA),
        "keep": np.ones(n, bool),
        "first": first,
    }


def gained(a: dict[str, np.ndarray], left: np.ndarray) -> tuple[np.ndarray, np.ndarray, tuple[Any, ...]]:
    """Phases of the true line, own noise, and what ``gains`` returns, where a model has left something."""
    phases, own = (np.column_stack([a[k] for k in names]) for names in (PHASES, OWN))
    return phases, own, gains(phases, a["law"], own, a["white_n"], a["keep"], a["first"], a["start"], (left, np.empty(0)))


def whitened(a: dict[str, np.ndarray], x: np.ndarray) -> tuple[np.ndarray, float]:
    phases, own, (weights, scale, log_det, _, shift, _) = gained(a, np.zeros(len(x)))
    assert not shift.any()
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


def test_jumps_are_new_at_every_step_of_a_slide_and_kept_in_a_hold() -> None:
    a = plain(N)
    a["slide"][:3] = a["left"][:3] = 1.0
    a["jumps_n"][:] = 0.4
    c = SIGMA**2 * np.eye(N) + 0.4**2 * np.eye(N)
    c[2:, 2:] += 0.4**2 * (np.ones((4, 4)) - np.eye(4))
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


def drawn(rng: np.random.Generator, size: int) -> tuple[np.ndarray, np.ndarray]:
    """A root of a covariance, and the covariance."""
    root = np.tril(rng.standard_normal((size, size)))
    return root, root @ root.T


@pytest.mark.parametrize("seed", range(4))
def test_any_law_and_any_phases_give_the_covariance_of_their_linear_system(seed: int) -> None:
    """Each step has its own transitions, kicks and shares: what all readings are of those kicks is marched step by step."""
    rng, n = np.random.default_rng(seed), 12
    a = plain(n)
    a["first"][7], a["keep"][[3, 9]] = True, False
    a["white_n"], a["start"][[0, 7]] = rng.uniform(0.2, 0.6, n), (0.5, 0.3)
    for k in ("slide", "left"):
        a[k] = rng.uniform(0.1, 0.9, n)
    a["slide"] = np.sort(a["slide"])
    a["gain"], a["decay"], a["shown"] = rng.uniform(0.5, 2.0, n), rng.uniform(0.3, 0.9, n), rng.uniform(0.3, 0.9, n)
    a["decay"][[0, 7]] = a["shown"][[0, 7]] = 0.0
    kicks = 5 * n + 2 * n + n + 2
    # by row: what the error of the input, what is held, the output's own noise and the readings are of all kicks
    error, held, own, read = np.zeros((4, kicks)), np.zeros(kicks), np.zeros(kicks), np.zeros((n, kicks))
    for t in range(n):
        root, new = drawn(rng, 5)
        move, mean = 0.5 * rng.standard_normal((4, 4)), rng.standard_normal(4)
        if a["first"][t]:
            # a record has an input of its own
            move, mean = np.zeros((4, 4)), np.zeros(4)
        both, fresh = drawn(rng, 2)
        a["law"][t, :16], a["law"][t, 16:MOVES], a["law"][t, MOVES:BOTH_FROM] = move.ravel(), mean, new[:4, :4][np.triu_indices(4)]
        a["law"][t, BOTH_FROM:MEAN_NEW], a["law"][t, MEAN_NEW] = new[:4, 4], new[4, 4]
        a["fresh"][t], a["both"][t], a["mean"][t] = fresh[0, 0], fresh[0, 1], fresh[1, 1]
        kick, noise = np.zeros((5, kicks)), np.zeros((2, kicks))
        kick[:, 5 * t : 5 * t + 5], noise[:, 5 * n + 2 * t : 5 * n + 2 * t + 2] = root, both
        into = mean @ error + kick[4]
        if a["first"][t]:
            entering = a["start"][t] + a["gain"][t] ** 2 * float(into @ into)
            held, own = np.zeros(kicks), np.zeros(kicks)
            held[8 * n + (t > 0)] = np.sqrt(entering)
        follows, enters = a["left"][t] * a["gain"][t], a["slide"][t] * a["gain"][t]
        read[t] = enters * into + (1.0 - a["slide"][t]) * held + a["shown"][t] * own + noise[1]
        read[t, 7 * n + t] = a["white_n"][t]
        held, own, error = follows * into + (1.0 - a["left"][t]) * held, a["decay"][t] * own + noise[0], move @ error + kick[:4]
    kept = a["keep"]
    covariance = (read @ read.T)[np.ix_(kept, kept)]
    z, log_det = whitened(a, np.eye(n))
    assert (z.T @ z)[np.ix_(kept, kept)] == pytest.approx(np.linalg.inv(covariance), rel=1e-8, abs=1e-9)
    assert log_det == pytest.approx(np.linalg.slogdet(covariance)[1], rel=1e-9) and not z[~kept].any() and not z[:, ~kept].any()


def test_states_and_columns_stand_where_the_law_has_them() -> None:
    assert (STATES, ERRORS, LAW - 1, BOTH_FROM + ERRORS) == (6, 4, TURN, MEAN_NEW)


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_a_line_is_at_the_larger_one_of_what_it_holds_and_what_its_input_allows(way: float) -> None:
    held, entering, both, step, gain = (0.3 * way, 0.4), (0.1, 0.25), 0.1, 0.2 * way, 1.5
    phase = np.array([1.0, 1.0, 0.0, 9.0, 0.0, step, 0.4 * step, 0.0, gain])
    bent, seen, turned = _broken(phase, held, entering, both)
    draws = np.random.default_rng(0).multivariate_normal((held[0], entering[0]), [[held[1], both], [both, entering[1]]], 400_000)
    line, kept = gain * draws[:, 1], draws[:, 0] - step
    true = way * np.maximum(way * line, way * kept)
    slides = np.mean(way * line > way * kept)
    assert phase[:4] == pytest.approx([slides, slides, gain, 0.0], abs=5e-3)
    # beside the shares of both as they are
    rest = true - (1.0 - slides) * draws[:, 0] - slides * gain * draws[:, 1]
    assert bent == pytest.approx(rest.mean(), abs=5e-3) and seen - bent == pytest.approx((1.0 - slides) * 0.6 * step, abs=5e-3)
    assert np.var((1.0 - slides) * draws[:, 0] + slides * gain * draws[:, 1]) + turned == pytest.approx(np.var(true), rel=1e-2)


def test_a_line_that_surely_slides_or_holds_is_that_of_the_model_or_stays_behind_it() -> None:
    phase = np.array([0.6, 1.0, 2.0, 0.1, 0.0, 5.0, 2.0, 0.0, 2.0])
    assert _broken(phase, (0.0, 0.01), (0.0, 0.01), 0.0) == (0.0, 0.0, 0.0)
    assert phase.tolist() == [0.6, 1.0, 2.0, 0.1, 0.0, 5.0, 2.0, 0.0, 2.0]
    assert _broken(phase, (9.0, 0.01), (0.0, 0.01), 0.0) == (-5.0, -2.0, 0.0)
    assert phase[:4].tolist() == [0.0, 0.0, 2.0, 0.1]
    # a hold that has ended long before the model's
    phase = np.array([0.0, 0.0, 2.0, 0.1, 0.3, 0.0, 0.0, -1.0, 0.5])
    assert _broken(phase, (-3.0, 0.01), (0.0, 0.01), 0.0) == pytest.approx((-1.0, -1.0, 0.0))
    # by what it jumps stays
    assert phase[:5].tolist() == [1.0, 1.0, 0.5, 0.0, 0.3]


def test_a_breakaway_is_as_likely_as_an_integral_over_what_is_held_makes_it() -> None:
    n, spread, steps = 30, 0.5, 0.1
    moved = np.concatenate((np.zeros(10), np.full(20, steps)))
    level = np.linspace(-4.0, 4.0, 4001) * spread
    truth = np.maximum(level[:, None] - np.cumsum(moved), 0.0)
    truth[:, :10] = level[:, None]
    prior = -0.5 * (level / spread) ** 2
    rng, ours, plain_, exact = np.random.default_rng(1), 0.0, 0.0, 0.0
    for _ in range(40):
        held = spread * rng.standard_normal()
        y = np.concatenate((np.full(10, held), np.maximum(held - np.cumsum(moved[10:]), 0.0))) + 0.1 * rng.standard_normal(n)
        exact -= logsumexp(prior - 0.5 * np.sum(((y - truth) / 0.1) ** 2, axis=1)) - logsumexp(prior)
        a = plain(n) | {"white_n": np.full(n, 0.1)}
        a["start"][0] = spread**2
        a["slide"][10:] = a["left"][10:] = a["gain"][:] = a["steep"][:] = 1.0
        for asked in (False, True):
            a["step"][10:] = a["average"][10:] = steps if asked else np.nan
            phases, own, (weights, scale, log_det, _, shift, _) = gained(a, y)
            moves = np.ascontiguousarray(a["law"][:, :MOVES])
            z = filtered((y - shift)[:, None], moves, own, weights, scale, phases, a["first"])
            nats = 0.5 * float(np.sum(z**2)) + 0.5 * log_det - n * np.log(0.1)
            ours, plain_ = (ours + nats, plain_) if asked else (ours, plain_ + nats)
    assert abs(ours - exact) < 0.05 * (plain_ - exact)


def test_what_a_masked_reading_leaves_is_never_looked_at() -> None:
    a = plain(N) | {
        "step": np.full(N, 0.1),
        "average": np.full(N, 0.1),
        "steep": np.ones(N),
        "slide": np.ones(N),
        "left": np.ones(N),
        "gain": np.ones(N),
    }
    a["start"][0], a["keep"][2] = 0.5, False
    ys = (np.array([0.5, 0.4, 0.0, 0.2, 0.1, 0.0]), np.array([0.5, 0.4, np.nan, 0.2, 0.1, 0.0]))
    found = [gained(a, y)[2] for y in ys]
    assert all(np.array_equal(one, other) for one, other in zip(*found, strict=True)) and np.isfinite(found[1][3]).all()
