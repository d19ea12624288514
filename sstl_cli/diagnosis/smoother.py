"""Kernels of the latent input: likelihood, smoothed states, and the law by which what stays unknown moves on.

The state is the signal x, its increment v and the change a of that, per sample::

    x' = x + v + a / 2 + (part of) w,    v' = v + a + w,    a' = a + b

with independent steps w (corners) and b (bends) of given variances, one each per sample, and white readings of x. Given
all readings, the state is still a Markov chain: the information L of the readings from a sample on turns the transition F
and covariance Q of the step that leads there into (I + Q L)^-1 F and (I + Q L)^-1 Q. Smoothed values and their error follow
forward from there; no smoothed covariance has to be inverted, and there is none that could lose its sign.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
# variance of the state before the first reading, in that of a reading
DIFFUSE = 1e6
# columns of a chain: transition row by row, covariance of what is new (00, 01, 02, 11, 12, 22)
CHAIN, LAW = 15, 22


@njit(cache=True, nogil=True, error_model="numpy")
def cost(y: Array, use: Mask, r: float, corners: Array, bends: Array) -> float:
    """Return minus the log likelihood (nats, up to a constant) of the readings, by the Kalman filter.

    Parameters
    ----------
    y : ndarray, shape (n,)
        Readings, the first near 0.
    r : float
        Variance of a reading.
    corners, bends : ndarray, shape (n,)
        Variances of the steps of increment and of its change.
    """
    x0 = x1 = x2 = total = 0.0
    s00 = s11 = s22 = DIFFUSE * r
    s01 = s02 = s12 = 0.0
    for k in range(y.size):
        if k:
            w = corners[k]
            x0 += x1 + 0.5 * x2
            x1 += x2
            a00, a01, a02 = s00 + s01 + 0.5 * s02, s01 + s11 + 0.5 * s12, s02 + s12 + 0.5 * s22
            a11, a12 = s11 + s12, s12 + s22
            s00, s01, s02 = a00 + a01 + 0.5 * a02 + w / 3.0, a01 + a02 + 0.5 * w, a02
            s11, s12, s22 = a11 + a12 + w, a12, s22 + bends[k]
        if use[k]:
            s = s00 + r
            g0, g1, g2, e = s00 / s, s01 / s, s02 / s, y[k] - x0
            total += 0.5 * (e * e / s + np.log(s))
            x0 += g0 * e
            x1 += g1 * e
            x2 += g2 * e
            s22 -= g2 * s02
            s12 -= g1 * s02
            s11 -= g1 * s01
            s02 *= 1.0 - g0
            s01 *= 1.0 - g0
            s00 *= 1.0 - g0
    return total


@njit(cache=True, nogil=True)
def _product(a: Array, b: Array, out: Array) -> None:
    """Write the product of two small matrices, without an allocation."""
    for i in range(3):
        for j in range(3):
            out[i, j] = a[i, 0] * b[0, j] + a[i, 1] * b[1, j] + a[i, 2] * b[2, j]


@njit(cache=True, nogil=True)
def _covariance(v: Array, out: Array) -> None:
    """Write a symmetric matrix from its six numbers (00, 01, 02, 11, 12, 22)."""
    out[0, 0], out[0, 1], out[0, 2], out[1, 1], out[1, 2], out[2, 2] = v[0], v[1], v[2], v[3], v[4], v[5]
    out[1, 0], out[2, 0], out[2, 1] = v[1], v[2], v[4]


@njit(cache=True, nogil=True)
def _moved(move: Array, s: Array, new: Array, half: Array, out: Array) -> None:
    """Write ``half`` = move s and ``out`` = move s move' + new."""
    _product(move, s, half)
    for i in range(3):
        for j in range(3):
            out[i, j] = half[i, 0] * move[j, 0] + half[i, 1] * move[j, 1] + half[i, 2] * move[j, 2] + new[i, j]


@njit(cache=True, nogil=True, error_model="numpy")
def _inverse_of_step(q: Array, info: Array, out: Array) -> None:
    """Write (I + Q L)^-1 by cofactors, which keep the scales of value, increment and change apart."""
    m = np.empty((3, 3))
    _product(q, info, m)
    for i in range(3):
        m[i, i] += 1.0
    for i in range(3):
        i1, i2 = (i + 1) % 3, (i + 2) % 3
        for j in range(3):
            j1, j2 = (j + 1) % 3, (j + 2) % 3
            out[j, i] = m[i1, j1] * m[i2, j2] - m[i1, j2] * m[i2, j1]
    det = m[0, 0] * out[0, 0] + m[0, 1] * out[1, 0] + m[0, 2] * out[2, 0]
    for i in range(3):
        for j in range(3):
            out[i, j] /= det


@njit(cache=True, nogil=True, error_model="numpy")
def chain(y: Array, use: Mask, r: float, corners: Array, bends: Array) -> tuple[Array, Array]:
    """Return the law of the state given all readings: chain (n, 15) and the drive of its mean (n, 3)."""
    n = y.size
    law, drive = np.zeros((n, CHAIN)), np.zeros((n, 3))
    info, h, m, q, inv, new = np.zeros((3, 3)), np.zeros(3), np.zeros(3), np.zeros((3, 3)), np.zeros((3, 3)), np.zeros((3, 3))
    f = np.array([[1.0, 1.0, 0.5], [0.0, 1.0, 1.0], [0.0, 0.0, 1.0]])
    for k in range(n - 1, -1, -1):
        if use[k]:
            info[0, 0] += 1.0 / r
            h[0] += y[k] / r
        if k:
            q[0, 0], q[0, 1], q[1, 0], q[1, 1], q[2, 2] = corners[k] / 3.0, 0.5 * corners[k], 0.5 * corners[k], corners[k], bends[k]
        else:
            q[:, :] = np.eye(3) * (DIFFUSE * r)
        _inverse_of_step(q, info, inv)
        _product(inv, f, new)
        for i in range(9 if k else 0):
            law[k, i] = new[i // 3, i % 3]
        _product(inv, q, new)
        for i in range(3):
            drive[k, i] = new[i, 0] * h[0] + new[i, 1] * h[1] + new[i, 2] * h[2]
        law[k, 9], law[k, 12], law[k, 14] = max(new[0, 0], 0.0), max(new[1, 1], 0.0), max(new[2, 2], 0.0)
        law[k, 10], law[k, 11], law[k, 13] = 0.5 * (new[0, 1] + new[1, 0]), 0.5 * (new[0, 2] + new[2, 0]), 0.5 * (new[1, 2] + new[2, 1])
        # one sample back: L <- F' (I + L Q)^-1 L F, and (I + L Q)^-1 is the transpose of the inverse above
        for i in range(3):
            for j in range(3):
                new[i, j] = inv[0, i] * info[0, j] + inv[1, i] * info[1, j] + inv[2, i] * info[2, j]
            m[i] = inv[0, i] * h[0] + inv[1, i] * h[1] + inv[2, i] * h[2]
        h[0], h[1], h[2] = m[0], m[0] + m[1], 0.5 * m[0] + m[1] + m[2]
        _product(new, f, inv)
        for i in range(3):
            for j in range(i + 1):
                info[i, j] = 0.5 * (f[0, i] * inv[0, j] + f[1, i] * inv[1, j] + f[2, i] * inv[2, j])
                info[i, j] += 0.5 * (f[0, j] * inv[0, i] + f[1, j] * inv[1, i] + f[2, j] * inv[2, i])
                info[j, i] = info[i, j]
    return law, drive


@njit(cache=True, nogil=True, error_model="numpy")
def follow(law: Array, drive: Array) -> tuple[Array, Array, Array]:
    """Return smoothed states (n, 3), variances of the value (n,), and squared steps (n, 4).

    The columns of the last are squared mean and variance of the step of the increment, then of that of its change.
    """
    n = len(law)
    mean, variance, steps = np.zeros((n, 3)), np.zeros(n), np.zeros((n, 4))
    s, g, t, a, v = np.zeros((3, 3)), np.zeros((3, 3)), np.zeros((3, 3)), np.zeros((3, 3)), np.zeros((3, 3))
    for k in range(n):
        for i in range(9):
            a[i // 3, i % 3] = law[k, i]
        _covariance(law[k, 9:], v)
        _moved(a, s, v, g, t)
        mean[k] = drive[k]
        if k:
            for i in range(3):
                mean[k, i] += a[i, 0] * mean[k - 1, 0] + a[i, 1] * mean[k - 1, 1] + a[i, 2] * mean[k - 1, 2]
            steps[k, 0] = (mean[k, 1] - mean[k - 1, 1] - mean[k - 1, 2]) ** 2
            steps[k, 1] = max(t[1, 1] + s[1, 1] + 2.0 * s[1, 2] + s[2, 2] - 2.0 * (g[1, 1] + g[1, 2]), 0.0)
            steps[k, 2] = (mean[k, 2] - mean[k - 1, 2]) ** 2
            steps[k, 3] = max(t[2, 2] + s[2, 2] - 2.0 * g[2, 2], 0.0)
        s[:, :] = t
        variance[k] = s[0, 0]
    steps[0] = steps[1]
    return mean, variance, steps


@njit(cache=True, nogil=True)
def error_of_means(law: Array, factor: int) -> tuple[Array, Array]:
    """Return the law of the error of means over ``factor`` samples, (n, 22), and its standard deviation (n,).

    Columns: transition of the state over a block, row by row; weights in the mean of the state before the block; covariance
    of what is new in the state (00, 01, 02, 11, 12, 22), of that with what is new in the mean (3), and variance of the latter.
    """
    n = len(law) // factor
    out, sd = np.zeros((n, LAW)), np.zeros(n)
    now, a, v, g, t = np.zeros((3, 3)), np.zeros((3, 3)), np.zeros((3, 3)), np.zeros((3, 3)), np.zeros((3, 3))
    for block in range(n):
        move, c, new, b, bb = np.eye(3), np.zeros(3), np.zeros((3, 3)), np.zeros(3), 0.0
        for k in range(block * factor, (block + 1) * factor):
            for i in range(9):
                a[i // 3, i % 3] = law[k, i]
            _covariance(law[k, 9:], v)
            _product(a, move, t)
            move[:, :] = t
            _moved(a, new, v, g, t)
            new[:, :] = t
            # the value of this sample joins the mean
            b0, b1, b2 = b[0], b[1], b[2]
            for i in range(3):
                b[i] = a[i, 0] * b0 + a[i, 1] * b1 + a[i, 2] * b2
            bb += (2.0 * b[0] + new[0, 0] / factor) / factor
            for i in range(3):
                b[i] += new[i, 0] / factor
                c[i] += move[0, i] / factor
        for i in range(9):
            out[block, i] = move[i // 3, i % 3]
        out[block, 9:12], out[block, 18:21], out[block, 21] = c, b, bb
        out[block, 12:15], out[block, 15:17], out[block, 17] = new[0], new[1, 1:], new[2, 2]
        known = 0.0
        for i in range(3):
            known += c[i] * (now[i, 0] * c[0] + now[i, 1] * c[1] + now[i, 2] * c[2])
        sd[block] = np.sqrt(max(known + bb, 0.0))
        _moved(move, now, new, g, t)
        now[:, :] = t
    return out, sd
