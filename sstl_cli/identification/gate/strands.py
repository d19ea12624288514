"""Friction as a bundle of plays, whose strands slide one after the other, with one slip more: what it leaves of an output, and the descent on it."""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]
# parameters: n theta, logarithm of the gain, constant friction (N), zero of the input (N), zero of the output (N), part of n theta that speed adds,
# spread of the friction of single strands (presliding); from one sample on: logarithms of another gain of output and input, other zeros of output
# and input (N); logarithm of the time constant (samples) of a low-pass behind the output; what the output's zero gains along the run (N). The slip comes last.
SPREAD, STEADY, LAG, CREEPS, PARAMETERS = 6, 7, 11, 12, 13
# friction that builds up over a path is a bundle of strands: their places in a normal distribution (fifths of it), and the largest spread of the
# logarithm of their friction
STRANDS, MOST_SPREAD = np.array([-1.4, -0.532, 0.0, 0.532, 1.4]), 1.2
HUBER = 2.0
# range of the logarithm of the time constant of a slow output, in samples: a tenth, and more than any recording has
FASTEST, SLOWEST = -2.3, 12.0


# long: one pass over the samples, whose state is what the next sample starts from
@njit(cache=True, nogil=True)
def left_of(x: Array, y: Array, fast: Array, p: Array, given: Array, left: Array, jacobian: Array) -> None:
    """Write output minus play operators, and their derivatives with respect to all parameters.

    ``fast`` (0 to 1) is the speed; ``given`` are the output (N) at the beginning, the sample from which another gain or zero counts, the
    level (N) that the sensor does not pass, and whether it is slow. Where the output is NaN nothing is left, and nothing known.
    """
    since, most, slow = given[1], given[2], given[3] > 0.0
    strands = STRANDS.size if p[SPREAD] > 0.0 else 1
    ratio, by_spread = _strands(p[SPREAD], strands)
    gp, gr = np.exp(p[1] - p[0] * ratio), np.exp(p[1] + p[0] * ratio)
    v, s = np.full(strands, given[0]), np.zeros((strands, STEADY))
    moved, moved_by = np.zeros(strands), np.zeros(strands)
    part, changes = 1.0, since < x.size
    gain_out, gain_in, zero_out, zero_in = 1.0, 1.0, 0.0, 0.0
    for k in range(x.size):
        if p[5] != 0.0:
            part = max(1.0 + p[5] * fast[k], 0.0)
            gp, gr = np.exp(p[1] - p[0] * part * ratio), np.exp(p[1] + p[0] * part * ratio)
        if k == since:
            gain_out, gain_in, zero_out, zero_in = math.exp(p[7]), math.exp(-p[8]), p[9], p[10]
        pulled = (x[k] - zero_in) * gain_in - p[3]
        total = 0.0
        for i in range(strands):
            r = ratio[i]
            low, high = gp[i] * pulled - p[2] * r + p[4], gr[i] * pulled + p[2] * r + p[4]
            if high < low:
                # below no tension both lines have crossed
                low = high = 0.5 * (low + high)
            sign = 0.0
            if v[i] < low:
                v[i], on, sign = low, gp[i], -1.0
            elif v[i] > high:
                v[i], on, sign = high, gr[i], 1.0
            if sign != 0.0:
                a = on * pulled
                s[i, 0], s[i, 1], s[i, 2], s[i, 3], s[i, 4] = sign * a * part * r, a, sign * r, -on, 1.0
                s[i, 5], s[i, SPREAD] = sign * a * p[0] * fast[k] * r, sign * (a * part * p[0] + p[2]) * by_spread[i]
                # a strand at rest keeps the input's gain and zero with which it slid last
                moved[i] = on * gain_in if k >= since else 0.0
                moved_by[i] = moved[i] * (x[k] - zero_in)
            total += v[i]
        model = total / strands
        along = k / (x.size - 1.0)
        shown = gain_out * model + zero_out + p[CREEPS] * along
        held = shown > most
        left[k] = y[k] - (most if held else shown)
        if math.isnan(left[k]):
            # what the sensor did not tell counts for nothing
            held, left[k] = True, 0.0
        for j in range(STEADY):
            jacobian[k, j] = 0.0 if held else gain_out * np.sum(s[:, j]) / strands
        jacobian[k, CREEPS] = 0.0 if held else along
        if changes:
            after = k >= since and not held
            jacobian[k, 7] = gain_out * model if after else 0.0
            jacobian[k, 9] = 1.0 if after else 0.0
            jacobian[k, 8] = 0.0 if held else -gain_out * np.sum(moved_by) / strands
            jacobian[k, 10] = 0.0 if held else -gain_out * np.sum(moved) / strands
    if slow:
        _low_passed(y, p[LAG], given[0], left, jacobian)


@njit(cache=True, nogil=True)
def _strands(spread: float, strands: int) -> tuple[Array, Array]:
    """Return the friction of every strand over their mean, and its derivatives by the spread."""
    if strands == 1:
        return np.ones(1), np.zeros(1)
    ratio = np.exp(spread * STRANDS)
    ratio /= np.mean(ratio)
    return ratio, ratio * (STRANDS - np.mean(ratio * STRANDS))


@njit(cache=True, nogil=True)
def _low_passed(y: Array, lag: float, start: float, left: Array, jacobian: Array) -> None:
    """Put a low-pass of first order, ``lag`` the logarithm of its time constant (samples), behind a model that was taken from the output."""
    tau = math.exp(lag)
    keep = math.exp(-1.0 / tau)
    state, by_lag = start, 0.0
    for k in range(y.size):
        v = y[k] - left[k]
        by_lag = keep * by_lag + keep / tau * (state - v)
        state = keep * state + (1.0 - keep) * v
        left[k] = y[k] - state
        for j in range(STEADY):
            before = jacobian[k - 1, j] if k > 0 else 0.0
            jacobian[k, j] = keep * before + (1.0 - keep) * jacobian[k, j]
        jacobian[k, LAG] = by_lag


@njit(cache=True, nogil=True)
def _cost(left: Array, limit: float) -> float:
    total = 0.0
    for v in left:
        a = abs(v)
        total += 0.5 * a * a if a <= limit else limit * (a - 0.5 * limit)
    return total


@njit(cache=True, nogil=True)
def tried(x: Array, y: Array, fast: Array, p: Array, given: Array, floor: float) -> float:
    """Return what a first guess leaves: the mean of what is left, single samples cut off."""
    left = np.empty(x.size)
    left_of(x, y, fast, p, given, left, np.empty((x.size, PARAMETERS)))
    known = np.abs(left[~np.isnan(y)])
    return float(np.mean(np.minimum(known, max(3.0 * np.median(known), floor))))


# long: one descent, kept in one compiled loop because each of its steps takes less than a call from outside
@njit(cache=True, nogil=True)
def descend(
    x: Array, y: Array, fast: Array, free: NDArray[np.int64], first: Array, given: Array, floor: float, steps: int
) -> tuple[Array, float]:
    """Levenberg-Marquardt on Huber's loss over the free parameters; constant friction and n theta stay positive."""
    n, m = x.size, free.size
    left, jacobian, trial_left, trial_jacobian = np.empty(n), np.empty((n, PARAMETERS)), np.empty(n), np.empty((n, PARAMETERS))
    p = first.copy()
    left_of(x, y, fast, p, given, left, jacobian)
    known = ~np.isnan(y)
    for _ in range(2):
        limit = HUBER * max(1.4826 * np.median(np.abs(left[known])), floor)
        cost = _cost(left, limit)
        damping = 1e-3
        for _ in range(steps):
            normal, gradient = np.zeros((m, m)), np.zeros(m)
            for k in range(n):
                w = min(1.0, limit / max(abs(left[k]), 1e-300))
                for i in range(m):
                    a = w * jacobian[k, free[i]]
                    gradient[i] += a * left[k]
                    for j in range(i + 1):
                        normal[i, j] += a * jacobian[k, free[j]]
            trace = 0.0
            for i in range(m):
                trace += normal[i, i]
                for j in range(i):
                    normal[j, i] = normal[i, j]
            for i in range(m):
                normal[i, i] += damping * normal[i, i] + 1e-9 * trace + 1e-200
            step = np.linalg.solve(normal, gradient)
            trial = p.copy()
            for i in range(m):
                trial[free[i]] += step[i]
            trial[0] = min(max(trial[0], 0.0), 4.0)
            trial[1] = min(max(trial[1], -12.0), 12.0)
            trial[2] = max(trial[2], 0.0)
            trial[5] = min(max(trial[5], -1.0), 3.0)
            if first[SPREAD] > 0.0:
                trial[SPREAD] = min(max(trial[SPREAD], 1e-3), MOST_SPREAD)
            trial[7] = min(max(trial[7], -5.0), 5.0)
            trial[8] = min(max(trial[8], -5.0), 5.0)
            trial[LAG] = min(max(trial[LAG], FASTEST), SLOWEST)
            left_of(x, y, fast, trial, given, trial_left, trial_jacobian)
            after = _cost(trial_left, limit)
            if after < cost:
                done = cost - after < 1e-4 * cost
                p, cost = trial, after
                left, trial_left = trial_left, left
                jacobian, trial_jacobian = trial_jacobian, jacobian
                damping = max(0.2 * damping, 1e-9)
                if done:
                    break
            else:
                damping *= 8.0
                if damping > 1e5:
                    break
    # what is not known has left nothing
    return p, math.sqrt(np.mean(left**2) / max(float(np.mean(known)), 1e-300))
