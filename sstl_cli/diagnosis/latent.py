"""The latent input behind a noisy reading: a fixed-interval smoother whose roughness is estimated.

The true input is a random walk in velocity whose increments follow Student's t (a scale mixture of normals, West 1987):
ramps are averaged over as far as they are straight, and a corner is one large increment that costs little. The smoother
of Rauch, Tung and Striebel (1965) gives value and error; the scale of the increments is the most likely one (EM).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]
# degrees of freedom of the increments: with 1 (Cauchy) a corner is as free as it can be and the mean still exists
# nowhere; the smoother needs no mean
TAILS = 1.0
ROUNDS = 12
# noise below this share of the span is rounding: there is nothing to smooth
FINEST = 1e-6
FACTORS = (1.0, 0.5, 2.0, 0.1, 10.0)


@dataclass(frozen=True)
class Latent:
    """The smoothed signal, its rate, and what is not known of it; arrays of shape (n,) on the signal's grid.

    ``variance`` is the posterior variance of ``value``; ``averaged`` is over how many samples it was taken.
    """

    value: Array
    rate: Array
    variance: Array
    averaged: Array


def latent(signal: Array, dt_s: float, white: float, known: NDArray[np.bool_] | None = None) -> Latent:
    """Return the latent signal behind readings with white noise.

    Parameters
    ----------
    signal : ndarray, shape (n,)
        Equally spaced readings.
    white : float
        Standard deviation of the white noise, in the unit of the signal.
    known : ndarray of bool, shape (n,), optional
        False where a reading says nothing.
    """
    n = len(signal)
    if n < 8 or white <= FINEST * float(np.ptp(signal)):
        rate = np.gradient(signal, dt_s) if n > 1 else np.zeros(n)
        return Latent(np.asarray(signal, np.float64).copy(), rate, np.zeros(n), np.ones(n))
    use = np.ones(n, np.bool_) if known is None else np.asarray(known, np.bool_)
    y = np.ascontiguousarray(signal, np.float64)
    r = white * white
    # a start between the roughness of the readings themselves and that of noise: EM goes down faster than up
    steps = np.diff(y[use], 2) if use.sum() > 8 else np.array([white])
    scale = max(float(np.median(steps**2)), 1e-6 * r)
    q = np.full(n, scale)
    for _ in range(ROUNDS):
        # the overall scale by the likelihood itself: EM alone would take hundreds of rounds to come down to a straight line
        factor = min(FACTORS, key=lambda f: _cost(y, use, r, f * q))
        scale, q = scale * factor, q * factor
        value, rate, variance, square = _smooth(y, use, r, q)
        weight = (TAILS + 1.0) / (TAILS + square / scale)
        q = scale / weight
    value, rate, variance, _ = _smooth(y, use, r, q)
    return Latent(value, rate / dt_s, variance, r / np.maximum(variance, 1e-300))


@njit(cache=True, nogil=True)
def _cost(y: Array, use: NDArray[np.bool_], r: float, q: Array) -> float:
    """Return minus the log likelihood (nats, up to a constant) of the readings, by the Kalman filter."""
    x0, x1, cost = y[0], 0.0, 0.0
    c00, c01, c11 = 1e4 * r + 1e4 * q[0], 0.0, 1e4 * r + 1e4 * q[0]
    for k in range(y.size):
        if k:
            x0 += x1
            c00, c01, c11 = c00 + 2.0 * c01 + c11 + q[k] / 3.0, c01 + c11 + 0.5 * q[k], c11 + q[k]
        if use[k]:
            s = c00 + r
            g0, g1 = c00 / s, c01 / s
            e = y[k] - x0
            cost += 0.5 * (e * e / s + np.log(s))
            x0 += g0 * e
            x1 += g1 * e
            c11 -= g1 * c01
            c01 *= 1.0 - g0
            c00 *= 1.0 - g0
    return cost


@njit(cache=True, nogil=True)
def _smooth(y: Array, use: NDArray[np.bool_], r: float, q: Array) -> tuple[Array, Array, Array, Array]:
    """Return value, increment per sample, variance of the value and expected squared increments of the velocity."""
    n = y.size
    m0, m1 = np.empty(n), np.empty(n)
    p00, p01, p11 = np.empty(n), np.empty(n), np.empty(n)
    a0, a1 = np.empty(n), np.empty(n)
    b00, b01, b11 = np.empty(n), np.empty(n), np.empty(n)
    x0, x1 = y[0], 0.0
    c00, c01, c11 = 1e4 * r + 1e4 * q[0], 0.0, 1e4 * r + 1e4 * q[0]
    for k in range(n):
        if k:
            # value and velocity one sample on; an increment of velocity comes anywhere in between
            w = q[k]
            x0 = x0 + x1
            n00 = c00 + 2.0 * c01 + c11 + w / 3.0
            n01 = c01 + c11 + 0.5 * w
            c00, c01, c11 = n00, n01, c11 + w
        a0[k], a1[k] = x0, x1
        b00[k], b01[k], b11[k] = c00, c01, c11
        if use[k]:
            s = c00 + r
            g0, g1 = c00 / s, c01 / s
            e = y[k] - x0
            x0 += g0 * e
            x1 += g1 * e
            c11 -= g1 * c01
            c01 *= 1.0 - g0
            c00 *= 1.0 - g0
        m0[k], m1[k] = x0, x1
        p00[k], p01[k], p11[k] = c00, c01, c11
    square = np.empty(n)
    variance = np.empty(n)
    s00, s01, s11 = p00[n - 1], p01[n - 1], p11[n - 1]
    variance[n - 1] = s00
    for k in range(n - 2, -1, -1):
        # smoother gain J = P F' B^-1
        f00, f01 = p00[k] + p01[k], p01[k]
        f10, f11 = p01[k] + p11[k], p11[k]
        d00, d01, d11 = b00[k + 1], b01[k + 1], b11[k + 1]
        det = max(d00 * d11 - d01 * d01, 1e-300)
        i00, i01, i11 = d11 / det, -d01 / det, d00 / det
        j00, j01 = f00 * i00 + f01 * i01, f00 * i01 + f01 * i11
        j10, j11 = f10 * i00 + f11 * i01, f10 * i01 + f11 * i11
        e0, e1 = m0[k + 1] - a0[k + 1], m1[k + 1] - a1[k + 1]
        v00, v01, v11 = s00 - d00, s01 - d01, s11 - d11
        # covariance of the next velocity with this one, given all readings
        cross = s01 * j10 + s11 * j11
        m0[k] += j00 * e0 + j01 * e1
        m1[k] += j10 * e0 + j11 * e1
        t00 = j00 * v00 + j01 * v01
        t01 = j00 * v01 + j01 * v11
        t10 = j10 * v00 + j11 * v01
        t11 = j10 * v01 + j11 * v11
        o11 = s11
        s00 = p00[k] + t00 * j00 + t01 * j01
        s01 = p01[k] + t00 * j10 + t01 * j11
        s11 = p11[k] + t10 * j10 + t11 * j11
        variance[k] = max(s00, 0.0)
        step = m1[k + 1] - m1[k]
        square[k + 1] = max(step * step + o11 + s11 - 2.0 * cross, 0.0)
    square[0] = square[1]
    return m0, m1, variance, square


def block_mean(signal: Array, factor: int) -> Array:
    """Return means of blocks of ``factor`` samples (a box anti-alias filter)."""
    if factor == 1:
        return signal
    n = len(signal) // factor * factor
    return np.asarray(signal[:n].reshape(-1, factor).mean(axis=1))
