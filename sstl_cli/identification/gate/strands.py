"""Friction as a bundle of plays, whose strands slide one after the other, with one slip more: what it leaves of an output, and the descent on it."""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]
Codes = NDArray[np.int64]
# parameters: n theta, logarithm of the gain, constant friction (N), zero of the input (N), zero of the output (N), part of n theta that speed adds,
# spread of the friction of single strands (presliding); from one sample on: logarithms of another gain of output and input, other zeros of output
# and input (N); logarithm of the time constant (samples) of a low-pass behind the output; what the output's zero gains along the run (N). The slip comes last.
SPREAD, STEADY, LAG, CREEPS, PARAMETERS = 6, 7, 11, 12, 13
# what a strand slides with: its derivatives by the first parameters, and by a zero and a gain of the input that change
MOVED, MOVED_BY, SLID = 7, 8, 9
# friction that builds up over a path is a bundle of strands: their places in a normal distribution (fifths of it), and the largest spread of the
# logarithm of their friction
STRANDS, MOST_SPREAD = np.array([-1.4, -0.532, 0.0, 0.532, 1.4]), 1.2
HUBER = 2.0
# range of the logarithm of the time constant of a slow output, in samples: a tenth, and more than any recording has
FASTEST, SLOWEST = -2.3, 12.0


# long: one pass over the samples, whose state is what the next sample starts from
@njit(cache=True, nogil=True)
def left_of(x: Array, y: Array, fast: Array, p: Array, given: Array, free: Codes, left: Array, jacobian: Array) -> None:
    """Write output minus play operators, and its derivatives, a row for each of the ``free`` parameters: none costs the least.

    ``fast`` (0 to 1) is the speed; ``given`` are the output (N) at the beginning, the sample from which another gain or zero counts, the
    level (N) that the sensor does not pass, and whether it is slow. Where the output is NaN nothing is left, and nothing known.
    """
    since, most, slow = given[1], given[2], given[3] > 0.0
    strands = STRANDS.size if p[SPREAD] > 0.0 else 1
    ratio, by_spread = _strands(p[SPREAD], strands)
    gp, gr, loss = np.exp(p[1] - p[0] * ratio), np.exp(p[1] + p[0] * ratio), p[2] * ratio
    # what each strand slid with last, and its sum over the strands: made anew only where one slides
    v, s, sums, rows = np.full(strands, given[0]), np.zeros((SLID, strands)), np.zeros(free.size), _rows(free)
    plain = np.zeros(PARAMETERS)
    part, gain, begun, share = 1.0, math.exp(p[1]), False, 1.0 / strands
    gain_out, gain_in, zero_out, zero_in = 1.0, 1.0, 0.0, 0.0
    for k in range(x.size):
        if p[5] != 0.0:
            part = max(1.0 + p[5] * fast[k], 0.0)
            for i in range(strands):
                e = math.exp(p[0] * part * ratio[i])
                gp[i], gr[i] = gain / e, gain * e
        if k == since:
            begun = True
            gain_out, gain_in, zero_out, zero_in = math.exp(p[7]), math.exp(-p[8]), p[9], p[10]
        pulled = (x[k] - zero_in) * gain_in - p[3]
        total, slid = 0.0, False
        for i in range(strands):
            low, high = gp[i] * pulled - loss[i] + p[4], gr[i] * pulled + loss[i] + p[4]
            if high < low:
                # below no tension both lines have crossed
                low = high = 0.5 * (low + high)
            if v[i] < low:
                v[i], on, sign = low, gp[i], -1.0
            elif v[i] > high:
                v[i], on, sign = high, gr[i], 1.0
            else:
                total += v[i]
                continue
            total += v[i]
            if free.size > 0:
                slid, a, r = True, on * pulled, sign * ratio[i]
                s[0, i], s[1, i], s[2, i], s[3, i], s[4, i] = a * part * r, a, r, -on, 1.0
                s[5, i], s[SPREAD, i] = a * p[0] * fast[k] * r, sign * (a * part * p[0] + p[2]) * by_spread[i]
                # a strand at rest keeps the input's gain and zero with which it slid last
                s[MOVED, i] = on * gain_in if begun else 0.0
                s[MOVED_BY, i] = s[MOVED, i] * (x[k] - zero_in)
        model, along = total * share, k / (x.size - 1.0)
        shown = gain_out * model + zero_out + p[CREEPS] * along
        held = shown > most
        left[k] = y[k] - (most if held else shown)
        if math.isnan(left[k]):
            # what the sensor did not tell counts for nothing
            held, left[k] = True, 0.0
        if slid:
            _summed(s, rows, sums)
        plain[CREEPS] = along
        if begun:
            plain[7], plain[9] = gain_out * model, 1.0
        for i in range(free.size):
            known = gain_out * sums[i] if rows[i] >= 0 else plain[free[i]]
            jacobian[i, k] = 0.0 if held else known
    if slow:
        _low_passed(y, p[LAG], given[0], free, left, jacobian)


def played(x: Array, fast: Array, p: Array, given: Array) -> Array:
    """Return what the plays make of an input (N), begun where ``given`` says; see ``left_of``."""
    left = np.empty(len(x))
    # what is left of nothing is the model
    left_of(x, np.zeros(len(x)), fast, p, given, np.empty(0, np.int64), left, np.empty((0, 0)))
    return -left


@njit(cache=True, nogil=True)
def _rows(free: Codes) -> Codes:
    """Return for each free parameter the row of what strands slid with that tells its derivative, -1 where none does."""
    rows = np.empty(free.size, np.int64)
    for i in range(free.size):
        rows[i] = free[i] if free[i] < STEADY else MOVED_BY if free[i] == 8 else MOVED if free[i] == 10 else -1
    return rows


@njit(cache=True, nogil=True)
def _summed(s: Array, rows: Codes, sums: Array) -> None:
    """Write the means of what strands slid with; a zero or a gain of the input takes from the output."""
    strands = s.shape[1]
    for i in range(rows.size):
        if rows[i] >= 0:
            total = 0.0
            for at in range(strands):
                total += s[rows[i], at]
            sums[i] = (total if rows[i] < STEADY else -total) / strands


@njit(cache=True, nogil=True)
def _strands(spread: float, strands: int) -> tuple[Array, Array]:
    """Return the friction of every strand over their mean, and its derivatives by the spread."""
    if strands == 1:
        return np.ones(1), np.zeros(1)
    ratio = np.exp(spread * STRANDS)
    ratio /= np.mean(ratio)
    return ratio, ratio * (STRANDS - np.mean(ratio * STRANDS))


@njit(cache=True, nogil=True)
def _low_passed(y: Array, lag: float, start: float, free: Codes, left: Array, jacobian: Array) -> None:
    """Put a low-pass of first order, ``lag`` the logarithm of its time constant (samples), behind a model that was taken from the output."""
    tau = math.exp(lag)
    keep = math.exp(-1.0 / tau)
    state, by_lag = start, 0.0
    for k in range(y.size):
        v = y[k] - left[k]
        by_lag = keep * by_lag + keep / tau * (state - v)
        state = keep * state + (1.0 - keep) * v
        left[k] = y[k] - state
        for i in range(free.size):
            before = jacobian[i, k - 1] if k > 0 else 0.0
            jacobian[i, k] = by_lag if free[i] == LAG else keep * before + (1.0 - keep) * jacobian[i, k]


@njit(cache=True, nogil=True)
def _cost(left: Array, limit: float) -> float:
    total = 0.0
    for v in left:
        a = abs(v)
        total += 0.5 * a * a if a <= limit else limit * (a - 0.5 * limit)
    return total


# sums in any order: several samples at once
@njit(cache=True, nogil=True, fastmath={"reassoc", "contract"})
def _normal(left: Array, jacobian: Array, limit: float) -> tuple[Array, Array]:
    """Return the normal matrix and the gradient of Huber's loss."""
    m, n = jacobian.shape
    normal, gradient = np.zeros((m, m)), np.zeros(m)
    weight, weighted = np.empty(n), np.empty(n)
    for k in range(n):
        weight[k] = min(1.0, limit / max(abs(left[k]), 1e-300))
    for i in range(m):
        total = 0.0
        for k in range(n):
            weighted[k] = weight[k] * jacobian[i, k]
            total += weighted[k] * left[k]
        gradient[i] = total
        for j in range(i + 1):
            total = 0.0
            for k in range(n):
                total += weighted[k] * jacobian[j, k]
            normal[i, j] = normal[j, i] = total
    return normal, gradient


@njit(cache=True, nogil=True)
def _sizes(left: Array, y: Array) -> Array:
    """Return the absolute values of what is left where the output is known."""
    sizes, count = np.empty(y.size), 0
    for k in range(y.size):
        if not np.isnan(y[k]):
            sizes[count] = abs(left[k])
            count += 1
    return sizes[:count]


@njit(cache=True, nogil=True)
def tried(x: Array, y: Array, fast: Array, p: Array, given: Array, floor: float) -> float:
    """Return what a first guess leaves: the mean of what is left, single samples cut off."""
    left = np.empty(x.size)
    left_of(x, y, fast, p, given, np.empty(0, np.int64), left, np.empty((0, 0)))
    known = _sizes(left, y)
    return float(np.mean(np.minimum(known, max(3.0 * np.median(known), floor))))


# long: one descent, kept in one compiled loop because each of its steps takes less than a call from outside
@njit(cache=True, nogil=True)
def descend(x: Array, y: Array, fast: Array, free: Codes, first: Array, given: Array, floor: float, steps: int) -> tuple[Array, float]:
    """Levenberg-Marquardt on Huber's loss over the free parameters; constant friction and n theta stay positive."""
    n, m = x.size, free.size
    left, jacobian, trial_left, trial_jacobian = np.empty(n), np.empty((m, n)), np.empty(n), np.empty((m, n))
    p = first.copy()
    left_of(x, y, fast, p, given, free, left, jacobian)
    for _ in range(2):
        sizes = _sizes(left, y)
        limit = HUBER * max(1.4826 * np.median(sizes), floor)
        cost = _cost(left, limit)
        damping = 1e-3
        normal, gradient = _normal(left, jacobian, limit)
        for _ in range(steps):
            damped, trace = normal.copy(), np.trace(normal)
            for i in range(m):
                damped[i, i] += damping * normal[i, i] + 1e-9 * trace + 1e-200
            step = np.linalg.solve(damped, gradient)
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
            left_of(x, y, fast, trial, given, free, trial_left, trial_jacobian)
            after = _cost(trial_left, limit)
            if after < cost:
                done = cost - after < 1e-4 * cost
                p, cost = trial, after
                left, trial_left = trial_left, left
                jacobian, trial_jacobian = trial_jacobian, jacobian
                damping = max(0.2 * damping, 1e-9)
                if done:
                    break
                normal, gradient = _normal(left, jacobian, limit)
            else:
                damping *= 8.0
                if damping > 1e5:
                    break
    # what is not known has left nothing
    return p, math.sqrt(np.mean(left**2) / max(sizes.size / n, 1e-300))
