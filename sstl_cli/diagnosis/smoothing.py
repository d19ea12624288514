"""Smoothing that keeps corners, because a play follows the running extreme of noise on its input.

At each sample three local lines give a value: one that ends there, one centred, one that starts
there. Their median averages over straight ramps and stays sharp at corners: on either side of a
corner the line of that side lies between the other two.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Widths = NDArray[np.int64]
# RMS of a whole residual over the white noise; one sample, and means over a stretch, in standard errors
EXCESS = 1.06
POINT_LIMIT = 5.0
MEAN_LIMIT = 4.5


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


def smoothed(signal: Array, halves: Widths) -> Array:
    """Return the signal smoothed with a half-width of its own at each sample, shape (n,)."""
    out = signal.copy()
    for half in np.unique(halves):
        here = halves == half
        out[here] = corner_preserving(signal, int(half))[here]
    return out


def half_widths(signal: Array, white: float, candidates: Sequence[int]) -> Widths:
    """Return for each sample the widest smoothing whose residual is still only noise there.

    A dwell that is shorter than the window loses its corners, and a play holds what the extreme was: rounding
    far below the noise of one sample would shift whole held stretches.

    Parameters
    ----------
    signal : ndarray, shape (n,)
    white : float
        RMS of its white noise, in its unit.
    candidates : sequence of int
        Half-widths in samples, widest first.
    """
    halves = np.zeros(len(signal), np.int64)
    undecided = np.ones(len(signal), bool)
    started = False
    for half in candidates:
        if half < 1 or len(signal) < 4 * half + 4:
            continue
        residual = signal - corner_preserving(signal, half)
        # the window as a whole has to fit before it is looked at sample by sample
        if not started and np.sqrt(np.mean(residual**2)) > EXCESS * white:
            continue
        started = True
        unlike = np.abs(residual) > POINT_LIMIT * white
        for width in {max(half // 2, 3), half + 1}:
            mean = np.abs(_moving(np.pad(residual, (width // 2, width - 1 - width // 2)), width)) / width
            unlike |= mean > MEAN_LIMIT * max(1.4826 * float(np.median(mean)), white / np.sqrt(width))
        fits = undecided & (_moving(np.pad(unlike.astype(float), half), 2 * half + 1) < 0.5)
        halves[fits] = half
        undecided &= ~fits
        if not undecided.any():
            break
    return halves


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
    """Return the signal continued at both ends by point reflection, which keeps its slope.

    It is reflected at the end of a local line: at the first sample itself its noise would stay in full.
    """
    first, last = _line_end(signal[k::-1]), _line_end(signal[-k - 1 :])
    return np.concatenate((2 * first - signal[k:0:-1], signal, 2 * last - signal[-2 : -k - 2 : -1]))


def _line_end(stretch: Array) -> float:
    n = len(stretch)
    x = np.arange(n) - (n - 1) / 2
    return float(stretch.mean() + (x @ stretch) / (x @ x) * x[-1]) if n > 2 else float(stretch[-1])


def _moving(x: Array, m: int) -> Array:
    total = np.concatenate(([0.0], np.cumsum(x)))
    return np.asarray(total[m:] - total[:-m])


def block_mean(signal: Array, factor: int) -> Array:
    """Return means of blocks of ``factor`` samples (a box anti-alias filter)."""
    if factor == 1:
        return signal
    n = len(signal) // factor * factor
    return np.asarray(signal[:n].reshape(-1, factor).mean(axis=1))
