"""Small sequential operators on one signal, compiled: lag, delay, play."""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]


def first_order(signal: Array, dt_s: float, tau_s: float, inverse_slew: float = 0.0, begin: float | None = None) -> Array:
    """Return the response of a first-order lag with an optional slew limit.

    Parameters
    ----------
    signal : ndarray, shape (n,)
        Equally spaced samples.
    dt_s, tau_s : float
        Sampling period and time constant in s; ``tau_s = 0`` is the identity.
    inverse_slew : float
        One over the largest rate (s per unit); 0 is no limit.
    begin : float, optional
        Where it is at the first sample (default: at rest).
    """
    if tau_s <= 0.0 and inverse_slew <= 0.0:
        return signal
    gain = 1.0 - math.exp(-dt_s / tau_s) if tau_s > 0.0 else 1.0
    limit = dt_s / inverse_slew if inverse_slew > 0.0 else math.inf
    return _lag(np.ascontiguousarray(signal), gain, limit, float(signal[0]) if begin is None else begin)


def low_pass(signal: Array, dt_s: float, tau_s: float) -> Array:
    """Return the response of a first-order low-pass to a signal that is straight between its samples, started at rest.

    Exact for ramps at any sampling period: the output lags by ``tau_s``, which ``first_order`` misses by half a sample.
    """
    if tau_s <= 0.0:
        return signal
    decay = math.exp(-dt_s / tau_s)
    mean = (1.0 - decay) * tau_s / dt_s
    return _low_pass(np.ascontiguousarray(signal), decay, mean)


def second_low_pass(signal: Array, dt_s: float, tau_s: float, share: float) -> Array:
    """Return the response of ``1 / (1 + tau p + share tau^2 p^2)`` to a signal that is straight between its samples, started at rest.

    Exact at any sampling period; without a ``share`` it is :func:`low_pass`, at 1/4 two equal ones in a row, at 1/2 Butterworth's.
    """
    if tau_s <= 0.0 or share <= 0.0:
        return low_pass(signal, dt_s, tau_s)
    return _second_low_pass(np.ascontiguousarray(signal), dt_s / tau_s, *_faded(dt_s / tau_s, share))


def _faded(step: float, share: float) -> tuple[float, float, float, float]:
    """Return what is left after a step (time constants) of a distance from the steady answer and of its rate, row by row.

    The exponential of a two by two matrix by its half trace and the root that its eigenvalues are apart (real or not).
    """
    half = step / (2.0 * share)
    root = half * half - step * step / share
    if root > 0.0:
        s = math.sqrt(root)
        even, odd = 0.5 * (math.exp(s - half) + math.exp(-s - half)), 0.5 * (math.exp(s - half) - math.exp(-s - half)) / s
    else:
        s = math.sqrt(-root)
        even, odd = math.exp(-half) * math.cos(s), math.exp(-half) * (math.sin(s) / s if s > 0.0 else 1.0)
    return even + half * odd, step * odd, -step / share * odd, even - half * odd


def delayed(signal: Array, samples: float) -> Array:
    """Return the signal late by a fractional number of samples; the first value is held."""
    if samples == 0.0:
        return signal
    return _delay(np.ascontiguousarray(signal), samples)


def play(signal: Array, half_width: float, begin: float | None = None) -> Array:
    """Return the signal behind a symmetric play (backlash) of the given half-width, which begins in the middle or near ``begin``."""
    if half_width <= 0.0:
        return signal
    return _play(np.ascontiguousarray(signal), half_width, float(signal[0] if begin is None else begin))


@njit(cache=True, nogil=True)
def _lag(signal: Array, gain: float, limit: float, begin: float) -> Array:
    out, y = np.empty_like(signal), begin
    out[0] = begin
    for k in range(1, signal.size):
        step = gain * (signal[k] - y)
        y += min(max(step, -limit), limit)
        out[k] = y
    return out


@njit(cache=True, nogil=True)
def _low_pass(signal: Array, decay: float, mean: float) -> Array:
    out = np.empty_like(signal)
    y = signal[0]
    out[0] = y
    for k in range(1, signal.size):
        y = decay * y + (mean - decay) * signal[k - 1] + (1.0 - mean) * signal[k]
        out[k] = y
    return out


@njit(cache=True, nogil=True)
def _second_low_pass(signal: Array, step: float, kept: float, moved: float, braked: float, rolling: float) -> Array:
    out = np.empty_like(signal)
    y, rate = signal[0], 0.0
    out[0] = y
    for k in range(1, signal.size):
        slope = (signal[k] - signal[k - 1]) / step
        # behind a ramp the output is steady one time constant late
        off, faster = y - signal[k - 1] + slope, rate - slope
        y, rate = signal[k] - slope + kept * off + moved * faster, slope + braked * off + rolling * faster
        out[k] = y
    return out


@njit(cache=True, nogil=True)
def _delay(signal: Array, samples: float) -> Array:
    out = np.empty_like(signal)
    whole = math.floor(samples)
    part = samples - whole
    last = signal.size - 1
    for k in range(signal.size):
        a = min(max(k - whole, 0), last)
        b = min(max(k - whole - 1, 0), last)
        out[k] = (1.0 - part) * signal[a] + part * signal[b]
    return out


@njit(cache=True, nogil=True)
def _play(signal: Array, half_width: float, y: float) -> Array:
    out = np.empty_like(signal)
    for k in range(signal.size):
        y = min(max(y, signal[k] - half_width), signal[k] + half_width)
        out[k] = y
    return out
