"""Compiled recursions that move the output between the envelopes."""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]


@njit(cache=True, fastmath={"contract"})
def play_operator(tension_in: Array, gamma_p: float, beta_p: float, gamma_r: float, beta_r: float, start: float) -> Array:
    """Return out[k] = clip(out[k-1], Gp in[k] + bp, Gr in[k] + br), Eqs. (3) and (5).

    Parameters
    ----------
    tension_in : ndarray, shape (n,)
        Input tension in N.
    gamma_p, gamma_r : float
        Propagation slopes.
    beta_p, beta_r : float
        Biases in N.
    start : float
        Output tension in N before the first sample; NaN starts midway between the lines.

    Examples
    --------
    >>> play_operator(np.array([10.0, 20.0, 15.0, 2.0]), 0.5, 0.0, 2.0, 0.0, 5.0).tolist()
    [5.0, 10.0, 10.0, 4.0]
    """
    out = np.empty_like(tension_in)
    y = start
    if math.isnan(y) and tension_in.size:
        y = 0.5 * ((gamma_p + gamma_r) * tension_in[0] + beta_p + beta_r)
    for k in range(tension_in.size):
        t = tension_in[k]
        low = gamma_p * t + beta_p
        high = gamma_r * t + beta_r
        y = max(low, min(y, high))
        out[k] = y
    return out


@njit(cache=True, inline="always")
def _look_up(table: Array, tension: float, step: float, row: int, part: float) -> float:
    x = tension / step
    j = int(x)
    last = table.shape[1] - 2
    if j > last:
        j = last
    if j < 0:
        j = 0
    u = x - j
    value = table[row, j] + u * (table[row, j + 1] - table[row, j])
    if part > 0.0:
        upper = table[row + 1, j] + u * (table[row + 1, j + 1] - table[row + 1, j])
        value += part * (upper - value)
    return value


@njit(cache=True, inline="always")
def _row(scale: float, scale0: float, step: float, rows: int) -> tuple[int, float]:
    if rows < 2:
        return 0, 0.0
    x = (scale - scale0) / step
    i = min(max(int(x), 0), rows - 2)
    return i, min(max(x - i, 0.0), 1.0)


@njit(cache=True)
def bounded_play(
    tension: Array, pull: Array, release: Array, tension_step: float, scale: Array, scale0: float, scale_step: float,
    start: float,
) -> Array:
    """Return the play between tabulated envelopes whose friction factor may change with time.

    ``scale`` has shape (n,), or (1,) for a constant factor.
    """
    out = np.empty_like(tension)
    rows = pull.shape[0]
    row, part = _row(scale[0], scale0, scale_step, rows)
    varying = scale.size > 1
    y = start
    if math.isnan(y) and tension.size:
        low = _look_up(pull, tension[0], tension_step, row, part)
        y = 0.5 * (low + _look_up(release, tension[0], tension_step, row, part))
    for k in range(tension.size):
        if varying:
            row, part = _row(scale[k], scale0, scale_step, rows)
        low = max(_look_up(pull, tension[k], tension_step, row, part), 0.0)
        high = max(_look_up(release, tension[k], tension_step, row, part), 0.0)
        y = max(low, min(y, high))
        out[k] = y
    return out


@njit(cache=True)
def cascade(
    tension: Array, pull: Array, release: Array, tension_step: float, scale: Array, scale0: float, scale_step: float,
    start: float, shares: Array, gain: Array, dt: float, static_ratio: float, static_rate: float, aging: float,
    aging_s: float, rate: Array,
) -> Array:
    """Return the output of a line in which friction turns round gradually, drags, and sticks.

    Parameters
    ----------
    shares : ndarray, shape (J,)
        Relative widths c_j of the plays that make up presliding (mean 1; one entry 1 is a pure play).
    gain : ndarray, shape (M,)
        Per stage of drag, 1 - exp(-dt / tau_m): how far the tension moves to its bound in one sample.
    static_ratio, static_rate, aging, aging_s : float
        Static over kinetic friction, the input rate (N/s) at which it fades, and strengthening at rest.
    rate : ndarray, shape (n,)
        Input rate in N/s.
    """
    n, plays, stages = tension.size, shares.size, gain.size
    out = np.empty_like(tension)
    rows = pull.shape[0]
    varying = scale.size > 1
    row, part = _row(scale[0], scale0, scale_step, rows)
    state = np.empty((stages, plays))
    rest = np.zeros(plays)
    sticky = static_ratio > 1.0 or aging > 0.0
    low = _look_up(pull, tension[0], tension_step, row, part)
    high = _look_up(release, tension[0], tension_step, row, part)
    y0 = 0.5 * (low + high) if math.isnan(start) else start
    for j in range(plays):
        for m in range(stages):
            x = (m + 1.0) / stages
            mid = tension[0] + x * (y0 - tension[0])
            state[m, j] = mid
    for k in range(n):
        if varying:
            row, part = _row(scale[k], scale0, scale_step, rows)
        t = tension[k]
        low = _look_up(pull, t, tension_step, row, part)
        high = _look_up(release, t, tension_step, row, part)
        total = 0.0
        for j in range(plays):
            # each stage takes its share of the way to the envelope, so that stages in a row give the whole
            upstream = t
            for m in range(stages):
                if stages == 1:
                    lo = t + shares[j] * (low - t)
                    hi = t + shares[j] * (high - t)
                else:
                    f = 1.0 / stages
                    ratio_lo = shares[j] * (max(low, 1e-9) / t - 1.0) + 1.0 if t > 1e-6 else 1.0
                    ratio_hi = shares[j] * (max(high, 1e-9) / t - 1.0) + 1.0 if t > 1e-6 else 1.0
                    lo = upstream * max(ratio_lo, 1e-9) ** f
                    hi = upstream * ratio_hi**f
                y = state[m, j]
                target = max(lo, min(y, hi))
                if sticky and stages == 1:
                    extra = 0.0
                    if rest[j] >= 0.0:
                        extra = aging * math.log(1.0 + rest[j] / aging_s)
                        if static_ratio > 1.0:
                            v = rate[k] / static_rate
                            extra += (static_ratio - 1.0) * math.exp(-v * v)
                    if target != y:
                        # friction holds until the stronger, static envelope is left
                        grown = (lo - t) * (1.0 + extra) + t if target > y else (hi - t) * (1.0 + extra) + t
                        holds = y >= grown if target > y else y <= grown
                        if holds and extra > 0.0:
                            target = y
                            rest[j] += dt
                        else:
                            v = rate[k] / static_rate
                            slow = static_ratio > 1.0 and math.exp(-v * v) > 1e-3
                            rest[j] = 0.0 if slow else -1.0
                    else:
                        rest[j] = max(rest[j], 0.0) + dt
                y += gain[m] * (target - y)
                state[m, j] = y
                upstream = y
            total += max(upstream, 0.0)
        out[k] = total / plays
    return out
