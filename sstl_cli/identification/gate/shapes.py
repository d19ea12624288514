"""What a channel shows that no tension does: a limit it does not pass, a jump from one end of its range to the other, a fold at zero, a gain or a zero that changes."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from sstl_cli.core.stretches import stretches
from sstl_cli.identification.gate import overflows
from sstl_cli.identification.gate.causes import ZERO_OUT, Causes, best_fit, floor_of
from sstl_cli.identification.gate.changes import Change, Recorded, change_of
from sstl_cli.identification.gate.limits import end_of, limits_of
from sstl_cli.identification.gate.movement import NOISES, turns_of
from sstl_cli.identification.gate.parted import Parted, parted_of
from sstl_cli.identification.gate.rests import Rest, rest_of

Array = NDArray[np.float64]
# a fold: how near to zero (noise, part of the span) a channel must come, and the part of its way that an output goes against its input as it
# stands and with its sign
NEAR, NEAR_SHARE, MOST_NEAR, AGAINST, WITH, FAR = 8.0, 0.03, 0.1, 0.08, 0.02, 30.0
# how long (part of the longer neighbour) a channel that lost its sign is near zero, which it goes through as fast as before
PASSES = 0.1
# part of its highest reading by which an input that pulls alone may go below zero (a zero that is off)
BOTH_WAYS = 0.25
# what friction must leave (part of the span) for a change of gain or zero to be sought
ODD = 0.01


@dataclass(frozen=True)
class Shapes:
    """What is wrong with the shape of the channels, NaN where nothing is.

    ``limit_n`` are the levels (N) that input and output do not pass while the other one goes on, ``wrap_n`` the jumps (N) of a
    converter that overflows, ``change`` another gain or zero from one moment on, ``fold_n`` what the output
    reads at no tension where its sign is lost below zero, ``fold_in`` whether the input lost its own, ``rest`` where it rests though friction moves it, ``parted`` where friction becomes that of another bend.
    """

    limit_n: tuple[float, float] = (math.nan, math.nan)
    wrap_n: tuple[float, float] = (math.nan, math.nan)
    change: Change | None = None
    fold_n: float = math.nan
    fold_in: bool = False
    rest: Rest | None = None
    parted: Parted | None = None


NO_SHAPES = Shapes()


def shapes_of(
    points: tuple[Array, Array, Array], raw: tuple[Array, Array], recorded: Recorded, steps: tuple[float, float], causes: Causes
) -> Shapes:
    """Return the shapes of a run; ``points`` are time (s), input and output (N) without spikes and thinned, ``raw`` all samples."""
    noise = recorded.noise
    t, x, y = points
    limits = limits_of(points, noise, steps, causes)
    ends = [end_of(c.values, raw[1 - i][c.at], noise[i], steps[i]) for i, c in enumerate(recorded.channels)]
    limits = (limits[0] if math.isnan(ends[0]) else ends[0], limits[1] if math.isnan(ends[1]) else ends[1])
    over, under = overflows.turns(*raw), overflows.turns(*raw[::-1])
    wraps = (overflows.size_n(raw[0], over), overflows.size_n(raw[1], under))
    left = causes.least_n(float(t[-1] - t[0]))
    fold, rest = _folded(x, y, noise[1]), rest_of(t, x, y, noise, steps[1], causes)
    fold_in = _signed(y, x, noise[::-1], passes=PASSES) is not None
    if causes.enough or rest is not None or any(map(math.isfinite, wraps)):
        # a sensor that stops, or whose number overflows, has no other gain and zero
        return Shapes(limits, wraps, fold_n=fold, fold_in=fold_in, rest=rest)
    change = change_of(t, x, y, recorded, left) if left > ODD * float(np.ptp(y)) else None
    parted = parted_of(points, noise[1], left, causes) if change is None else None
    return Shapes(limits, wraps, change, fold, fold_in, parted=parted)


def against_of(x: Array, y: Array, noise: tuple[float, float]) -> float:
    """Return the part of its way that the output goes against the input, from each turn of the input to the next."""
    turns = turns_of(x, noise[0])
    if len(turns) < 2:
        return 0.0
    way = np.diff(y[turns]) * np.sign(np.diff(x[turns]))
    way = np.where(np.abs(way) > NOISES * noise[1], way, 0.0)
    total = float(np.sum(np.abs(way)))
    return float(-np.sum(np.minimum(way, 0.0))) / total if total > 0.0 else 0.0


def _folded(x: Array, y: Array, noise_n: float) -> float:
    """Return what the output reads at no tension once its sign is put back below zero, NaN where that explains nothing."""
    signed = _signed(x, y, (noise_n, noise_n))
    if signed is None:
        return math.nan
    if float(np.min(x)) < -BOTH_WAYS * float(np.max(x)):
        # friction of a channel that pushes and pulls is another one, and its zero no tension's
        return 0.0
    size = best_fit(x, signed, ZERO_OUT, floor_of(noise_n, y)).size
    # a zero within what the sensor is used for
    return size if -2.0 * float(np.max(y)) < size < 0.0 else math.nan


def _signed(x: Array, y: Array, noise: tuple[float, float], passes: float = math.inf) -> Array | None:
    """Return channel ``y`` with its sign put back below zero, None where that explains nothing.

    A channel without its sign goes against the other one (``x``) below zero, which no friction makes it do, and with its sign it does not.
    Where its sign changes it is near zero for no longer than the part ``passes`` of what is beside.
    """
    noise_n, step = noise[1], np.abs(np.diff(y))
    # what goes through zero between two samples is no further from it than a step
    step = np.minimum(np.maximum(np.append(step, 0.0), np.insert(step, 0, 0.0)), MOST_NEAR * float(np.max(y)))
    low = y < np.maximum(max(NEAR * noise_n, NEAR_SHARE * float(np.ptp(y))), step)
    if float(np.min(y)) < -NEAR * noise_n or not low.any() or low.all():
        return None
    pieces = [(int(a), int(b)) for a, b in stretches(~low)]
    # from one touch of zero to the next a channel goes either with the other one or against it
    ways = [float(np.sum(np.diff(y[a:b]) * np.sign(np.diff(x[a:b])))) for a, b in pieces]
    signed = np.zeros(len(y))
    for (a, b), way in zip(pieces, ways, strict=True):
        signed[a:b] = np.sign(way) * y[a:b]
    turned = [(p, q) for (p, v), (q, w) in pairwise(zip(pieces, ways, strict=True)) if v * w < 0.0]
    if any(q[0] - p[1] > passes * max(p[1] - p[0], q[1] - q[0]) for p, q in turned):
        return None
    back, total = -sum(min(w, 0.0) for w in ways), sum(abs(w) for w in ways)
    if not AGAINST * total < back < (1.0 - AGAINST) * total or back < FAR * noise_n or against_of(x, signed, noise) > WITH:
        return None
    return signed
