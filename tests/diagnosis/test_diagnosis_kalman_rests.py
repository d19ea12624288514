"""A line that jumps and rests while its model slides, against dense covariances and probabilities made by hand."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import pytest
from scipy.stats import norm

from sstl_cli.diagnosis.kalman import _further, filtered, gains
from sstl_cli.diagnosis.smoother import LAW, MOVES

SIGMA, JUMP, STEP = 0.05, 1.0, 0.25


@dataclass(frozen=True)
class Seen:
    """What the filter makes of an output beside a model that slides by ``STEP`` a step after a hold."""

    z: np.ndarray
    log_det: float
    beyond: np.ndarray
    place: np.ndarray
    scale: np.ndarray

    @property
    def nats(self) -> float:
        return 0.5 * float(self.z @ self.z) + 0.5 * self.log_det


def seen(
    output: np.ndarray,
    model: np.ndarray,
    jump: float = JUMP,
    sticks: bool = True,
    keep: np.ndarray | None = None,
    ahead: np.ndarray | None = None,
) -> Seen:
    """Return what the filter makes of it; ``ahead`` is how far beyond what it holds the line of a model lies that will slide."""
    n = len(output)
    moved = np.diff(model, prepend=model[0])
    slides = (moved != 0.0).astype(float)
    phases = np.zeros((n, 9))
    phases[:, 0] = phases[:, 1] = slides
    phases[:, 2] = phases[:, 8] = 1.0
    phases[:, 4] = jump * slides
    phases[:, 5] = phases[:, 6] = np.where(slides > 0.0, moved, np.nan)
    if ahead is not None:
        holds = np.isfinite(ahead)
        phases[holds, 5], phases[holds, 6], phases[holds, 7] = 0.0, 0.0, ahead[holds]
        phases[:, 4] = jump
    first = np.zeros(n, bool)
    first[0] = True
    law, own, white = np.zeros((n, LAW)), np.zeros((n, 5)), np.full(n, SIGMA)
    keep = np.ones(n, bool) if keep is None else keep
    residual = output - model
    weights, scale, log_det, beyond, shift, place = gains(
        phases, law, own, white, keep, first, np.full(n, 1e-4), (residual, output if sticks else np.empty(0))
    )
    z = filtered((residual[place] - shift)[:, None], np.ascontiguousarray(law[:, :MOVES]), own, weights, scale, phases, first)
    return Seen(z[:, 0], log_det, beyond, place, scale)


def sawtooth(n: int, every: int, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Return readings that follow a model in jumps, ``every`` so many steps, and the model."""
    model = np.concatenate((np.zeros(5), STEP * np.arange(n)))
    jumps = np.zeros(len(model), int)
    jumps[5:] = np.arange(n) // every * every
    read = np.where(np.arange(len(model)) < 5, 0.0, model[5 + jumps])
    return read + SIGMA * np.random.default_rng(seed).standard_normal(len(model)), model


def test_rests_are_found_and_one_line_holds_all_of_each() -> None:
    read, model = sawtooth(60, 6)
    found = seen(read, model)
    # after each jump the line stays where it is, and is compared with what the model was there
    jumped = 5 + np.arange(0, 60, 6)
    assert all(found.place[at] == at for at in jumped[1:])
    assert all((found.place[at + 1 : at + 6] == at).all() for at in jumped[1:])
    still = SIGMA**2 * np.eye(6) + JUMP**2
    rest = read[jumped[1] : jumped[1] + 6] - model[jumped[1]]
    z = found.z[jumped[1] : jumped[1] + 6]
    assert z @ z == pytest.approx(rest @ np.linalg.solve(still, rest), rel=1e-3)
    assert 30.0 < found.z @ found.z < 100.0


def test_what_moments_cost_is_part_of_the_log_determinant() -> None:
    read, model = sawtooth(60, 6)
    found = seen(read, model)
    assert found.log_det == pytest.approx(-2.0 * np.log(found.scale).sum() + found.beyond.sum()) and found.beyond.sum() > 10.0
    assert (found.beyond[6:] > 0.0).all()


@pytest.mark.parametrize("off", [0.0, 0.6, 1.2])
def test_a_sawtooth_about_the_mean_is_as_likely_with_its_own_jumps_as_one_below_it(off: float) -> None:
    """Jumps beyond the mean are rests as well: the line waits for the model to come past."""
    read, model = sawtooth(240, 12)
    read = read + off
    nats = {jump: seen(read, model, jump).nats for jump in (0.2, 0.8, 1.6, 6.4)}
    assert nats[0.2] > nats[0.8] + 100.0 and np.ptp([nats[j] for j in (0.8, 1.6, 6.4)]) < 100.0
    assert nats[6.4] < seen(read, model, 0.8, sticks=False).nats - 300.0
    resting = seen(read, model, 1.6)
    assert np.mean(resting.place[20:] != np.arange(len(read))[20:]) > 0.8 and np.abs(resting.z[20:]).max() < 5.0


@pytest.mark.parametrize("over", [-1.0, 0.0, 1.0, 2.0])
def test_a_line_that_rested_off_the_model_at_a_turn_breaks_away_where_it_does(over: float) -> None:
    up, back = STEP * np.arange(1, 61), 15.0 + 3.0 - 0.15 * np.arange(1, 61)
    model = np.concatenate((np.zeros(5), up, np.minimum(15.0, back)))
    line = np.concatenate((np.zeros(5), up[np.arange(60) // 6 * 6], np.minimum(15.0 + over, back)))
    line[59:65] = 15.0 + over
    far = np.where(
        (np.arange(len(model)) >= 65) & (np.diff(model, prepend=0.0) == 0.0), np.concatenate((np.zeros(65), back - 15.0)), np.nan
    )
    found = seen(line + SIGMA * np.random.default_rng(0).standard_normal(len(line)), model, ahead=far)
    assert np.abs(found.z[65:]).max() < 4.0


def test_what_is_said_of_rests_is_what_their_probabilities_cost() -> None:
    read, model = sawtooth(18, 6)
    found, counts, nats = seen(read, model), np.full((2, 2), 0.5), 0.0
    stood, level = 1, 0.0
    for t in range(6, len(read)):
        far, near = (model[t] - level) / JUMP, (model[t - 1] - level) / JUMP
        stays = counts[stood, 1] / counts[stood].sum() * norm.sf(far) / norm.sf(near)
        rests = int(found.place[t] != t)
        nats -= 2.0 * math.log(stays if rests else 1.0 - stays)
        counts[stood, rests] += 1.0
        if not rests:
            level = read[t]
        stood = rests
    assert found.beyond.sum() == pytest.approx(nats, rel=0.05) and nats > 10.0
    assert found.beyond[:6].tolist() == [0.0] * 6


def test_a_line_that_rests_is_much_likelier_so_than_one_that_scatters() -> None:
    read, model = sawtooth(200, 10)
    assert seen(read, model).nats < seen(read, model, sticks=False).nats - 200.0
    # but not where its jumps are far larger than the law allows
    assert seen(read, model, jump=0.1).nats > seen(read, model).nats + 100.0


def test_a_line_that_slides_pays_little_for_the_rests_that_it_might_have_had() -> None:
    model = np.concatenate((np.zeros(5), STEP * np.arange(400)))
    read = model + SIGMA * np.random.default_rng(1).standard_normal(len(model))
    assert seen(read, model, 0.0).nats == pytest.approx(seen(read, model, 0.0, sticks=False).nats)
    for jump in (0.02, 0.2):
        with_rests, without = seen(read, model, jump), seen(read, model, jump, sticks=False)
        assert (with_rests.place == np.arange(len(read))).mean() > 0.99
        assert -1.0 < with_rests.nats - without.nats < 8.0


def test_a_hold_of_the_model_goes_on_with_a_rest_and_masked_readings_say_nothing() -> None:
    read, model = sawtooth(12, 6)
    model = np.concatenate((model, np.full(10, model[-1])))
    read = np.concatenate((read, np.full(10, read[11:17].mean()) + SIGMA * np.random.default_rng(2).standard_normal(10)))
    found = seen(read, model)
    assert (found.place[12:] == 11).all() and not found.beyond[17:].any() and np.abs(found.z[12:]).max() < 4.0
    keep = np.ones(len(read), bool)
    keep[13:15] = False
    masked = seen(np.where(keep, read, 99.0), model, keep=keep)
    assert (masked.place[12:] == 11).all() and not masked.z[13:15].any() and not masked.beyond[13:15].any()
    assert np.abs(masked.z[15:]).max() < 4.0


def test_a_line_that_turns_stands_first() -> None:
    """Where a model turns without a hold, what stays is what was reached."""
    up = STEP * np.arange(1, 13)
    model = np.concatenate((np.zeros(5), up, up[-1] - up))
    read = np.concatenate((np.zeros(5), up, np.full(4, up[-1]), (up[-1] - up)[4:]))
    read = read + SIGMA * np.random.default_rng(3).standard_normal(len(model))
    found = seen(read, model)
    assert (found.place[17:21] == 16).all() and (found.place[21:] == np.arange(21, len(read))).all()


@pytest.mark.parametrize(("far", "near"), [(0.5, 0.2), (3.0, -1.0), (-0.2, -0.4)])
def test_how_likely_a_rest_goes_on_is_what_a_normal_leaves(far: float, near: float) -> None:
    assert _further(far, near, 0.7) == pytest.approx(norm.sf(far / 0.7) / norm.sf(near / 0.7), rel=1e-12)
    # a model that comes back to the line lets it rest, one without jumps never
    assert _further(near, far, 0.7) == 1.0 and _further(far, near, 0.0) == 0.0 and _further(99.0, 98.0, 0.7) == 0.0
