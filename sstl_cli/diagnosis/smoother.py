"""Kernels of the latent input: likelihood, smoothed states, and the law by which what stays unknown moves on.

The state is the signal x, its increment v and the change a of that, per sample, and the slow noise c of the sensor::

    x' = x + v + a / 2 + (part of) w,    v' = v + a + w,    a' = a + b,    c' = memory c + u

with independent steps w (corners), b (bends) and u of given variances, one each per sample, and readings of x + c with white
noise. Given all readings, the state is still a Markov chain: the information L of the readings from a sample on turns the
transition F and covariance Q of the step that leads there into (I + Q L)^-1 F and (I + Q L)^-1 Q. Smoothed values and their
error follow forward from there; no smoothed covariance has to be inverted, and there is none that could lose its sign.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
# mean square of what is left of a step once a corner has come: at the sample before or at this one (a command that steps: 1/2)
# or anywhere between them (1/3), half of each
PART = 5.0 / 12.0
# variance of the state before the first reading, in that of a reading
DIFFUSE = 1e6
STATES = 4
# pairs of states, as covariances are laid out: 00, 01, 02, 03, 11, 12, 13, 22, 23, 33
PAIRS = STATES * (STATES + 1) // 2
# columns of a chain: transition row by row, covariance of what is new
CHAIN = STATES * STATES + PAIRS
# columns of the law of a mean: transition row by row and weights of the state before in the mean, which move what is known;
# covariance of what is new in the state, of that with what is new in the mean, and variance of the latter; last by how much (mean square)
# the end of a step differs from its mean
MOVES = STATES * STATES + STATES
LAW = MOVES + PAIRS + STATES + 2


class Reading(NamedTuple):
    """Noise of a reading: variance of its white part and of its slow one, and what a sample keeps of the latter."""

    white: float
    slow: float = 0.0
    memory: float = 0.0


@njit(cache=True, nogil=True, error_model="numpy")
def costs(y: Array, use: Mask, noise: Reading, corners: Array, bends: Array) -> Array:
    """Return minus the log likelihood (nats, up to a constant, shape (n,)) of each reading given those before, by the Kalman filter.

    Parameters
    ----------
    y : ndarray, shape (n,)
        Readings, the first near 0.
    corners, bends : ndarray, shape (n,)
        Variances of the steps of increment and of its change.
    """
    r, f, fresh = noise.white, noise.memory, noise.slow * (1.0 - noise.memory**2)
    x0 = x1 = x2 = xc = 0.0
    out = np.zeros(y.size)
    s00 = s11 = s22 = DIFFUSE * r
    s01 = s02 = s12 = s0c = s1c = s2c = 0.0
    scc = noise.slow
    for k in range(y.size):
        if k:
            w = corners[k]
            x0 += x1 + 0.5 * x2
            x1 += x2
            xc *= f
            a00, a01, a02 = s00 + s01 + 0.5 * s02, s01 + s11 + 0.5 * s12, s02 + s12 + 0.5 * s22
            a11, a12 = s11 + s12, s12 + s22
            s0c, s1c, s2c, scc = f * (s0c + s1c + 0.5 * s2c), f * (s1c + s2c), f * s2c, f * f * scc + fresh
            s00, s01, s02 = a00 + a01 + 0.5 * a02 + PART * w, a01 + a02 + 0.5 * w, a02
            s11, s12, s22 = a11 + a12 + w, a12, s22 + bends[k]
        if use[k]:
            z0, z1, z2, zc = s00 + s0c, s01 + s1c, s02 + s2c, s0c + scc
            s, e = z0 + zc + r, y[k] - x0 - xc
            out[k] = 0.5 * (e * e / s + np.log(s))
            g0, g1, g2, gc = z0 / s, z1 / s, z2 / s, zc / s
            x0 += g0 * e
            x1 += g1 * e
            x2 += g2 * e
            xc += gc * e
            s00 -= g0 * z0
            s01 -= g0 * z1
            s02 -= g0 * z2
            s0c -= g0 * zc
            s11 -= g1 * z1
            s12 -= g1 * z2
            s1c -= g1 * zc
            s22 -= g2 * z2
            s2c -= g2 * zc
            scc -= gc * zc
    return out


@njit(cache=True, nogil=True)
def cost(y: Array, use: Mask, noise: Reading, corners: Array, bends: Array) -> float:
    """Return minus the log likelihood (nats, up to a constant) of all readings (see ``costs``)."""
    total: float = costs(y, use, noise, corners, bends).sum()
    return total


@njit(cache=True, nogil=True)
def _product(a: Array, b: Array, out: Array) -> None:
    """Write the product of two small matrices, without an allocation."""
    for i in range(STATES):
        for j in range(STATES):
            out[i, j] = a[i, 0] * b[0, j] + a[i, 1] * b[1, j] + a[i, 2] * b[2, j] + a[i, 3] * b[3, j]


@njit(cache=True, nogil=True)
def _matrix(v: Array, out: Array) -> None:
    """Write a matrix from its rows, end to end."""
    for i in range(STATES):
        for j in range(STATES):
            out[i, j] = v[STATES * i + j]


@njit(cache=True, nogil=True)
def _covariance(v: Array, out: Array) -> None:
    """Write a symmetric matrix from its pairs."""
    at = 0
    for i in range(STATES):
        for j in range(i, STATES):
            out[i, j] = out[j, i] = v[at]
            at += 1


@njit(cache=True, nogil=True)
def _pairs(s: Array, out: Array) -> None:
    """Write the pairs of a symmetric matrix; rounding takes no variance below 0."""
    at = 0
    for i in range(STATES):
        out[at] = max(s[i, i], 0.0)
        at += 1
        for j in range(i + 1, STATES):
            out[at] = 0.5 * (s[i, j] + s[j, i])
            at += 1


@njit(cache=True, nogil=True)
def _moved(move: Array, s: Array, new: Array, half: Array, out: Array) -> None:
    """Write ``half`` = move s and ``out`` = move s move' + new."""
    _product(move, s, half)
    for i in range(STATES):
        for j in range(STATES):
            out[i, j] = new[i, j] + half[i, 0] * move[j, 0] + half[i, 1] * move[j, 1] + half[i, 2] * move[j, 2] + half[i, 3] * move[j, 3]


@njit(cache=True, nogil=True, error_model="numpy")
def _inverse_of_step(q: Array, info: Array, m: Array, out: Array) -> None:
    """Write (I + Q L)^-1 by cofactors, which keep the scales of the states apart (Laplace's expansion by pairs of rows)."""
    _product(q, info, m)
    for i in range(STATES):
        m[i, i] += 1.0
    a, b, c, d = m[0], m[1], m[2], m[3]
    s0, s1, s2 = a[0] * b[1] - b[0] * a[1], a[0] * b[2] - b[0] * a[2], a[0] * b[3] - b[0] * a[3]
    s3, s4, s5 = a[1] * b[2] - b[1] * a[2], a[1] * b[3] - b[1] * a[3], a[2] * b[3] - b[2] * a[3]
    c0, c1, c2 = c[0] * d[1] - d[0] * c[1], c[0] * d[2] - d[0] * c[2], c[0] * d[3] - d[0] * c[3]
    c3, c4, c5 = c[1] * d[2] - d[1] * c[2], c[1] * d[3] - d[1] * c[3], c[2] * d[3] - d[2] * c[3]
    over = 1.0 / (s0 * c5 - s1 * c4 + s2 * c3 + s3 * c2 - s4 * c1 + s5 * c0)
    out[0, 0], out[0, 1] = (b[1] * c5 - b[2] * c4 + b[3] * c3) * over, (-a[1] * c5 + a[2] * c4 - a[3] * c3) * over
    out[0, 2], out[0, 3] = (d[1] * s5 - d[2] * s4 + d[3] * s3) * over, (-c[1] * s5 + c[2] * s4 - c[3] * s3) * over
    out[1, 0], out[1, 1] = (-b[0] * c5 + b[2] * c2 - b[3] * c1) * over, (a[0] * c5 - a[2] * c2 + a[3] * c1) * over
    out[1, 2], out[1, 3] = (-d[0] * s5 + d[2] * s2 - d[3] * s1) * over, (c[0] * s5 - c[2] * s2 + c[3] * s1) * over
    out[2, 0], out[2, 1] = (b[0] * c4 - b[1] * c2 + b[3] * c0) * over, (-a[0] * c4 + a[1] * c2 - a[3] * c0) * over
    out[2, 2], out[2, 3] = (d[0] * s4 - d[1] * s2 + d[3] * s0) * over, (-c[0] * s4 + c[1] * s2 - c[3] * s0) * over
    out[3, 0], out[3, 1] = (-b[0] * c3 + b[1] * c1 - b[2] * c0) * over, (a[0] * c3 - a[1] * c1 + a[2] * c0) * over
    out[3, 2], out[3, 3] = (-d[0] * s3 + d[1] * s1 - d[2] * s0) * over, (c[0] * s3 - c[1] * s1 + c[2] * s0) * over


@njit(cache=True, nogil=True, error_model="numpy")
def chain(y: Array, use: Mask, noise: Reading, corners: Array, bends: Array) -> tuple[Array, Array]:
    """Return the law of the state given all readings: chain (n, 26) and the drive of its mean (n, 4)."""
    n, r, memory = y.size, noise.white, noise.memory
    law, drive = np.zeros((n, CHAIN)), np.zeros((n, STATES))
    squares = np.zeros((6, STATES, STATES))
    info, back, q, inv, new, f = squares[0], squares[1], squares[2], squares[3], squares[4], squares[5]
    h, m = np.zeros(STATES), np.zeros(STATES)
    f[0, 0] = f[0, 1] = f[1, 1] = f[1, 2] = f[2, 2] = 1.0
    f[0, 2], f[3, 3] = 0.5, memory
    for k in range(n - 1, -1, -1):
        if use[k]:
            for i in (0, 3):
                h[i] += y[k] / r
                for j in (0, 3):
                    info[i, j] += 1.0 / r
        if k:
            q[0, 0], q[0, 1], q[1, 0], q[1, 1], q[2, 2] = PART * corners[k], 0.5 * corners[k], 0.5 * corners[k], corners[k], bends[k]
            q[3, 3] = noise.slow * (1.0 - memory**2)
        else:
            q[0, 1] = q[1, 0] = 0.0
            q[0, 0] = q[1, 1] = q[2, 2] = DIFFUSE * r
            q[3, 3] = noise.slow
        _inverse_of_step(q, info, new, inv)
        if k:
            _product(inv, f, new)
            for i in range(STATES * STATES):
                law[k, i] = new[i // STATES, i % STATES]
        _product(inv, q, new)
        _pairs(new, law[k, STATES * STATES :])
        for i in range(STATES):
            drive[k, i] = new[i, 0] * h[0] + new[i, 1] * h[1] + new[i, 2] * h[2] + new[i, 3] * h[3]
        # one sample back: L <- F' (I + L Q)^-1 L F, and (I + L Q)^-1 is the transpose of the inverse above
        for i in range(STATES):
            for j in range(STATES):
                back[i, j] = inv[0, i] * info[0, j] + inv[1, i] * info[1, j] + inv[2, i] * info[2, j] + inv[3, i] * info[3, j]
            m[i] = inv[0, i] * h[0] + inv[1, i] * h[1] + inv[2, i] * h[2] + inv[3, i] * h[3]
        h[0], h[1], h[2], h[3] = m[0], m[0] + m[1], 0.5 * m[0] + m[1] + m[2], memory * m[3]
        _product(back, f, new)
        for i in range(STATES):
            for j in range(STATES):
                back[i, j] = f[0, i] * new[0, j] + f[1, i] * new[1, j] + f[2, i] * new[2, j] + f[3, i] * new[3, j]
        for i in range(STATES):
            for j in range(STATES):
                info[i, j] = 0.5 * (back[i, j] + back[j, i])
    return law, drive


@njit(cache=True, nogil=True, error_model="numpy")
def follow(law: Array, drive: Array) -> tuple[Array, Array, Array]:
    """Return smoothed states (n, 4), variances of the value (n,), and squared steps (n, 4).

    The columns of the last are squared mean and variance of the step of the increment, then of that of its change.
    """
    n = len(law)
    mean, variance, steps = np.zeros((n, STATES)), np.zeros(n), np.zeros((n, 4))
    squares = np.zeros((5, STATES, STATES))
    s, g, t, a, v = squares[0], squares[1], squares[2], squares[3], squares[4]
    for k in range(n):
        _matrix(law[k], a)
        _covariance(law[k, STATES * STATES :], v)
        _moved(a, s, v, g, t)
        mean[k] = drive[k]
        if k:
            for i in range(STATES):
                for j in range(STATES):
                    mean[k, i] += a[i, j] * mean[k - 1, j]
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
    """Return the law of the error of means over ``factor`` samples, (n, 36), and its standard deviation (n,)."""
    n = len(law) // factor
    out, sd = np.zeros((n, LAW)), np.zeros(n)
    squares = np.zeros((7, STATES, STATES))
    now, a, v, g, t, move, new = squares[0], squares[1], squares[2], squares[3], squares[4], squares[5], squares[6]
    b, c, last, unit = np.zeros(STATES), np.zeros(STATES), np.zeros(STATES), np.eye(STATES)
    for block in range(n):
        move[:, :], new[:, :], b[:], c[:], bb = unit, 0.0, 0.0, 0.0, 0.0
        for k in range(block * factor, (block + 1) * factor):
            _matrix(law[k], a)
            _covariance(law[k, STATES * STATES :], v)
            _product(a, move, t)
            move[:, :] = t
            _moved(a, new, v, g, t)
            new[:, :] = t
            # the value of this sample joins the mean
            last[:] = b
            for i in range(STATES):
                b[i] = a[i, 0] * last[0] + a[i, 1] * last[1] + a[i, 2] * last[2] + a[i, 3] * last[3]
            bb += (2.0 * b[0] + new[0, 0] / factor) / factor
            for i in range(STATES):
                b[i] += new[i, 0] / factor
                c[i] += move[0, i] / factor
        for i in range(STATES * STATES):
            out[block, i] = move[i // STATES, i % STATES]
        out[block, STATES * STATES : MOVES] = c
        _pairs(new, out[block, MOVES : MOVES + PAIRS])
        out[block, MOVES + PAIRS : LAW - 2], out[block, LAW - 2] = b, bb
        known, apart = 0.0, bb + new[0, 0] - 2.0 * b[0]
        for i in range(STATES):
            for j in range(STATES):
                known += c[i] * now[i, j] * c[j]
                apart += (move[0, i] - c[i]) * now[i, j] * (move[0, j] - c[j])
        out[block, LAW - 1] = max(apart, 0.0)
        sd[block] = np.sqrt(max(known + bb, 0.0))
        _moved(move, now, new, g, t)
        now[:, :] = t
    return out, sd
