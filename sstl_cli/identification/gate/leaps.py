"""Where a run goes on from somewhere else at one sample though its output rests, and where both channels change places at one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sstl_cli.identification.filtering import median
from sstl_cli.identification.gate.seam import AROUND, JUMPED, LONG, way_of

Array = NDArray[np.float64]
# share of its span that an input leaps by, alone and where the position or the reference leaps with it; and times that any other step of the run that is
LEAPS, LEAPS_WITH, MANY = 0.1, 0.05, 8.0
# part of its span that an input goes on either side of a leap: a preload and a release at once are at an end
GOES_ON = 0.25
# part of the way from one channel to the other by which they may miss each other's place, times any step around that this way must be, and its least size (share of the wider span)
MISSES, FAR, LEAST = 0.3, 4.0, 0.01
# samples on either side whose median tells where a channel stays
STAYS = 5


@dataclass(frozen=True)
class Leap:
    """By how much (share of its span) the input leaps, when (s), and whether another column that follows it leaps with it."""

    share: float
    at_s: float
    confirmed: bool


@dataclass(frozen=True)
class Crossing:
    """The samples (s) at which both channels went to where the other one was, and how far apart (N) they were at the first."""

    at_s: tuple[float, ...]
    apart_n: float


def leap_of(time_s: Array, x: Array, beside: Sequence[Array | None]) -> Leap | None:
    """Return the one leap of an input, None where it has none or a column ``beside`` it (position, reference) does not take part."""
    step = np.abs(np.diff(x))
    period = np.diff(time_s)
    k = int(np.argmax(np.where(period > LONG * median(period), 0.0, step)))
    columns = [c for c in beside if c is not None and bool(np.isfinite(c).all()) and float(np.ptp(c)) > 0.0]
    with_it = [_leaps(c, k) for c in columns]
    share = _leaps(x, k)
    if not share > (LEAPS_WITH if columns else LEAPS) or not all(v > 0.0 for v in with_it):
        return None
    goes_on = min(float(np.ptp(x[: k + 1])), float(np.ptp(x[k + 1 :]))) > GOES_ON * float(np.ptp(x))
    return Leap(share, float(time_s[k + 1]), bool(columns)) if goes_on and step[k] < JUMPED * way_of(x) else None


def _leaps(v: Array, k: int) -> float:
    """Return by how much (share of its span) a channel leaps for good after sample ``k``, 0 where that is not many times any other step of it."""
    step = np.abs(np.diff(v))
    leap = abs(median(v[k + 1 : k + 1 + STAYS]) - median(v[max(0, k + 1 - STAYS) : k + 1]))
    step[max(0, k - 1) : k + 2] = 0.0
    return leap / float(np.ptp(v)) if leap > MANY * float(step.max(initial=0.0)) else 0.0


def crossing_of(time_s: Array, x: Array, y: Array) -> Crossing | None:
    """Return where both channels change places: friction moves no output against its input, let alone to where that was."""
    apart = x[:-1] - y[:-1]
    missed = np.maximum(np.abs(x[1:] - y[:-1]), np.abs(y[1:] - x[:-1]))
    least = LEAST * max(float(np.ptp(x)), float(np.ptp(y)))
    at = np.flatnonzero((np.abs(apart) > least) & (missed < MISSES * np.abs(apart)))
    steps = (np.abs(np.diff(x)), np.abs(np.diff(y)))
    period = np.diff(time_s)
    usual = median(period)
    found = [int(k) for k in at if period[k] < LONG * usual and _crosses(int(k), (x, y), steps, abs(float(apart[k])))]
    return Crossing(tuple(float(time_s[k + 1]) for k in found), abs(float(apart[found[0]]))) if found else None


def _crosses(k: int, channels: tuple[Array, Array], steps: tuple[Array, Array], apart: float) -> bool:
    """Whether both channels stay where the other one was, and go nowhere as fast around."""
    around = max(float(s[a:b].max(initial=0.0)) for s in steps for a, b in ((max(0, k - AROUND), k), (k + 1, k + AROUND)))
    before, after = ([median(c[part]) for c in channels] for part in (slice(max(0, k + 1 - STAYS), k + 1), slice(k + 1, k + 1 + STAYS)))
    # a channel goes on meanwhile
    stays = all(abs(a - b) < MISSES * apart + STAYS * around for a, b in zip(after, before[::-1], strict=True))
    stays = stays and all(abs(a - b) > 0.5 * apart for a, b in zip(after, before, strict=True))
    return stays and apart > FAR * around
