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

# columns of the phases, and of the coloured noise of the output's sensor
SLIDE, LEFT, GAIN, DOUBT = range(4)
DECAY, FRESH, SHOWN, BOTH, MEAN = range(5)


@njit(cache=True, nogil=True, error_model="numpy")
def gains(phases: Array, law: Array, own: Array, white_n: Array, keep: Mask, first: Mask, start: Array) -> tuple[Array, Array, float]:
    """Return the gains on unit innovations (n, 6), one over the innovations' standard deviations (0 where masked), and log det.

    State: error of the input (four numbers), what the line holds of it (4), coloured noise of the output's sensor (5); p and q
    are its covariances before and after a step.

    Parameters
    ----------
    phases, law, own : ndarray, shape (n, 4), (n, 36) and (n, 5)
        Columns of ``Phases``, law of the input's error, columns of ``Own`` (see whitening).
    """
    n = len(phases)
    k_out, scale, log_det, product = np.zeros((n, STATES)), np.zeros(n), 0.0, 1.0
    p, q, m = np.zeros((STATES, STATES)), np.zeros((STATES, STATES)), np.zeros((ERRORS, STATES))
    e, z = np.zeros(STATES), np.zeros(STATES)
    for t in range(n):
        row, slide, left, gain, decay, shown = law[t], phases[t, SLIDE], phases[t, LEFT], phases[t, GAIN], own[t, DECAY], own[t, SHOWN]
        if first[t]:
            p[:, HELD_AT:] = 0.0
        hold, follows = 1.0 - left, left * gain
        # how the mean over the step mixes what enters and what was held, beside how its end does
        rest, enters = 1.0 - slide, slide * gain
        _moved(p, row, m, e)
        _entered(q, z, m, row, (follows, hold, decay), (enters, rest, shown))
        entering = row[16] * e[0] + row[17] * e[1] + row[18] * e[2] + row[19] * e[3] + row[MEAN_NEW]
        if first[t]:
            # the output before the first sample is what was read there, or where the input holds it
            p[HELD_AT, HELD_AT] = start[t] + gain**2 * entering
        slip = phases[t, DOUBT] ** 2 if first[t] else _left_behind(phases[t - 1], phases[t], law[t - 1, TURN])
        held, own_n2 = p[HELD_AT, HELD_AT], p[OWN_AT, OWN_AT]
        q[HELD_AT, HELD_AT] = follows * follows * entering + 2.0 * follows * hold * e[HELD_AT] + hold * hold * held + slip
        with_held = follows * e[OWN_AT] + hold * p[HELD_AT, OWN_AT]
        q[HELD_AT, OWN_AT] = decay * with_held
        q[OWN_AT, OWN_AT] = decay * decay * own_n2 + own[t, FRESH]
        if keep[t]:
            shows = enters * e[OWN_AT] + rest * p[HELD_AT, OWN_AT]
            z[HELD_AT] = enters * follows * entering + (enters * hold + rest * follows) * e[HELD_AT] + rest * hold * held + slip
            z[HELD_AT] += shown * with_held
            z[OWN_AT] = decay * (shows + shown * own_n2) + own[t, BOTH]
            var = enters * enters * entering + 2.0 * enters * rest * e[HELD_AT] + rest * rest * held + slip
            var += 2.0 * shown * shows + shown * shown * own_n2 + own[t, MEAN] + white_n[t] ** 2
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


@njit(cache=True, nogil=True, inline="always")
def _moved(p: Array, row: Array, m: Array, e: Array) -> None:
    """Set the transition times the covariance of the input's error, and that of its mean over the step with the state before."""
    for j in range(STATES):
        c0, c1, c2, c3 = p[0, j], p[1, j], p[2, j], p[3, j]
        for i in range(ERRORS):
            m[i, j] = row[4 * i] * c0 + row[4 * i + 1] * c1 + row[4 * i + 2] * c2 + row[4 * i + 3] * c3
        e[j] = row[16] * c0 + row[17] * c1 + row[18] * c2 + row[19] * c3


@njit(cache=True, nogil=True, inline="always")
def _entered(q: Array, z: Array, m: Array, row: Array, end: tuple[float, float, float], mean: tuple[float, float, float]) -> None:
    """Set the covariances of the input's error after a step: with itself, with what is held and the sensor's noise, with the reading.

    ``end`` and ``mean`` are the shares of the input, of what was held and of the sensor's noise at the end of the step and in its mean.
    """
    at = MOVES
    for i in range(ERRORS):
        m0, m1, m2, m3 = m[i, 0], m[i, 1], m[i, 2], m[i, 3]
        for j in range(i, ERRORS):
            q[i, j] = m0 * row[4 * j] + m1 * row[4 * j + 1] + m2 * row[4 * j + 2] + m3 * row[4 * j + 3] + row[at]
            at += 1
        with_mean = m0 * row[16] + m1 * row[17] + m2 * row[18] + m3 * row[19] + row[BOTH_FROM + i]
        q[i, HELD_AT] = end[0] * with_mean + end[1] * m[i, HELD_AT]
        q[i, OWN_AT] = end[2] * m[i, OWN_AT]
        # of the sensor's own noise a step shows the mean
        z[i] = mean[0] * with_mean + mean[1] * m[i, HELD_AT] + mean[2] * m[i, OWN_AT]


@njit(cache=True, nogil=True, inline="always")
def _left_behind(before: Array, now: Array, turn: float) -> float:
    """Return the variance (N^2) of what a slip that may or may not have happened leaves until the next slide, and a slide that ends."""
    slip = max(now[DOUBT] ** 2 - ((1.0 - now[SLIDE]) * before[DOUBT]) ** 2, 0.0)
    if now[SLIDE] < before[SLIDE]:
        # a line holds the error with which its slide has ended, not that of the mean over the step
        slip += (1.0 - now[SLIDE] / before[SLIDE]) * before[GAIN] ** 2 * turn
    return float(slip)


@njit(cache=True, nogil=True)
def filtered(x: Array, moves: Array, own: Array, weights: Array, scale: Array, phases: Array, first: Mask) -> Array:
    """Return innovations over their standard deviations of every column, shape (n, k)."""
    n, k = x.shape
    out = np.zeros((n, k))
    state = np.zeros((STATES, k))
    for t in range(n):
        if first[t]:
            state[HELD_AT:, :] = 0.0
        row, u = moves[t], weights[t]
        t00, t01, t02, t03, t10, t11, t12, t13 = row[0], row[1], row[2], row[3], row[4], row[5], row[6], row[7]
        t20, t21, t22, t23, t30, t31, t32, t33 = row[8], row[9], row[10], row[11], row[12], row[13], row[14], row[15]
        f0, f1, f2, f3 = row[16], row[17], row[18], row[19]
        slide, left, gain, d, g, s = phases[t, SLIDE], phases[t, LEFT], phases[t, GAIN], own[t, DECAY], own[t, SHOWN], scale[t]
        hold, f, rest, enters = 1.0 - left, left * gain, 1.0 - slide, slide * gain
        u0, u1, u2, u3, u4, u5 = u[0], u[1], u[2], u[3], u[4], u[5]
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
