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
Row = tuple[float, float, float, float]
Rows = tuple[Row, Row, Row, Row]
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
def costs(y: Array, use: Mask, noise: Reading, corners: Array, bends: Array, rest: Mask | None = None) -> Array:
    """Return minus the log likelihood (nats, up to a constant, shape (n,)) of each reading given those before, by the Kalman filter.

    Parameters
    ----------
    y : ndarray, shape (n,)
        Readings, the first near 0.
    corners, bends : ndarray, shape (n,)
        Variances of the steps of increment and of its change.
    rest : ndarray of bool, shape (n,), optional
        Where the signal is known to stand still.
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
        if rest is not None and rest[k]:
            # a reading of the increment, which is 0
            s = s11 + r / DIFFUSE
            g0, g1, g2, gc = s01 / s, s11 / s, s12 / s, s1c / s
            x0, x2, xc, x1 = x0 - g0 * x1, x2 - g2 * x1, xc - gc * x1, x1 - g1 * x1
            s00, s02, s0c, s01 = s00 - g0 * s01, s02 - g0 * s12, s0c - g0 * s1c, s01 - g0 * s11
            s22, s2c, scc = s22 - g2 * s12, s2c - g2 * s1c, scc - gc * s1c
            s12, s1c, s11 = s12 - g1 * s12, s1c - g1 * s1c, s11 - g1 * s11
    return out


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
def _inverse(a: Row, b: Row, c: Row, d: Row) -> Rows:
    """Return the rows of the inverse of a matrix by cofactors, which keep the scales of the states apart (Laplace, by pairs of rows)."""
    s0, s1, s2 = a[0] * b[1] - b[0] * a[1], a[0] * b[2] - b[0] * a[2], a[0] * b[3] - b[0] * a[3]
    s3, s4, s5 = a[1] * b[2] - b[1] * a[2], a[1] * b[3] - b[1] * a[3], a[2] * b[3] - b[2] * a[3]
    c0, c1, c2 = c[0] * d[1] - d[0] * c[1], c[0] * d[2] - d[0] * c[2], c[0] * d[3] - d[0] * c[3]
    c3, c4, c5 = c[1] * d[2] - d[1] * c[2], c[1] * d[3] - d[1] * c[3], c[2] * d[3] - d[2] * c[3]
    over = 1.0 / (s0 * c5 - s1 * c4 + s2 * c3 + s3 * c2 - s4 * c1 + s5 * c0)
    return (
        (
            (b[1] * c5 - b[2] * c4 + b[3] * c3) * over,
            (-a[1] * c5 + a[2] * c4 - a[3] * c3) * over,
            (d[1] * s5 - d[2] * s4 + d[3] * s3) * over,
            (-c[1] * s5 + c[2] * s4 - c[3] * s3) * over,
        ),
        (
            (-b[0] * c5 + b[2] * c2 - b[3] * c1) * over,
            (a[0] * c5 - a[2] * c2 + a[3] * c1) * over,
            (-d[0] * s5 + d[2] * s2 - d[3] * s1) * over,
            (c[0] * s5 - c[2] * s2 + c[3] * s1) * over,
        ),
        (
            (b[0] * c4 - b[1] * c2 + b[3] * c0) * over,
            (-a[0] * c4 + a[1] * c2 - a[3] * c0) * over,
            (d[0] * s4 - d[1] * s2 + d[3] * s0) * over,
            (-c[0] * s4 + c[1] * s2 - c[3] * s0) * over,
        ),
        (
            (-b[0] * c3 + b[1] * c1 - b[2] * c0) * over,
            (a[0] * c3 - a[1] * c1 + a[2] * c0) * over,
            (-d[0] * s3 + d[1] * s1 - d[2] * s0) * over,
            (c[0] * s3 - c[1] * s1 + c[2] * s0) * over,
        ),
    )


@njit(cache=True, nogil=True)
def _of_row(a: Row, b0: Row, b1: Row, b2: Row, b3: Row) -> Row:
    """Return a row times a matrix."""
    return (
        a[0] * b0[0] + a[1] * b1[0] + a[2] * b2[0] + a[3] * b3[0],
        a[0] * b0[1] + a[1] * b1[1] + a[2] * b2[1] + a[3] * b3[1],
        a[0] * b0[2] + a[1] * b1[2] + a[2] * b2[2] + a[3] * b3[2],
        a[0] * b0[3] + a[1] * b1[3] + a[2] * b2[3] + a[3] * b3[3],
    )


@njit(cache=True, nogil=True)
def _dot(a: Row, b: Row) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3]


@njit(cache=True, nogil=True)
def _ahead(a: Row, memory: float) -> Row:
    """Return a row times the transition of one sample, which is mostly zeros."""
    return (a[0], a[0] + a[1], 0.5 * a[0] + a[1] + a[2], memory * a[3])


@njit(cache=True, nogil=True)
def _mean(a: Row, b: Row) -> Row:
    return (0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1]), 0.5 * (a[2] + b[2]), 0.5 * (a[3] + b[3]))


@njit(cache=True, nogil=True, error_model="numpy")
def chain(y: Array, use: Mask, noise: Reading, corners: Array, bends: Array, rest: Mask | None = None) -> tuple[Array, Array]:
    """Return the law of the state given all readings (and where it stands still): chain (n, 26) and the drive of its mean (n, 4).

    Rows are tuples: they stay in registers, and the zeros of transition and covariance of a step cost nothing.
    """
    n, r, memory = y.size, noise.white, noise.memory
    law, drive = np.empty((n, CHAIN)), np.empty((n, STATES))
    one = 1.0 / r
    # information of the readings from a sample on, row by row, and their sum weighted by it
    l0 = l1 = l2 = l3 = h = (0.0, 0.0, 0.0, 0.0)
    for k in range(n - 1, -1, -1):
        if use[k]:
            z = y[k] / r
            h = (h[0] + z, h[1], h[2], h[3] + z)
            l0, l3 = (l0[0] + one, l0[1], l0[2], l0[3] + one), (l3[0] + one, l3[1], l3[2], l3[3] + one)
        if rest is not None and rest[k]:
            l1 = (l1[0], l1[1] + DIFFUSE * one, l1[2], l1[3])
        # covariance of the step that leads here: of value and increment (p, w, v), of the change, of the slow noise
        if k:
            p, w, v, b, u = PART * corners[k], 0.5 * corners[k], corners[k], bends[k], noise.slow * (1.0 - memory**2)
        else:
            p, w, v, b, u = DIFFUSE * r, 0.0, DIFFUSE * r, DIFFUSE * r, noise.slow
        i0, i1, i2, i3 = _inverse(
            (1.0 + (p * l0[0] + w * l1[0]), p * l0[1] + w * l1[1], p * l0[2] + w * l1[2], p * l0[3] + w * l1[3]),
            (w * l0[0] + v * l1[0], 1.0 + (w * l0[1] + v * l1[1]), w * l0[2] + v * l1[2], w * l0[3] + v * l1[3]),
            (b * l2[0], b * l2[1], 1.0 + b * l2[2], b * l2[3]),
            (u * l3[0], u * l3[1], u * l3[2], 1.0 + u * l3[3]),
        )
        row = law[k]
        if k:
            row[0], row[1], row[2], row[3] = _ahead(i0, memory)
            row[4], row[5], row[6], row[7] = _ahead(i1, memory)
            row[8], row[9], row[10], row[11] = _ahead(i2, memory)
            row[12], row[13], row[14], row[15] = _ahead(i3, memory)
        else:
            for i in range(STATES * STATES):
                row[i] = 0.0
        c0 = (p * i0[0] + w * i0[1], w * i0[0] + v * i0[1], b * i0[2], u * i0[3])
        c1 = (p * i1[0] + w * i1[1], w * i1[0] + v * i1[1], b * i1[2], u * i1[3])
        c2 = (p * i2[0] + w * i2[1], w * i2[0] + v * i2[1], b * i2[2], u * i2[3])
        c3 = (p * i3[0] + w * i3[1], w * i3[0] + v * i3[1], b * i3[2], u * i3[3])
        # rounding takes no variance below 0
        row[16], row[20], row[23], row[25] = max(c0[0], 0.0), max(c1[1], 0.0), max(c2[2], 0.0), max(c3[3], 0.0)
        row[17], row[18], row[19] = 0.5 * (c0[1] + c1[0]), 0.5 * (c0[2] + c2[0]), 0.5 * (c0[3] + c3[0])
        row[21], row[22], row[24] = 0.5 * (c1[2] + c2[1]), 0.5 * (c1[3] + c3[1]), 0.5 * (c2[3] + c3[2])
        drive[k, 0], drive[k, 1], drive[k, 2], drive[k, 3] = _dot(c0, h), _dot(c1, h), _dot(c2, h), _dot(c3, h)
        # one sample back: L <- F' (I + L Q)^-1 L F, and (I + L Q)^-1 is the transpose of the inverse above
        t0, t1, t2, t3 = (
            (i0[0], i1[0], i2[0], i3[0]),
            (i0[1], i1[1], i2[1], i3[1]),
            (i0[2], i1[2], i2[2], i3[2]),
            (i0[3], i1[3], i2[3], i3[3]),
        )
        h = _ahead((_dot(t0, h), _dot(t1, h), _dot(t2, h), _dot(t3, h)), memory)
        # symmetric: rows times the transition, then columns, which are rows again
        b0, b1 = _ahead(_of_row(t0, l0, l1, l2, l3), memory), _ahead(_of_row(t1, l0, l1, l2, l3), memory)
        b2, b3 = _ahead(_of_row(t2, l0, l1, l2, l3), memory), _ahead(_of_row(t3, l0, l1, l2, l3), memory)
        e0, e1 = _ahead((b0[0], b1[0], b2[0], b3[0]), memory), _ahead((b0[1], b1[1], b2[1], b3[1]), memory)
        e2, e3 = _ahead((b0[2], b1[2], b2[2], b3[2]), memory), _ahead((b0[3], b1[3], b2[3], b3[3]), memory)
        l0, l1 = _mean(e0, (e0[0], e1[0], e2[0], e3[0])), _mean(e1, (e0[1], e1[1], e2[1], e3[1]))
        l2, l3 = _mean(e2, (e0[2], e1[2], e2[2], e3[2])), _mean(e3, (e0[3], e1[3], e2[3], e3[3]))
    return law, drive


@njit(cache=True, nogil=True, error_model="numpy")
def follow(law: Array, drive: Array) -> tuple[Array, Array, Array]:
    """Return smoothed states (n, 4), variances of the value (n,), and squared steps (n, 4).

    The columns of the last are squared mean and variance of the step of the increment, then of that of its change.
    """
    n = len(law)
    mean, variance, steps = np.empty((n, STATES)), np.empty(n), np.empty((n, 4))
    s0 = s1 = s2 = s3 = m = (0.0, 0.0, 0.0, 0.0)
    for k in range(n):
        r, d = law[k], drive[k]
        a0, a1 = (r[0], r[1], r[2], r[3]), (r[4], r[5], r[6], r[7])
        a2, a3 = (r[8], r[9], r[10], r[11]), (r[12], r[13], r[14], r[15])
        # covariance with the state before, then that of the state, which is symmetric
        g0, g1 = _of_row(a0, s0, s1, s2, s3), _of_row(a1, s0, s1, s2, s3)
        g2, g3 = _of_row(a2, s0, s1, s2, s3), _of_row(a3, s0, s1, s2, s3)
        t01, t02, t03 = r[17] + _dot(g0, a1), r[18] + _dot(g0, a2), r[19] + _dot(g0, a3)
        t11, t12, t13 = r[20] + _dot(g1, a1), r[21] + _dot(g1, a2), r[22] + _dot(g1, a3)
        t22, t23 = r[23] + _dot(g2, a2), r[24] + _dot(g2, a3)
        x = (d[0] + _dot(a0, m), d[1] + _dot(a1, m), d[2] + _dot(a2, m), d[3] + _dot(a3, m))
        steps[k, 0] = (x[1] - m[1] - m[2]) ** 2
        steps[k, 1] = max(t11 + s1[1] + 2.0 * s1[2] + s2[2] - 2.0 * (g1[1] + g1[2]), 0.0)
        steps[k, 2] = (x[2] - m[2]) ** 2
        steps[k, 3] = max(t22 + s2[2] - 2.0 * g2[2], 0.0)
        s0, s1 = (r[16] + _dot(g0, a0), t01, t02, t03), (t01, t11, t12, t13)
        s2, s3, m = (t02, t12, t22, t23), (t03, t13, t23, r[25] + _dot(g3, a3)), x
        mean[k, 0], mean[k, 1], mean[k, 2], mean[k, 3] = x
        variance[k] = s0[0]
    # nothing leads to the first sample
    for i in range(4):
        steps[0, i] = steps[1, i]
    return mean, variance, steps


@njit(cache=True, nogil=True)
def error_of_means(law: Array, factor: int) -> tuple[Array, Array]:
    """Return the law of the error of means over ``factor`` samples, (n, 36), and its standard deviation (n,)."""
    n = len(law) // factor
    out, sd = np.zeros((n, LAW)), np.zeros(n)
    squares = np.zeros((7, STATES, STATES))
    now, a, v, g, t, move, new = squares[0], squares[1], squares[2], squares[3], squares[4], squares[5], squares[6]
    b, c = np.zeros(STATES), np.zeros(STATES)
    for block in range(n):
        bb = 0.0
        for i in range(STATES):
            b[i] = c[i] = 0.0
            for j in range(STATES):
                move[i, j], new[i, j] = 1.0 if i == j else 0.0, 0.0
        for k in range(block * factor, (block + 1) * factor):
            _matrix(law[k], a)
            _covariance(law[k, STATES * STATES :], v)
            _product(a, move, t)
            move, t = t, move
            _moved(a, new, v, g, t)
            new, t = t, new
            # the value of this sample joins the mean
            b0, b1, b2, b3 = b[0], b[1], b[2], b[3]
            for i in range(STATES):
                b[i] = a[i, 0] * b0 + a[i, 1] * b1 + a[i, 2] * b2 + a[i, 3] * b3
            bb += (2.0 * b[0] + new[0, 0] / factor) / factor
            for i in range(STATES):
                b[i] += new[i, 0] / factor
                c[i] += move[0, i] / factor
        for i in range(STATES * STATES):
            out[block, i] = move[i // STATES, i % STATES]
        _pairs(new, out[block, MOVES : MOVES + PAIRS])
        for i in range(STATES):
            out[block, STATES * STATES + i], out[block, MOVES + PAIRS + i] = c[i], b[i]
        out[block, LAW - 2] = bb
        known, apart = 0.0, bb + new[0, 0] - 2.0 * b[0]
        for i in range(STATES):
            for j in range(STATES):
                known += c[i] * now[i, j] * c[j]
                apart += (move[0, i] - c[i]) * now[i, j] * (move[0, j] - c[j])
        out[block, LAW - 1] = max(apart, 0.0)
        sd[block] = np.sqrt(max(known + bb, 0.0))
        _moved(move, now, new, g, t)
        now, t = t, now
    return out, sd
