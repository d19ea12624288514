"""What a channel shows that no tension does: a limit it does not pass, a jump from one end of its range to the other, a fold at zero, a gain that changes."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sstl_cli.identification.gate.causes import GAIN, ZERO_OUT, Causes, best_fit

Array = NDArray[np.float64]
# a limit: spreads of the noise within which a channel rests at its extreme, part of the run and stretches that it must rest in, their least length (s and points)
REST, REST_SHARE, STRETCHES, LEAST_S, LEAST_POINTS = 3.0, 0.05, 2, 0.5, 8
# time (s) after which no slow channel catches up any more, and what the other channel must then go on by (part of its span, and noise)
CAUGHT_UP_S, GOES_ON, NOISES = 0.4, 0.05, 8.0
# rises (part of its span) of the other channel in two rests, and how far apart it must then end: after a true hold it ends at one level
RISES, APART = 0.08, 0.12
# part of its span by which an input turns
TURN = 0.1
# levels of a converter over the span below which an extreme says nothing
COARSE = 0.03
# a jump of a converter that overflows: least part of the span, what the other channel and neighbours may move by, spread of the sizes, and jumps each way
JUMP, STEADY, ALIKE, TURNS = 0.7, 0.1, 0.1, 2
# a gain that changes: parts of the run tried, halvings that follow, what the parts may leave of the whole and of the span, least logarithm, and difference of n theta
CUTS, HALVINGS, LEAVES, LITTLE, CHANGES, SAME = 7, 8, 0.3, 0.05, 0.4, 0.1
# a fold: how near to zero (noise, part of the span) a channel must come, and the part of its way that an output goes against its input as it
# stands and with its sign
NEAR, NEAR_SHARE, MOST_NEAR, AGAINST, WITH, FAR = 8.0, 0.03, 0.1, 0.08, 0.02, 30.0
# what friction must leave (part of the span) for another gain to be sought
ODD = 0.06


@dataclass(frozen=True)
class Shapes:
    """What is wrong with the shape of the channels, NaN where nothing is.

    ``limit_n`` are the levels (N) that input and output do not pass while the other one goes on, ``wrap_n`` the jumps (N) of a
    converter that overflows, ``gain`` the factor by which the output's gain changes at ``gain_at_s``, ``fold_n`` what the output
    reads at no tension where its sign is lost below zero. ``against`` is the part of its way that the output goes against its input.
    """

    limit_n: tuple[float, float] = (math.nan, math.nan)
    wrap_n: tuple[float, float] = (math.nan, math.nan)
    gain: float = math.nan
    gain_at_s: float = math.nan
    fold_n: float = math.nan
    against: float = 0.0


NO_SHAPES = Shapes()


def shapes_of(
    points: tuple[Array, Array, Array], raw: tuple[Array, Array], noise: tuple[float, float], steps: tuple[float, float], causes: Causes
) -> Shapes:
    """Return the shapes of a run; ``points`` are time (s), input and output (N) without spikes and thinned, ``raw`` all samples."""
    t, x, y = points
    against = against_of(x, y, noise)
    limits = (limit_of(t, x, y, noise, steps[0]), limit_of(t, y, x, noise[::-1], steps[1], driven=True))
    wraps = (wrap_of(*raw), wrap_of(*raw[::-1]))
    left = min((c.rms_n for c in (*causes.slips, causes.reversed) if math.isfinite(c.rms_n)), default=0.0)
    fold = _folded(x, y, noise[1])
    if causes.enough or left < ODD * float(np.ptp(y)):
        return Shapes(limits, wraps, fold_n=fold, against=against)
    gain, at = _changed(t, x, y, max(noise[1], 1e-4 * float(np.ptp(y))), left)
    return Shapes(limits, wraps, gain, at, fold, against)


def against_of(x: Array, y: Array, noise: tuple[float, float]) -> float:
    """Return the part of its way that the output goes against the input, from each turn of the input to the next."""
    turns = _turns(x, max(TURN * float(np.ptp(x)), NOISES * noise[0]))
    if len(turns) < 2:
        return 0.0
    way = np.diff(y[turns]) * np.sign(np.diff(x[turns]))
    way = np.where(np.abs(way) > NOISES * noise[1], way, 0.0)
    total = float(np.sum(np.abs(way)))
    return float(-np.sum(np.minimum(way, 0.0))) / total if total > 0.0 else 0.0


def _turns(x: Array, least: float) -> NDArray[np.int64]:
    """Return where a channel turns by more than ``least`` (N), its ends with them."""
    turns, low, high, rising = [0], 0, 0, 0
    for k, v in enumerate(x.tolist()):
        low, high = (k if v < x[low] else low), (k if v > x[high] else high)
        if rising >= 0 and v < x[high] - least:
            turns.append(high)
            low, rising = k, -1
            high = k
        elif rising <= 0 and v > x[low] + least:
            turns.append(low)
            high, rising = k, 1
            low = k
    return np.array([*turns, len(x) - 1], np.int64)


def limit_of(t: Array, v: Array, other: Array, noise: tuple[float, float], step: float = 0.0, driven: bool = False) -> float:
    """Return the level (N) of a channel that it does not pass though the other one goes on, NaN where there is none.

    An input that is held leaves the output where it is; an output (``driven``) rests in backlash, but not at its largest while
    the input grows.
    """
    high = float(np.quantile(v, 0.999))
    if step > COARSE * float(np.ptp(v)):
        return math.nan
    span, reach = float(np.ptp(v)), float(np.ptp(other))
    rest = 2.0 * REST * max(noise[0], 1e-3 * span)
    near = v > high - rest
    if not REST_SHARE < float(np.mean(near)) < 0.9 or span <= 0.0 or reach <= 0.0:
        return math.nan
    # a channel that moves by what counts as rest moves the other one
    band = rest * reach / span
    edges = np.flatnonzero(np.diff(np.concatenate(([False], near, [False])).astype(np.int8)))
    rests = [(a, b) for a, b in zip(edges[::2], edges[1::2], strict=True) if a > 0 and b - a >= LEAST_POINTS and t[b - 1] - t[a] > LEAST_S]
    rests = [(a, b) for a, b in rests if _flat(v[a:b], max(noise[0], 1e-3 * span))]
    if len(rests) < STRETCHES:
        return math.nan
    if driven:
        # in backlash the output stays at its largest while the input comes and goes, but not beyond where it was when it came there
        came = max(float(other[a]) for a, _ in rests)
        went = [float(np.max(other[a:b])) - came for a, b in rests]
    else:
        if _ends_apart([other[a:b] for a, b in rests], band + max(RISES * reach, NOISES * noise[1]), reach):
            return high
        went = [_went_on(t[a:b], other[a:b]) for a, b in rests]
    least = band + max((RISES if driven else GOES_ON) * reach, NOISES * noise[1])
    return high if sum(w > least for w in went) >= max(STRETCHES, 0.5 * len(went)) else math.nan


def _flat(v: Array, spread: float) -> bool:
    """Whether a channel rests at its extreme: what turns there is lower at both ends."""
    inner = v[len(v) // 6 : len(v) - len(v) // 6]
    return float(np.ptp([np.median(part) for part in np.array_split(inner, 3)])) < spread


def _ends_apart(rests: list[Array], least: float, reach: float) -> bool:
    """Whether an output rises while its input rests at its largest, and ends at another level each time."""
    ends = [float(np.max(v)) for v in rests if float(np.max(v) - np.median(v[:3])) > least]
    return len(ends) >= STRETCHES and float(np.ptp(ends)) > APART * max(reach, float(np.median(ends)))


def _went_on(t: Array, other: Array) -> float:
    """Return by how much a channel still rises (N) once no slow channel catches up any more."""
    k = int(np.searchsorted(t, t[0] + CAUGHT_UP_S))
    few = max(1, len(t) // 20)
    return float(np.max(other[k:]) - np.median(other[k : k + few])) if k + few < len(t) else 0.0


def wrap_of(v: Array, other: Array) -> float:
    """Return the size (N) of the jumps from one end of a channel's range to the other and back, NaN where there are none."""
    step, span = np.diff(v), float(np.ptp(v))
    at = np.flatnonzero(np.abs(step) > JUMP * span)
    if span <= 0.0 or len(at) < 2 * TURNS or min(np.count_nonzero(step[at] > 0), np.count_nonzero(step[at] < 0)) < TURNS:
        return math.nan
    size = np.abs(step[at])
    steady = float(np.quantile(np.abs(np.diff(other))[at], 0.9)) < STEADY * float(np.ptp(other))
    # what overflows goes on in the same way; what drops out and comes back rests below
    lively = bool(np.count_nonzero(np.diff(np.unique(v[at + 1]))) > 0.5 * len(at))
    # an overflow is the whole of the range, so that the jump leaves no room beyond it
    return float(np.median(size)) if steady and lively and float(np.ptp(size)) < ALIKE * float(np.median(size)) else math.nan


def _changed(t: Array, x: Array, y: Array, floor: float, whole: float) -> tuple[float, float]:
    """Return the factor by which the output's gain changes, and when (s from the beginning); NaN where no one change explains the run."""
    n = len(t)

    def parts(k: int) -> tuple[float, float, float]:
        a, b = best_fit(x[:k], y[:k], GAIN, floor), best_fit(x[k:], y[k:], GAIN, floor)
        return math.sqrt((k * a.rms_n**2 + (n - k) * b.rms_n**2) / n), b.size - a.size, abs(b.wrap - a.wrap) / max(a.wrap, b.wrap, 1e-9)

    step = n // (CUTS + 1)
    if step < LEAST_POINTS:
        return math.nan, math.nan
    tried = {k: parts(k) for k in range(step, n - step + 1, step)}
    for _ in range(HALVINGS):
        step = max(1, step // 2)
        best = min(tried, key=lambda k: tried[k][0])
        tried.update({k: parts(k) for k in (best - step, best + step) if k not in tried and 2 * LEAST_POINTS < k < n - 2 * LEAST_POINTS})
    best = min(tried, key=lambda k: tried[k][0])
    left, factor, apart = tried[best]
    # the tube stays as it is
    same = apart < SAME
    told = same and left < LEAVES * whole and left < LITTLE * float(np.ptp(y)) and abs(factor) > CHANGES
    return (math.exp(factor), float(t[best])) if told else (math.nan, math.nan)


def _folded(x: Array, y: Array, noise_n: float) -> float:
    """Return what the output reads at no tension once its sign is put back below zero, NaN where that explains nothing.

    An output without its sign goes against its input below zero, which no friction makes it do, and with its sign it does not.
    """
    step = np.abs(np.diff(y))
    # what goes through zero between two samples is no further from it than a step
    step = np.minimum(np.maximum(np.append(step, 0.0), np.insert(step, 0, 0.0)), MOST_NEAR * float(np.max(y)))
    low = y < np.maximum(max(NEAR * noise_n, NEAR_SHARE * float(np.ptp(y))), step)
    if float(np.min(y)) < -NEAR * noise_n or not low.any() or low.all():
        return math.nan
    edges = np.flatnonzero(np.diff(np.concatenate(([False], ~low, [False])).astype(np.int8)))
    signed, ways = np.zeros(len(y)), []
    for a, b in zip(edges[::2], edges[1::2], strict=True):
        # from one touch of zero to the next the output goes either with its input or against it
        ways.append(float(np.sum(np.diff(y[a:b]) * np.sign(np.diff(x[a:b])))))
        signed[a:b] = np.sign(ways[-1]) * y[a:b]
    back, total = -sum(min(w, 0.0) for w in ways), sum(abs(w) for w in ways)
    if not AGAINST * total < back < (1.0 - AGAINST) * total or back < FAR * noise_n or against_of(x, signed, (noise_n, noise_n)) > WITH:
        return math.nan
    size = best_fit(x, signed, ZERO_OUT, max(noise_n, 1e-4 * float(np.ptp(y)))).size
    # a zero within what the sensor is used for
    return size if -2.0 * float(np.max(y)) < size < 0.0 else math.nan
