"""Block means of propagation samples, and RANSAC on them."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]
MAX_BLOCKS = 4096
BLOCK_S = 0.01
# of the points of one direction: half a window over which travel is measured
TRAVEL_PARTS = 64
# of the span: two points nearer than this make no line
FAR = 0.2


def block_length(n: int, dt_s: float) -> int:
    """Return how many samples make a block: 10 ms, or more in a long run.

    A mean over samples that all propagate lies on the same line, without the smear of a filter.
    """
    return max(1, round(BLOCK_S / dt_s), -(-n // MAX_BLOCKS))


@njit(cache=True, nogil=True)
def block_means(
    time_s: Array, x: Array, y: Array, use: NDArray[np.int8], sign: int, length: int
) -> tuple[Array, Array, Array, NDArray[np.int64]]:
    """Return time, input, output of whole blocks of usable samples of one direction, and their stretch."""
    out = np.empty((3, x.size // length + 1))
    stretch = np.empty(x.size // length + 1, np.int64)
    count, have, number = 0, 0, 0
    t0, sx, sy = 0.0, 0.0, 0.0
    for k in range(x.size):
        if use[k] != sign:
            if have > 0 or (k > 0 and use[k - 1] == sign):
                number += 1
            have = 0
            continue
        if have == 0:
            t0, sx, sy = 0.0, 0.0, 0.0
        t0 += time_s[k]
        sx += x[k]
        sy += y[k]
        have += 1
        if have == length:
            out[0, count], out[1, count], out[2, count] = t0 / length, sx / length, sy / length
            stretch[count] = number
            count += 1
            have = 0
    return out[0, :count].copy(), out[1, :count].copy(), out[2, :count].copy(), stretch[:count].copy()


@njit(cache=True, nogil=True)
def _least_squares(x: Array, y: Array, slope: float, bias: float, threshold: float) -> tuple[float, float]:
    """Return the least-squares line through the points within the threshold of a line."""
    n, sx, sy = 0, 0.0, 0.0
    for k in range(x.size):
        if abs(y[k] - slope * x[k] - bias) <= threshold:
            n += 1
            sx += x[k]
            sy += y[k]
    if n < 3:
        return slope, bias
    mx, my = sx / n, sy / n
    sxx, sxy = 0.0, 0.0
    for k in range(x.size):
        if abs(y[k] - slope * x[k] - bias) <= threshold:
            sxx += (x[k] - mx) ** 2
            sxy += (x[k] - mx) * (y[k] - my)
    if sxx <= 0.0:
        return slope, bias
    return sxy / sxx, my - sxy / sxx * mx


@njit(cache=True, nogil=True)
def travel(y: Array, stretch: NDArray[np.int64]) -> Array:
    """Return how far the output goes per point (N), shape (n,): a centred difference within its stretch.

    A loop rounded by presliding dwells long on a nearly level approach to its line. Counted by samples the
    approach outvotes the line; counted by the output's travel it cannot.
    """
    n = y.size
    reach = max(1, n // TRAVEL_PARTS)
    out = np.zeros(n)
    begin = 0
    while begin < n:
        end = begin
        while end + 1 < n and stretch[end + 1] == stretch[begin]:
            end += 1
        for k in range(begin, end + 1):
            a, b = max(k - reach, begin), min(k + reach, end)
            if b > a:
                out[k] = abs(y[b] - y[a]) / (b - a)
        begin = end + 1
    return out


@njit(cache=True, nogil=True)
def _consensus(x: Array, y: Array, weight: Array, picks: NDArray[np.int64], threshold: float) -> tuple[float, float]:
    """Return the line through two points with the smallest weighted sum of squared distances capped at the threshold."""
    best, slope, bias = np.inf, np.nan, np.nan
    cap = threshold * threshold
    for i in range(picks.shape[0]):
        a, b = picks[i, 0], picks[i, 1]
        dx = x[b] - x[a]
        if dx == 0.0:
            continue
        g = (y[b] - y[a]) / dx
        c = y[a] - g * x[a]
        cost = 0.0
        for k in range(x.size):
            r = y[k] - g * x[k] - c
            cost += weight[k] * min(r * r, cap)
            if cost > best:
                break
        if cost < best:
            best, slope, bias = cost, g, c
    return slope, bias


def ransac(
    x: Array, y: Array, threshold: float, floor: float, fixed: bool, trials: int, rng: np.random.Generator, weight: Array | None = None
) -> tuple[float, float, float]:
    """Return slope, bias and the inlier threshold of a robust line (NaN where no pair is far enough apart).

    Parameters
    ----------
    x, y : ndarray, shape (n,)
        Points (N).
    threshold : float
        First inlier distance (N); unless ``fixed`` it then follows the spread of the residuals, not below ``floor``.
    weight : ndarray, shape (n,), optional
        How much each point counts in the search and in the spread, such as :func:`travel`; by default all alike.
    """
    w = np.ones(len(x)) if weight is None or not weight.any() else weight
    span = float(np.ptp(x))
    total = np.cumsum(w)
    picks = np.searchsorted(total, rng.random((4 * trials, 2)) * total[-1], side="right").clip(max=len(x) - 1)
    far = np.flatnonzero(np.abs(x[picks[:, 0]] - x[picks[:, 1]]) >= FAR * span)[:trials]
    slope, bias = _consensus(x, y, w, picks[far], threshold)
    if not np.isfinite(slope):
        return np.nan, np.nan, threshold
    for _ in range(3):
        slope, bias = _least_squares(x, y, slope, bias, threshold)
        if not fixed:
            threshold = max(4.0 * 1.4826 * _weighted_median(np.abs(y - slope * x - bias), w), floor)
    return slope, bias, threshold


def _weighted_median(values: Array, weight: Array) -> float:
    order = np.argsort(values)
    total = np.cumsum(weight[order])
    return float(values[order[np.searchsorted(total, 0.5 * total[-1])]])
