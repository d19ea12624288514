"""Kernels of the innovations filter: its gains, which follow the phases alone, and its pass over residuals and columns.

What the states stand for is written in ``whitening``.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from sstl_cli.diagnosis.smoother import LAW, MOVES
from sstl_cli.diagnosis.smoother import STATES as ERRORS

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
# error of the input, what the line holds of it, coloured noise of the output's sensor
STATES, HELD_AT, OWN_AT = ERRORS + 2, ERRORS, ERRORS + 1
# columns of the law of the error: the last state kept, its weight in the mean, what is new in it, in both, in the mean, and by how much
# the end of a step differs from its mean
STATE_KEPT, MEAN_KEPT, STATE_NEW, BOTH_FROM, BOTH_NEW, MEAN_NEW, TURN = 15, 19, 29, 30, 33, LAW - 2, LAW - 1


@njit(cache=True, nogil=True, error_model="numpy")
def gains(
    slide: Array,
    left: Array,
    gain: Array,
    doubt_n: Array,
    law: Array,
    decay: Array,
    fresh: Array,
    shown: Array,
    both: Array,
    mean: Array,
    white_n: Array,
    keep: Mask,
    first: Mask,
    start: Array,
) -> tuple[Array, Array, float]:
    """Return the gains on unit innovations (n, 6), one over the innovations' standard deviations (0 where masked), and log det.

    State: error of the input (four numbers), what the line holds of it (4), coloured noise of the output's sensor (5); p and q
    are its covariances before and after a step, of which ``slide`` is the share by which its mean, ``left`` that by which its end
    follows the input instead of what was held before.
    """
    n = slide.size
    k_out, scale, log_det, product = np.zeros((n, STATES)), np.zeros(n), 0.0, 1.0
    p, q, m = np.zeros((STATES, STATES)), np.zeros((STATES, STATES)), np.zeros((ERRORS, STATES))
    e, z = np.zeros(STATES), np.zeros(STATES)
    for t in range(n):
        row = law[t]
        if first[t]:
            p[:, HELD_AT:] = 0.0
        hold, f, d = 1.0 - left[t], left[t] * gain[t], decay[t]
        # how the mean over the step mixes what enters and what was held, beside how its end does
        rest, enters = 1.0 - slide[t], slide[t] * gain[t]
        # transition times the covariance of the input's error, and that of its mean over the step with the state before
        for j in range(STATES):
            c0, c1, c2, c3 = p[0, j], p[1, j], p[2, j], p[3, j]
            for i in range(ERRORS):
                m[i, j] = row[4 * i] * c0 + row[4 * i + 1] * c1 + row[4 * i + 2] * c2 + row[4 * i + 3] * c3
            e[j] = row[16] * c0 + row[17] * c1 + row[18] * c2 + row[19] * c3
        g, at = shown[t], MOVES
        for i in range(ERRORS):
            m0, m1, m2, m3 = m[i, 0], m[i, 1], m[i, 2], m[i, 3]
            for j in range(i, ERRORS):
                q[i, j] = m0 * row[4 * j] + m1 * row[4 * j + 1] + m2 * row[4 * j + 2] + m3 * row[4 * j + 3] + row[at]
                at += 1
            with_mean = m0 * row[16] + m1 * row[17] + m2 * row[18] + m3 * row[19] + row[BOTH_FROM + i]
            q[i, HELD_AT] = f * with_mean + hold * m[i, HELD_AT]
            q[i, OWN_AT] = d * m[i, OWN_AT]
            # of the sensor's own noise a step shows the mean
            z[i] = enters * with_mean + rest * m[i, HELD_AT] + g * m[i, OWN_AT]
        entering = row[16] * e[0] + row[17] * e[1] + row[18] * e[2] + row[19] * e[3] + row[MEAN_NEW]
        if first[t]:
            # the output before the first sample is what was read there, or where the input holds it
            p[HELD_AT, HELD_AT] = start[t] + gain[t] ** 2 * entering
        # what a slip that may or may not have happened leaves behind stays until the next slide
        before = 0.0 if first[t] else rest * doubt_n[t - 1]
        slip = max(doubt_n[t] ** 2 - before**2, 0.0)
        if not first[t] and slide[t] < slide[t - 1]:
            # a line holds the error with which its slide has ended, not that of the mean over the step
            slip += (1.0 - slide[t] / slide[t - 1]) * gain[t - 1] ** 2 * law[t - 1, TURN]
        q[HELD_AT, HELD_AT] = f * f * entering + 2.0 * f * hold * e[HELD_AT] + hold * hold * p[HELD_AT, HELD_AT] + slip
        with_held = f * e[OWN_AT] + hold * p[HELD_AT, OWN_AT]
        q[HELD_AT, OWN_AT] = d * with_held
        q[OWN_AT, OWN_AT] = d * d * p[OWN_AT, OWN_AT] + fresh[t]
        if keep[t]:
            shows = enters * e[OWN_AT] + rest * p[HELD_AT, OWN_AT]
            z[HELD_AT] = enters * f * entering + (enters * hold + rest * f) * e[HELD_AT] + rest * hold * p[HELD_AT, HELD_AT] + slip
            z[HELD_AT] += g * with_held
            z[OWN_AT] = d * (shows + g * p[OWN_AT, OWN_AT]) + both[t]
            var = enters * enters * entering + 2.0 * enters * rest * e[HELD_AT] + rest * rest * p[HELD_AT, HELD_AT] + slip
            var += 2.0 * g * shows + g * g * p[OWN_AT, OWN_AT] + mean[t] + white_n[t] ** 2
            scale[t] = s = 1.0 / math.sqrt(var)
            # a logarithm of a product instead of one a sample
            product *= var
            if not 1e-100 < product < 1e100:
                log_det += math.log(product)
                product = 1.0
            for i in range(STATES):
                z[i] *= s
                k_out[t, i] = z[i]
        else:
            z[:] = 0.0
        for i in range(STATES):
            for j in range(i, STATES):
                p[i, j] = p[j, i] = q[i, j] - z[i] * z[j]
    return k_out, scale, log_det + math.log(product)


@njit(cache=True, nogil=True)
def filtered(
    x: Array, moves: Array, decay: Array, shown: Array, weights: Array, scale: Array, slide: Array, left: Array, gain: Array, first: Mask
) -> Array:
    """Return innovations over their standard deviations of every column, shape (n, k)."""
    n, k = x.shape
    out = np.zeros((n, k))
    state = np.zeros((STATES, k))
    for t in range(n):
        if first[t]:
            state[HELD_AT:, :] = 0.0
        t00, t01, t02, t03, t10, t11, t12, t13 = (
            moves[t, 0],
            moves[t, 1],
            moves[t, 2],
            moves[t, 3],
            moves[t, 4],
            moves[t, 5],
            moves[t, 6],
            moves[t, 7],
        )
        t20, t21, t22, t23, t30, t31, t32, t33 = (
            moves[t, 8],
            moves[t, 9],
            moves[t, 10],
            moves[t, 11],
            moves[t, 12],
            moves[t, 13],
            moves[t, 14],
            moves[t, 15],
        )
        f0, f1, f2, f3 = moves[t, 16], moves[t, 17], moves[t, 18], moves[t, 19]
        hold, f, d, g, s = 1.0 - left[t], left[t] * gain[t], decay[t], shown[t], scale[t]
        rest, enters = 1.0 - slide[t], slide[t] * gain[t]
        u0, u1, u2, u3, u4, u5 = weights[t, 0], weights[t, 1], weights[t, 2], weights[t, 3], weights[t, 4], weights[t, 5]
        for j in range(k):
            a0, a1, a2, a3 = state[0, j], state[1, j], state[2, j], state[3, j]
            e0, e1 = t00 * a0 + t01 * a1 + t02 * a2 + t03 * a3, t10 * a0 + t11 * a1 + t12 * a2 + t13 * a3
            e2, e3 = t20 * a0 + t21 * a1 + t22 * a2 + t23 * a3, t30 * a0 + t31 * a1 + t32 * a2 + t33 * a3
            new, a4, a5 = f0 * a0 + f1 * a1 + f2 * a2 + f3 * a3, state[4, j], state[5, j]
            e4 = f * new + hold * a4
            # 0 where masked: the state is only moved on
            v = s * (x[t, j] - enters * new - rest * a4 - g * a5) if s > 0.0 else 0.0
            out[t, j] = v
            state[0, j], state[1, j], state[2, j], state[3, j] = e0 + u0 * v, e1 + u1 * v, e2 + u2 * v, e3 + u3 * v
            state[4, j], state[5, j] = e4 + u4 * v, d * a5 + u5 * v
    return out
