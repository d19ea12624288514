"""How the input moves, sample by sample: whether two runs went the same way, on which clock, and what the output gives in its loops."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]
# a movement shows in that many points, and at the most in twice as many
POINTS = 128
# part by which one recording may begin later in a movement, and part of the shorter one that must be compared
SHIFT, LEAST = 0.1, 0.4
# part of the samples beyond either end between which the middle of an input lies
TAIL = 0.02
# part of its span, and noises, by which a channel must go back to have turned
TURN, NOISES = 0.1, 8.0
# part of its span that a channel must go one way for that way to tell anything
WAY = 0.5


@dataclass(frozen=True)
class Movement:
    """Means of the input (N) over ``block`` samples, a power of two."""

    means: tuple[float, ...]
    block: int

    def over(self, block: int) -> Array:
        """Return the means over a longer block."""
        v, times = np.array(self.means), block // self.block
        return np.asarray(v[: len(v) // times * times].reshape(-1, times).mean(axis=1), np.float64)


NO_MOVEMENT = Movement((), 1)


def movement_of(x: Array) -> Movement:
    """Return how an input moves."""
    block = 2 ** max(0, int(math.log2(len(x) / POINTS))) if len(x) else 1
    n = len(x) // block * block
    return Movement(tuple(x[:n].reshape(-1, block).mean(axis=1).tolist()), block)


def unlike(a: Movement, b: Movement, faster: float = 1.0) -> float:
    """Return what one movement, played ``faster``, leaves of another, whatever their scale: 0 where they are the same, 1 where they have nothing in common."""
    block = max(a.block, b.block)
    first, second = a.over(block), b.over(block)
    if min(len(first), len(second)) < POINTS // 4:
        return 1.0
    at = faster * (np.arange(len(first)) + 0.5) - 0.5
    most = int(SHIFT * len(second))
    left = [1.0]
    for shift in range(-most, most + 1):
        inside = (at + shift >= 0.0) & (at + shift <= len(second) - 1)
        if np.count_nonzero(inside) < LEAST * min(len(first), len(second) / faster):
            continue
        u, v = first[inside], np.interp(at[inside] + shift, np.arange(len(second)), second)
        if float(np.std(u)) * float(np.std(v)) > 0.0:
            left.append(math.sqrt(max(1.0 - max(float(np.corrcoef(u, v)[0, 1]), 0.0) ** 2, 0.0)))
    return min(left)


@njit(cache=True, nogil=True)
def turns_by(x: Array, least: float) -> NDArray[np.int64]:
    """Return where a channel turns by more than ``least`` (N), its ends with them."""
    turns, low, high, rising = [0], 0, 0, 0
    for k in range(len(x)):
        v = x[k]
        low, high = (k if v < x[low] else low), (k if v > x[high] else high)
        if rising >= 0 and v < x[high] - least:
            turns.append(high)
            low, rising = k, -1
            high = k
        elif rising <= 0 and v > x[low] + least:
            turns.append(low)
            high, rising = k, 1
            low = k
    turns.append(len(x) - 1)
    return np.array(turns, np.int64)


def turns_of(x: Array, noise_n: float) -> NDArray[np.int64]:
    """Return where a channel turns beyond its noise (N), its ends with them."""
    return turns_by(np.ascontiguousarray(x), max(TURN * float(np.ptp(x)), NOISES * noise_n))


def ways_of(v: Array, noise_n: float) -> tuple[float, float]:
    """Return the longest rise and the longest fall of a channel beyond noise (N), in parts of its span."""
    ways, span = np.diff(v[turns_of(v, noise_n)]), float(np.ptp(v))
    return (max(0.0, float(np.max(ways))) / span, max(0.0, -float(np.min(ways))) / span) if span > 0.0 else (0.0, 0.0)


def both_ways(v: Array, noise_n: float) -> float:
    """Return the part of its span that a channel goes up as well as down.

    What is pulled alone, or released alone, goes one way: friction, gain and zero are then one line, and no law is told from another one.
    """
    return min(ways_of(v, noise_n))


def loop_work(x: Array, y: Array, noise_n: float = 0.0) -> float:
    """Return what an output gives in closed loops of its input, as a share of the input's way times the output's span, 0 without a loop.

    Between two passages of the middle in one direction any law without memory gives nothing; friction takes. An input that lingers there passes
    it again and again by its noise (N) alone: a passage counts where the input turned between it and the last one.
    """
    middle = 0.5 * float(np.quantile(x, TAIL) + np.quantile(x, 1.0 - TAIL))
    above, ends = x >= middle, turns_of(x, noise_n)
    up, down = np.flatnonzero(above[1:] & ~above[:-1]), np.flatnonzero(~above[1:] & above[:-1])
    # from one turn to the next a movement passes the middle once, whatever noise adds
    ways = [(int(a), int(b), bool(x[b] > x[a])) for a, b in pairwise(ends)]
    passages = [
        [int(p[(p >= a) & (p < b)][0]) for a, b, rises in ways if rises is way and np.any((p >= a) & (p < b))]
        for p, way in ((up, True), (down, False))
    ]
    closed = [p for p in passages if len(p) > 1]
    if not closed:
        return 0.0
    first, last = max(((p[0], p[-1]) for p in closed), key=lambda p: p[1] - p[0])
    parts = [(middle - x[k]) / (x[k + 1] - x[k]) for k in (first, last)]
    begun, ended = ((1.0 - part) * y[k] + part * y[k + 1] for part, k in zip(parts, (first, last), strict=True))
    u = np.concatenate(([middle], x[first + 1 : last + 1], [middle]))
    v = np.concatenate(([begun], y[first + 1 : last + 1], [ended]))
    # of an output that rests in its loops the noise and creep are no work: it is measured by all that it goes
    way, span = float(np.sum(np.abs(np.diff(u)))), float(np.ptp(y))
    # an output that comes back to another level than it began at may have had what it gives in store: at most that over the input's range
    stored = abs(float(ended - begun)) * float(np.ptp(u))
    return (float(np.sum(0.5 * (v[1:] + v[:-1]) * np.diff(u))) - stored) / (way * span) if way * span > 0.0 else 0.0
