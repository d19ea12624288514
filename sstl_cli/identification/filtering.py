"""Spikes, noise level and the zero-phase Butterworth low-pass, compiled for two channels at once."""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]
# a handful of thousand triples give the noise level to 2 %; all of them would cost more than the filter
NOISE_TRIPLES = 4096
# noise bandwidth of a second-order Butterworth run forwards and backwards, over its cut-off
NOISE_BANDWIDTH = 0.83
# a channel that begins or ends amid a movement may go this much faster there than it does elsewhere; the part of its steps left out
TWICE, FASTEST = 2.0, 0.02
# two samples behind each end that are not those of the other
LEAST_ENDS = 6


def noise_sd(signal: Array) -> float:
    """Return the standard deviation of the white part of the noise from second differences.

    Examples
    --------
    >>> bool(abs(noise_sd(np.random.default_rng(0).normal(0, 2, 20000)) - 2) < 0.1)
    True
    """
    n = len(signal) - 2
    if n < 1:
        return 0.0
    k = np.arange(0, n, max(1, n // NOISE_TRIPLES))
    second = np.abs(signal[k] - 2.0 * signal[k + 1] + signal[k + 2])
    middle = float(np.median(second)) / 0.6745
    if middle == 0.0:
        # coarse quantisation: more than half of the differences vanish
        middle = 1.2533 * float(np.mean(np.sort(second)[: max(1, int(0.95 * len(second)))]))
    return middle / math.sqrt(6.0)


def sampling(time_s: Array) -> float:
    """Return the median sampling period in s."""
    n = len(time_s) - 1
    k = np.arange(0, n, max(1, n // NOISE_TRIPLES))
    # six digits: a clock that starts at a large number must not change the answer through its rounding
    return float(f"{np.median(time_s[k + 1] - time_s[k]):.6g}")


def default_cutoff(signal: Array, dt_s: float, sd: float) -> float:
    """Return a cut-off (Hz) well above the motion and below the sampling rate.

    The motion's frequency is taken as path over twice the range and duration, on a thinned signal
    so that noise adds no path.
    """
    rate = 1.0 / dt_s
    thin = signal[:: max(1, len(signal) // 512)]
    step = np.abs(np.diff(thin))
    span = float(np.ptp(thin))
    path = float(np.sum(step[step > 4.0 * sd])) if span > 0 else 0.0
    motion = path / (2.0 * span * len(signal) * dt_s) if span > 0 else 0.0
    return min(0.2 * rate, max(10.0, 20.0 * motion))


def filtered_sd(sd: float, cutoff_hz: float, dt_s: float) -> float:
    """Return what the low-pass leaves of white noise of standard deviation ``sd``."""
    return sd * math.sqrt(min(1.0, 2.0 * NOISE_BANDWIDTH * cutoff_hz * dt_s))


@njit(cache=True, nogil=True)
def despiked(signal: Array, threshold: float) -> Array:
    """Return a copy in which single samples that leave both neighbours by the threshold are bridged."""
    out = signal.copy()
    for k in range(1, signal.size - 1):
        a, v, c = signal[k - 1], signal[k], signal[k + 1]
        high, low = max(a, c), min(a, c)
        if v > high + threshold or v < low - threshold:
            out[k] = 0.5 * (a + c)
    return out


def bridged(signal: Array, threshold: float) -> Array:
    """Return :func:`despiked` with such ends of the record set to where their neighbours lead."""
    out = despiked(signal, threshold)
    for at, near, next_one in ((0, 1, 2), (-1, -2, -3)):
        if ends_off(signal, threshold)[at]:
            out[at] = 2.0 * out[near] - out[next_one]
    return out


def ends_off(signal: Array, threshold: float) -> tuple[bool, bool]:
    """Return whether the first and the last sample are spikes: off their one neighbour, the line that leads to them, and any movement.

    A channel that is renewed now and then may begin or end with a reading that is new.
    """
    found = [False, False]
    if len(signal) < LEAST_ENDS:
        return False, False
    for at, w in ((0, signal[:3]), (1, signal[:-4:-1])):
        near = (w[1], 2.0 * w[1] - w[2])
        off = max(w[0] - max(near), min(near) - w[0])
        if off <= threshold:
            continue
        second, first = np.diff(signal, 2), np.abs(np.diff(signal))
        found[at] = bool(np.median(np.abs(second)) > 0.0 and off > TWICE * float(np.quantile(first, 1.0 - FASTEST)))
    return found[0], found[1]


def low_pass(first: Array, second: Array, cutoff_hz: float, dt_s: float) -> tuple[Array, Array]:
    """Return both signals after a second-order Butterworth low-pass run forwards and backwards.

    Parameters
    ----------
    first, second : ndarray, shape (n,)
        Equally spaced samples.
    cutoff_hz, dt_s : float
        Cut-off of one pass (-3 dB) and sampling period.
    """
    ratio = cutoff_hz * dt_s
    if ratio >= 0.45:
        return first.copy(), second.copy()
    k = math.tan(math.pi * ratio)
    norm = 1.0 / (1.0 + math.sqrt(2.0) * k + k * k)
    b0 = k * k * norm
    a1, a2 = 2.0 * (k * k - 1.0) * norm, (1.0 - math.sqrt(2.0) * k + k * k) * norm
    pad = min(first.size - 1, math.ceil(1.5 / ratio - 1e-6))
    return _forward_backward(first, second, b0, a1, a2, pad)


@njit(cache=True, nogil=True, fastmath={"contract"})
def _forward_backward(x: Array, y: Array, b0: float, a1: float, a2: float, pad: int) -> tuple[Array, Array]:
    n = x.size
    u, v = np.empty(n + 2 * pad), np.empty(n + 2 * pad)
    # odd reflection keeps value and slope at both ends
    for k in range(pad):
        u[k], v[k] = 2.0 * x[0] - x[pad - k], 2.0 * y[0] - y[pad - k]
        u[pad + n + k], v[pad + n + k] = 2.0 * x[n - 1] - x[n - 2 - k], 2.0 * y[n - 1] - y[n - 2 - k]
    for k in range(n):
        u[pad + k], v[pad + k] = x[k], y[k]
    _in_place(u, v, b0, a1, a2, 0, 1)
    _in_place(u, v, b0, a1, a2, u.size - 1, -1)
    return u[pad : pad + n].copy(), v[pad : pad + n].copy()


@njit(cache=True, nogil=True, fastmath={"contract"})
def _in_place(u: Array, v: Array, b0: float, a1: float, a2: float, start: int, step: int) -> None:
    # transposed direct form II from the steady state of the first sample; two channels hide each other's latency
    s1, s2 = (1.0 - b0) * u[start], (b0 - a2) * u[start]
    r1, r2 = (1.0 - b0) * v[start], (b0 - a2) * v[start]
    k = start
    for _ in range(u.size):
        p, q = u[k], v[k]
        yu, yv = b0 * p + s1, b0 * q + r1
        s1, r1 = 2.0 * b0 * p - a1 * yu + s2, 2.0 * b0 * q - a1 * yv + r2
        s2, r2 = b0 * p - a2 * yu, b0 * q - a2 * yv
        u[k], v[k] = yu, yv
        k += step
