"""The latent input behind a noisy reading: a fixed-interval smoother whose roughness is estimated.

The true input is smooth, except where it is not: its increments have corners and bends of any size (scale mixtures of
normals, West 1987), few where the readings ask for few. Straight lines, curves and holds are averaged over as far as they
reach, and a corner is one large step that costs little. A rougher input than the true one would cost twice: the smoother
would average over less than it could, and state a larger error than it makes. What the readings leave unknown is itself a
Markov chain, so that the error is known in size and passed on, sample by sample, to whatever the input drives.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray
from scipy.special import expit, softmax

from sstl_cli.diagnosis.constants import (
    DECIDES_NATS,
    ELSEWHERE,
    FINEST,
    LATENT_ENOUGH_NATS,
    LATENT_ROUNDS,
    LEAST_SCALE,
    NEAR,
    REACH,
    ROUNDINGS,
    SHORTEST_SMOOTHED,
    STEP_ORDERS,
    STEP_SHARES,
    WIDE,
    WIDE_ROUNDS,
)
from sstl_cli.diagnosis.rests import resting, stopped
from sstl_cli.diagnosis.smoother import CHAIN, Mask, Reading, chain, costs, follow
from sstl_cli.diagnosis.tries import costs_of

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Latent:
    """The smoothed signal, its rate, and what is not known of it; arrays of shape (n,) on the signal's grid.

    ``variance`` is the posterior variance of ``value``; ``chain``, shape (n, 26), the law by which the error moves on (see
    ``smoother``); ``nats`` is minus the log likelihood of the readings (up to a constant); ``doubt`` the standard deviation, beside
    all that, of what depends on whether corners are sharp; ``rounds`` by how many nats the readings like corners better that are
    rounded over each of ``ROUNDINGS`` samples.
    """

    value: Array
    rate: Array
    variance: Array
    chain: Array
    nats: float
    doubt: Array
    rounds: Array


@dataclass(frozen=True)
class Slow:
    """First-order coloured noise of a sensor: standard deviation, in the unit of the signal, and correlation time (s)."""

    sd_n: float
    correlation_s: float

    def kept(self, dt_s: float) -> float:
        """Return what is kept of it over a time (s)."""
        return float(np.exp(-dt_s / self.correlation_s))


WHITE_ONLY = Slow(0.0, 1.0)


@dataclass(frozen=True)
class Told:
    """What the smoother is told: slow noise of the sensor, and over how many samples what drives the signal rounds its corners (0: none)."""

    slow: Slow = WHITE_ONLY
    rounded: float = 0.0


NOTHING = Told()


def latent(signal: Array, dt_s: float, white: float, known: NDArray[np.bool_] | None = None, told: Told = NOTHING) -> Latent:
    """Return the latent signal behind readings with white noise, and what else is told of them.

    Parameters
    ----------
    signal : ndarray, shape (n,)
        Equally spaced readings.
    white : float
        Standard deviation of the white noise, in the unit of the signal.
    known : ndarray of bool, shape (n,), optional
        False where a reading says nothing.
    """
    n = len(signal)
    if not _noisy(signal, white):
        rate = np.gradient(signal, dt_s) if n > 1 else np.zeros(n)
        return Latent(
            np.asarray(signal, np.float64).copy(), rate, np.zeros(n), np.zeros((n, CHAIN)), 0.0, np.zeros(n), np.zeros(len(ROUNDINGS))
        )
    asked = _asked(signal, dt_s, white, known, told.slow)
    likeliest = _likeliest(*asked)
    smooth, value, doubt = likeliest.smooth, likeliest.value, likeliest.doubt
    found = _resting(*asked, _rounded(*asked, smooth, told.rounded) if told.rounded else smooth)
    if told.rounded:
        value, doubt, rounds = found.mean[:, 0], np.zeros(n), np.zeros(len(ROUNDINGS))
    else:
        moved, open_ = _elsewhere(*asked, found)
        value, doubt = value + (found.mean - smooth.mean)[:, 0] + moved, np.hypot(doubt, open_)
        rounds = smooth.nats - costs_of(*asked, [_spread(smooth.steps[0], w) for w in ROUNDINGS], [smooth.steps[1]])
    return Latent(value + signal[0], found.mean[:, 1] / dt_s, found.variance, found.law, found.nats, doubt, rounds)


def nats_of(signal: Array, dt_s: float, white: float, known: NDArray[np.bool_], slow: Slow) -> float:
    """Return the ``nats`` of :func:`latent` alone, which take less than what is not known of the signal."""
    return _likeliest(*_asked(signal, dt_s, white, known, slow)).smooth.nats if _noisy(signal, white) else 0.0


def _noisy(signal: Array, white: float) -> bool:
    """Whether readings have noise, and are enough to be smoothed."""
    return len(signal) >= SHORTEST_SMOOTHED and white > FINEST * float(np.ptp(signal))


def _asked(signal: Array, dt_s: float, white: float, known: NDArray[np.bool_] | None, slow: Slow) -> tuple[Array, Mask, Reading]:
    """Return readings from the first one on, which of them count, and their noise."""
    use = np.ones(len(signal), np.bool_) if known is None else np.asarray(known, np.bool_)
    # what is not there leaves no trace in the law of the error: whoever adds slow noise later adds it to nothing
    noise = Reading(white * white, slow.sd_n * slow.sd_n, slow.kept(dt_s) if slow.sd_n > 0.0 else 0.0)
    return np.ascontiguousarray(signal - signal[0], np.float64), use, noise


@dataclass(frozen=True)
class _Path:
    """A smoothed path: variances of its steps and their scales, (corners, bends), squares of the steps, and what follows."""

    steps: tuple[Array, ...]
    scales: tuple[float, ...]
    squares: Array
    law: Array = field(default_factory=lambda: np.zeros((0, 0)))
    mean: Array = field(default_factory=lambda: np.zeros((0, 0)))
    variance: Array = field(default_factory=lambda: np.zeros(0))
    nats: float = np.inf
    rest: Mask | None = None


@dataclass(frozen=True)
class _Smoothed:
    """The likeliest path, the value along it, shape (n,), and the standard deviation of what depends on whether corners are sharp."""

    smooth: _Path
    value: Array
    doubt: Array


@dataclass(frozen=True)
class _Corners:
    """Corners made whole: variances of all steps, shape (n,), places, and by how many nats the readings like each better than two."""

    variances: Array
    at: NDArray[np.int64]
    nats: Array

    def sharp(self) -> Array:
        """Return the probability that the corner next to each sample is sharp, shape (n,): a drive may round it within a sample or two."""
        p = expit(DECIDES_NATS + self.nats)
        middle = 0.5 * (self.at[1:] + self.at[:-1])
        return np.asarray(p[np.searchsorted(middle, np.arange(len(self.variances)))])


def _likeliest(y: Array, use: Mask, noise: Reading) -> _Smoothed:
    """Return the likeliest path behind readings, and the value along it."""
    # rounds end in the valley in which they began
    found = min((_settled(y, use, noise, start) for start in _starts(y, use, noise.white)), key=lambda path: path.nats)
    value, doubt, corners = found.mean[:, 0], np.zeros(len(y)), _whole_corners(y, use, noise, found)
    if corners is not None:
        squares = found.squares.copy()
        squares[:, 0], squares[:, 1] = np.maximum(2.0 * corners.variances - found.scales[0], 0.0), 0.0
        split, found = value, _settled(y, use, noise, replace(found, squares=squares), WIDE_ROUNDS)
        sharp = corners.sharp()
        value = split + sharp * (found.mean[:, 0] - split)
        doubt = np.sqrt(sharp * (1.0 - sharp)) * np.abs(found.mean[:, 0] - split)
    smooth = _as_smooth(y, use, noise, found)
    return _Smoothed(smooth, value + smooth.mean[:, 0] - found.mean[:, 0], doubt)


def _starts(y: Array, use: Mask, variance: float) -> list[_Path]:
    """Return paths whose steps (of the increment, and of its change) are far below those of the readings, which are noise."""
    typical = [max(_typical_step(y[use], order), LEAST_SCALE * variance) for order in STEP_ORDERS]
    found = []
    for shares in STEP_SHARES:
        scales = tuple(share * step for share, step in zip(shares, typical, strict=True))
        steps = tuple(np.full(len(y), s) for s in scales)
        squares = np.zeros((len(y), 4))
        squares[:, 1], squares[:, 3] = steps
        found.append(_Path(steps, scales, squares))
    return found


def _settled(y: Array, use: Mask, noise: Reading, start: _Path, first: int = 0) -> _Path:
    """Return the path whose steps have the variances that their expected squares ask for, from round ``first`` on."""
    found = start
    for k in range(first, LATENT_ROUNDS):
        before = found.nats if k > first else np.inf
        steps, scales, nats = list(found.steps), list(found.scales), np.inf
        for i in range(2):
            # variances of steps with Cauchy tails given their expected squares, as these would be with another scale: what
            # the readings do not tell follows the scale, a corner that they show does not
            known, open_ = found.squares[:, 2 * i], found.squares[:, 2 * i + 1]
            tries = [0.5 * (f * (scales[i] + open_) + known) for f in (WIDE if k < WIDE_ROUNDS else NEAR)]
            asked = costs_of(y, use, noise, *(tries if j == i else [steps[j]] for j in range(2)))
            best = int(np.argmin(asked))
            steps[i], scales[i], nats = tries[best], WIDE[best] * scales[i], float(asked[best])
        found = replace(_by(y, use, noise, found, steps, nats), scales=tuple(scales))
        if before - nats < LATENT_ENOUGH_NATS:
            break
    return found


def _as_smooth(y: Array, use: Mask, noise: Reading, path: _Path) -> _Path:
    """Return the path whose curvature changes over as many samples as readings allow.

    Rounds that follow the expected squares end with few sharp bends, between which curvature stands still; a curvature that
    changes all the time is as likely, and an error between the bends is then far larger than it is said to be.
    """
    tries = [_spread(path.steps[1], w) for w in ROUNDINGS]
    asked = costs_of(y, use, noise, [path.steps[0]], tries)
    allowed = np.flatnonzero(asked < path.nats + DECIDES_NATS)
    if not len(allowed):
        return path
    return _by(y, use, noise, path, (path.steps[0], tries[allowed[-1]]), float(asked[allowed[-1]]))


def _resting(y: Array, use: Mask, noise: Reading, path: _Path) -> _Path:
    """Return the path that stands still wherever its readings like that better."""
    steps = (path.steps[0], path.steps[1])
    rest = resting(y, use, noise, steps, (path.mean[:, 0], path.variance), _places(path))
    if not rest.any():
        return path
    steps = stopped(steps, rest)
    law, drive = chain(y, use, noise, steps[0], steps[1], rest)
    mean, variance, _ = follow(law, drive)
    return replace(path, steps=steps, law=law, mean=mean, variance=variance, rest=rest)


def _rounded(y: Array, use: Mask, noise: Reading, path: _Path, width: float) -> _Path:
    """Return the path whose corners may go on in the steps beside them."""
    steps = (_spread(path.steps[0], width), path.steps[1])
    return _by(y, use, noise, path, steps, float(costs(y, use, noise, steps[0], steps[1]).sum()))


def _by(y: Array, use: Mask, noise: Reading, path: _Path, steps: Sequence[Array], nats: float) -> _Path:
    """Return the path by other variances of its steps, which the readings like by ``nats``."""
    law, drive = chain(y, use, noise, steps[0], steps[1])
    mean, variance, squares = follow(law, drive)
    return replace(path, steps=tuple(steps), squares=squares, law=law, mean=mean, variance=variance, nats=nats)


def _spread(corners: Array, width: float) -> Array:
    """Return variances of steps of which each goes on beside it, as behind a drive that lags by so many samples.

    Such a drive turns what was one step into steps that fall off exponentially; where it began is not known.
    """
    reach = min(int(np.ceil(REACH * width)), (len(corners) - 1) // 2)
    share = np.exp(-2.0 * np.abs(np.arange(-reach, reach + 1)) / width)
    return np.convolve(corners, share / share.sum(), mode="same")


def _whole_corners(y: Array, use: Mask, noise: Reading, path: _Path) -> _Corners | None:
    """Return the corners, each of them whole; None where none is split.

    A corner near a sample may end as two halves, one in the step before and one in the step after: from there no round leads to
    either, though one large step costs less than two. Steps have Cauchy tails: a normal of variance v, which has the prior
    v^(-3/2) exp(-s / 2 v) with the scale s. Each pair is made one where that and the readings until the next pair ask for it.
    """
    mean, scale, old = path.mean, path.scales[0], path.steps[0]
    step = np.zeros(len(y))
    step[1:] = mean[1:, 1] - mean[:-1, 1] - mean[:-1, 2]
    less = np.minimum(np.abs(step[:-1]), np.abs(step[1:])) * (step[:-1] * step[1:] > 0.0)
    beside = np.concatenate(([0.0], less, [0.0]))
    pairs = np.flatnonzero((less**2 > scale) & (less >= beside[:-2]) & (less > beside[2:]))
    if not len(pairs):
        return None

    def prior(v: Array) -> Array:
        return np.asarray((0.5 + 1.0) * np.log(v) + scale / (2.0 * v))

    usual, known = 0.5 * scale, costs(y, use, noise, path.steps[0], path.steps[1])
    gains, told = [], []
    for place in (0, 1):
        new = old.copy()
        new[pairs + place], new[pairs + 1 - place] = usual + 0.5 * (step[pairs] + step[pairs + 1]) ** 2, usual
        more = costs(y, use, noise, new, path.steps[1]) - known
        told.append(-np.add.reduceat(more, pairs))
        gains.append(told[-1] - (prior(new) - prior(old))[pairs] - (prior(new) - prior(old))[pairs + 1])
    best = np.argmax(gains, axis=0)
    better = np.max(gains, axis=0) > 0.0
    if not better.any():
        return None
    likes = np.choose(best, told)[better]
    whole, pairs, best = old.copy(), pairs[better], best[better]
    whole[pairs + best], whole[pairs + 1 - best] = usual + 0.5 * (step[pairs] + step[pairs + 1]) ** 2, usual
    return _Corners(whole, pairs, likes)


def _elsewhere(y: Array, use: Mask, noise: Reading, path: _Path) -> tuple[Array, Array]:
    """Return by how much the path is another if its corners may be a few samples away, and the standard deviation of that, shape (n,).

    A path holds each corner to one sample, and is as sure beside it as if that were known. Each place has the probability that
    the readings until the next corner give it.
    """
    n, steps = len(y), path.steps
    at = _places(path)
    if not len(at):
        return np.zeros(n), np.zeros(n)
    known = costs(y, use, noise, steps[0], steps[1], path.rest)
    gains, means = [np.zeros(len(at))], [path.mean[:, 0]]
    for by in (b for b in range(-ELSEWHERE, ELSEWHERE + 1) if b):
        corners = steps[0].copy()
        corners[at], corners[at + by] = steps[0][at + by], steps[0][at]
        gains.append(-np.add.reduceat(costs(y, use, noise, corners, steps[1], path.rest) - known, at - ELSEWHERE))
        means.append(follow(*chain(y, use, noise, corners, steps[1], path.rest))[0][:, 0])
    p = softmax(gains, axis=0)[:, np.searchsorted((at[1:] + at[:-1]) // 2, np.arange(n))]
    values = np.array(means) - path.mean[:, 0]
    moved = np.sum(p * values, axis=0)
    return moved, np.sqrt(np.sum(p * (values - moved) ** 2, axis=0))


def _places(path: _Path) -> NDArray[np.int64]:
    """Return the steps that are corners, beyond what is open of them: the largest, so far apart that none can take another's place."""
    known, open_ = path.squares[:, 0], path.squares[:, 1] + path.scales[0]
    large = np.flatnonzero(known[ELSEWHERE:-ELSEWHERE] > open_[ELSEWHERE:-ELSEWHERE]) + ELSEWHERE
    free, found = np.ones(len(known), bool), []
    for k in large[np.argsort(-known[large], kind="stable")]:
        if free[k]:
            found.append(k)
            free[max(k - 2 * ELSEWHERE, 0) : k + 2 * ELSEWHERE + 1] = False
    return np.sort(np.array(found, np.int64))


def _typical_step(y: Array, order: int) -> float:
    """Return the median square of differences of an order."""
    return float(np.median(np.diff(y, order) ** 2)) if len(y) > 2 * order else 0.0


def block_mean(signal: Array, factor: int) -> Array:
    """Return means of blocks of ``factor`` samples (a box anti-alias filter)."""
    if factor == 1:
        return signal
    n = len(signal) // factor * factor
    return np.asarray(signal[:n].reshape(-1, factor).mean(axis=1))
