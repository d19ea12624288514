"""Block means of propagation samples, and RANSAC on them.

RANSAC is written here, not taken from scikit-learn: points have weights and the threshold follows the spread, and 200 tries on 4,096
points take 0.5 ms, ``RANSACRegressor`` 15 ms.
"""

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
# pairs drawn for one that is tried
DRAWN = 4
# up to four times the mean of the distances whose median is sought; few are beyond
BINS = 64


def block_length(n: int, dt_s: float) -> int:
    """Return how many samples make a block: 10 ms, or more in a long run.

    A mean over samples that all propagate lies on the same line, without the smear of a filter.
    """
    return max(1, round(BLOCK_S / dt_s), -(-n // MAX_BLOCKS))


@njit(cache=True, nogil=True)
def _beyond(use: NDArray[np.int8], sign: int, begin: int) -> int:
    """Return the first sample from ``begin`` on that is not of a sign; eight are looked at in one go where they all are."""
    words = use[: use.size // 8 * 8].view(np.int64)
    # eight bytes of 0, 1 or -1
    same = sign * 0x0101010101010101 if sign >= 0 else -1
    k = begin
    while k < use.size and use[k] == sign:
        k += 1
        if k % 8 == 0:
            while k // 8 < words.size and words[k // 8] == same:
                k += 8
    return k


@njit(cache=True, nogil=True)
def block_means(time_s: Array, x: Array, y: Array, use: NDArray[np.int8], sign: int, length: int) -> Array:
    """Return time (from the first sample on), input, output of whole blocks of usable samples of one direction, and the number of their stretch.

    The array has the shape (4, blocks).
    """
    out = np.empty((4, x.size // length + 1))
    count, number = 0, 0
    # a common offset of time must change nothing, not even the last digit
    origin = time_s[0]
    begin = 0
    while begin < x.size:
        if use[begin] != sign:
            begin = _beyond(use, use[begin], begin)
            continue
        end = _beyond(use, sign, begin)
        for first in range(begin, end - length + 1, length):
            part = slice(first, first + length)
            times, inputs, outputs = time_s[part], x[part], y[part]
            t0, sx, sy = 0.0, 0.0, 0.0
            for k in range(length):
                t0 += times[k] - origin
                sx += inputs[k]
                sy += outputs[k]
            out[0, count], out[1, count], out[2, count], out[3, count] = t0 / length, sx / length, sy / length, number
            count += 1
        number += 1
        begin = end
    return out[:, :count].copy()


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
def _cost(x: Array, y: Array, weight: Array, slope: float, bias: float, cap: float, best: float) -> float:
    """Return the weighted sum of squared distances, each capped; one that is above the best need not be whole."""
    s0, s1, s2, s3 = 0.0, 0.0, 0.0, 0.0
    whole = x.size - x.size % 16
    for begin in range(0, whole, 16):
        # four sums do not wait for one another
        for k in range(begin, begin + 16, 4):
            a, b = y[k] - slope * x[k] - bias, y[k + 1] - slope * x[k + 1] - bias
            c, d = y[k + 2] - slope * x[k + 2] - bias, y[k + 3] - slope * x[k + 3] - bias
            s0 += weight[k] * min(a * a, cap)
            s1 += weight[k + 1] * min(b * b, cap)
            s2 += weight[k + 2] * min(c * c, cap)
            s3 += weight[k + 3] * min(d * d, cap)
        if s0 + s1 + s2 + s3 > best:
            return np.inf
    for k in range(whole, x.size):
        a = y[k] - slope * x[k] - bias
        s0 += weight[k] * min(a * a, cap)
    return s0 + s1 + s2 + s3


@njit(cache=True, nogil=True)
def _consensus(x: Array, y: Array, weight: Array, draws: Array, threshold: float) -> tuple[float, float]:
    """Return the line through two points with the smallest weighted sum of squared distances capped at the threshold."""
    total = np.cumsum(weight)
    far = FAR * (np.max(x) - np.min(x))
    best, slope, bias = np.inf, np.nan, np.nan
    tried = 0
    for i in range(draws.shape[0]):
        a = min(np.searchsorted(total, draws[i, 0] * total[-1], "right"), x.size - 1)
        b = min(np.searchsorted(total, draws[i, 1] * total[-1], "right"), x.size - 1)
        dx = x[b] - x[a]
        if abs(dx) < far:
            continue
        if dx != 0.0:
            g = (y[b] - y[a]) / dx
            c = y[a] - g * x[a]
            cost = _cost(x, y, weight, g, c, threshold * threshold, best)
            if cost < best:
                best, slope, bias = cost, g, c
        tried += 1
        if tried == draws.shape[0] // DRAWN:
            break
    return slope, bias


@njit(cache=True, nogil=True)
def _weighted_median(values: Array, weight: Array) -> float:
    """Return the smallest value up to which half of the weight lies; both arrays are overwritten.

    Bins tell with no branch that a processor has to guess about where it is; only what lies in that one is parted.
    """
    half = 0.5 * np.sum(weight)
    mean = np.mean(values)
    scale = BINS / (4.0 * mean) if mean > 1e-300 else 0.0
    bins = np.zeros(BINS + 1)
    for k in range(values.size):
        bins[int(max(min(scale * values[k], BINS), 0.0))] += weight[k]
    below, place = 0.0, 0
    while place < BINS and (bins[place] == 0.0 or below + bins[place] < half):
        below += bins[place]
        place += 1
    first, last = 0, 0
    for k in range(values.size):
        if int(max(min(scale * values[k], BINS), 0.0)) == place:
            values[last], weight[last] = values[k], weight[k]
            last += 1
    while True:
        a, b, c = values[first], values[(first + last) // 2], values[last - 1]
        pivot = max(min(a, b), min(max(a, b), c))
        # smaller ones to the front, larger ones to the back
        left, right, k = first, last, first
        less, equal = 0.0, 0.0
        while k < right:
            v, w = values[k], weight[k]
            if v < pivot:
                values[k], weight[k] = values[left], weight[left]
                values[left], weight[left] = v, w
                less += w
                left += 1
                k += 1
            elif v > pivot:
                right -= 1
                values[k], weight[k] = values[right], weight[right]
                values[right], weight[right] = v, w
            else:
                equal += w
                k += 1
        if below + less >= half and left > first:
            last = left
        elif below + less + equal >= half or right == last:
            return float(pivot)
        else:
            below += less + equal
            first = right


@njit(cache=True, nogil=True)
def _robust(x: Array, y: Array, weight: Array, draws: Array, threshold: float, floor: float, fixed: bool) -> tuple[float, float, float]:
    slope, bias = _consensus(x, y, weight, draws, threshold)
    if not np.isfinite(slope):
        return np.nan, np.nan, threshold
    for _ in range(3):
        slope, bias = _least_squares(x, y, slope, bias, threshold)
        if not fixed:
            middle = _weighted_median(np.abs(y - slope * x - bias), weight.copy())
            threshold = max(4.0 * 1.4826 * middle, floor)
    return slope, bias, threshold


def ransac(
    x: Array, y: Array, threshold: float, floor: float, fixed: bool, draws: Array, weight: Array | None = None
) -> tuple[float, float, float]:
    """Return slope, bias and the inlier threshold of a robust line (NaN where no pair is far enough apart).

    Parameters
    ----------
    x, y : ndarray, shape (n,)
        Points (N).
    threshold : float
        First inlier distance (N); unless ``fixed`` it then follows the spread of the residuals, not below ``floor``.
    draws : ndarray, shape (4 * trials, 2)
        Random numbers of 0 to 1, one pair a try; of the pairs that are far enough apart so many as ``trials`` are tried.
    weight : ndarray, shape (n,), optional
        How much each point counts in the search and in the spread, such as :func:`travel`; by default all alike.
    """
    w = np.ones(len(x)) if weight is None or not weight.any() else weight
    found = _robust(x, y, w, draws, threshold, floor, fixed)
    return float(found[0]), float(found[1]), float(found[2])
