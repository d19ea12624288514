"""Smoothing that keeps corners, because a play follows the running extreme of noise on its input.

At each sample three local lines give a value: one that ends there, one centred, one that starts
there. Their median averages over straight ramps and stays sharp at corners: on either side of a
corner the line of that side lies between the other two.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def corner_preserving(signal: Array, half: int) -> Array:
    """Return the signal smoothed over ``2 half + 1`` samples without rounding its corners.

    A second pass over the residual takes out the bias that lines have on curved stretches.

    Parameters
    ----------
    signal : ndarray, shape (n,)
    half : int
        Half-width of the window in samples; below 1 is the identity.
    """
    if half < 1 or len(signal) < 4 * half + 4:
        return signal.copy()
    first = _median_of_lines(signal, half)
    return first + _centred(signal - first, half)


def _centred(signal: Array, half: int) -> Array:
    m = 2 * half + 1
    return _moving(_mirrored(signal, half), m) / m


def _median_of_lines(signal: Array, half: int) -> Array:
    n, m = len(signal), 2 * half + 1
    padded = _mirrored(signal, 2 * half)
    x = np.arange(m) - half
    total = _moving(padded, m)
    mean = total / m
    # first moments by running sums: as cheap for wide windows as for narrow ones
    centre = np.arange(len(total)) + half
    slope = (_moving(np.arange(len(padded)) * padded, m) - centre * total) / float((x * x).sum())
    # entry i + half is the window centred at sample i
    at = np.arange(n) + half
    centred = mean[at]
    ends = mean[at - half] + slope[at - half] * half
    starts = mean[at + half] - slope[at + half] * half
    return np.asarray(np.maximum(np.minimum(centred, ends), np.minimum(np.maximum(centred, ends), starts)))


def _mirrored(signal: Array, k: int) -> Array:
    """Return the signal continued at both ends by point reflection, which keeps its slope."""
    return np.concatenate((2 * signal[0] - signal[k:0:-1], signal, 2 * signal[-1] - signal[-2 : -k - 2 : -1]))


def _moving(x: Array, m: int) -> Array:
    total = np.concatenate(([0.0], np.cumsum(x)))
    return np.asarray(total[m:] - total[:-m])


def block_mean(signal: Array, factor: int) -> Array:
    """Return means of blocks of ``factor`` samples (a box anti-alias filter)."""
    if factor == 1:
        return signal
    n = len(signal) // factor * factor
    return np.asarray(signal[:n].reshape(-1, factor).mean(axis=1))
