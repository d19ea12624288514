"""Where an input stands still, as its readings have it.

A line holds the extreme of its input. A smoothed path that wanders by its own error about a level at which the input stood takes
the line beyond that level, always to the same side; of a level no extreme is further out than another.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from sstl_cli.diagnosis.constants import DECIDES_NATS, DOUBT_NATS, ELSEWHERE, SHORTEST_SMOOTHED
from sstl_cli.diagnosis.smoother import Mask, Reading, costs

Array = NDArray[np.float64]


def resting(y: Array, use: Mask, noise: Reading, steps: tuple[Array, Array], path: tuple[Array, Array], corners: NDArray[np.int64]) -> Mask:
    """Return where the readings like a level better than a path, shape (n,): between corners, or anywhere else at 49 to 1.

    Parameters
    ----------
    y, use, noise
        Readings, which of them count, and their noise.
    steps : tuple of ndarray, shape (n,)
        Variances of the steps of the path's increment and of its change.
    path : tuple of ndarray, shape (n,)
        The smoothed value, and its variance.
    corners : ndarray of int
        The steps that are corners.
    """
    (value, variance), n, found = path, len(y), np.zeros(len(y), np.bool_)
    typical = float(np.median(variance))
    if typical <= 0.0:
        return found
    beyond = 2.0 * DOUBT_NATS
    ends = np.concatenate(([-ELSEWHERE], corners, [n + ELSEWHERE]))
    between = [(int(a) + ELSEWHERE + 1, int(b) - ELSEWHERE) for a, b in zip(ends[:-1], ends[1:], strict=True)]
    near = [w for w in between if w[1] - w[0] > 1 and (value[w[1] - 1] - value[w[0]]) ** 2 < beyond * (variance[w[1] - 1] + variance[w[0]])]
    # over how many samples the error of a path lasts: for less it hardly wanders
    lasts = max(noise.white / typical, 1.0 / (1.0 - noise.memory))
    least = max(round(2.0 * lasts), SHORTEST_SMOOTHED + 2 * (ELSEWHERE + 1))
    windows = sorted(levels(value, float(np.sqrt(beyond * typical)), least), key=lambda w: w[0] - w[1])
    # without corners at its ends a level may be anywhere along the record
    elsewhere = [(w, DECIDES_NATS + float(np.log(n / (w[1] - w[0])))) for w in windows]
    for (a, b), odds in [*((w, 0.0) for w in near), *elsewhere]:
        if not found[a:b].any():
            # what comes before and after a rest says as well whether it was one
            told = slice(max(a - (b - a) // 2, 0), b + (b - a) // 2)
            part = (steps[0][told], steps[1][told])
            found[told] |= _still(y[told], use[told], noise, part, (a - told.start, b - told.start), odds)
    return found


def stopped(steps: tuple[Array, Array], rest: Mask) -> tuple[Array, Array]:
    """Return variances of steps of which there are none in a rest."""
    return np.where(rest, 0.0, steps[0]), np.where(rest, 0.0, steps[1])


def _still(y: Array, use: Mask, noise: Reading, steps: tuple[Array, Array], level: tuple[int, int], odds: float) -> Mask:
    """Return which part of a level the readings like better as a rest; of those that they like as well the shortest.

    Behind a drive that lags the input comes to rest some time after it has come near, and leaves it as slowly.
    """
    tried: list[tuple[float, Mask]] = []
    (begin, end), later, known = level, 0, float(costs(y, use, noise, steps[0], steps[1]).sum())
    while 2 * later + SHORTEST_SMOOTHED < end - begin and 2 * later <= (end - begin) // 2:
        rest = np.zeros(len(y), np.bool_)
        rest[begin + later : end - later] = True
        corners, bends = stopped(steps, rest)
        tried.append((known - float(costs(y, use, noise, corners, bends, rest).sum()), rest))
        later = max(2 * later, ELSEWHERE + 1)
    best = max((gain for gain, _ in tried), default=0.0)
    likely = [rest for gain, rest in tried if gain > max(best - DECIDES_NATS, odds)]
    return likely[-1] if likely else np.zeros(len(y), np.bool_)


@njit(cache=True, nogil=True)
def levels(value: Array, band: float, least: int) -> list[tuple[int, int]]:
    """Return all windows, none inside another, of at least so many samples in which a signal keeps within a band."""
    # empty, but of a type that the compiler knows
    found = [(0, 0) for _ in range(0)]
    begin, low, high = 0, value[0], value[0]
    for k in range(1, value.size + 1):
        if k < value.size and max(high, value[k]) - min(low, value[k]) <= band:
            low, high = min(low, value[k]), max(high, value[k])
            continue
        if k - begin >= least:
            found.append((begin, k))
        if k == value.size:
            break
        # back from here as far as the signal was within the band with this sample
        low = high = value[k]
        begin = k
        while begin > 0 and max(high, value[begin - 1]) - min(low, value[begin - 1]) <= band:
            begin -= 1
            low, high = min(low, value[begin]), max(high, value[begin])
    return found
