"""Compiled recursions that move the output between the envelopes."""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]
Counts = NDArray[np.int64]


@njit(cache=True, nogil=True)
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
def _look_up(table: Array, j: int, u: float, row: int, part: float) -> float:
    """Return a table's value at column ``j`` and ``u`` of the way to the next, ``part`` of the way from a row to the next."""
    value: float = table[row, j] + u * (table[row, j + 1] - table[row, j])
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


@njit(cache=True, nogil=True)
def bounded_play(
    tension: Array, pull: Array, release: Array, tension_step: float, scale: Array, scale0: float, scale_step: float, start: float
) -> Array:
    """Return the play between tabulated envelopes whose friction factor may change with time.

    ``scale`` has shape (n,), or (1,) for a constant factor.
    """
    out = np.empty_like(tension)
    rows, last = pull.shape[0], pull.shape[1] - 2
    row, part = _row(scale[0], scale0, scale_step, rows)
    varying = scale.size > 1
    y = start
    for k in range(tension.size):
        if varying:
            row, part = _row(scale[k], scale0, scale_step, rows)
        # both tables have the same columns
        x = tension[k] / tension_step
        j = min(max(int(x), 0), last)
        low, high = _look_up(pull, j, x - j, row, part), _look_up(release, j, x - j, row, part)
        if k == 0 and math.isnan(y):
            y = 0.5 * (low + high)
        y = max(max(low, 0.0), min(y, max(high, 0.0)))
        out[k] = y
    return out


@njit(cache=True, nogil=True)
def play_runs(tension: Array, edges: Counts, gamma_p: Array, gamma_r: Array, start: Array) -> Array:
    """Return the play of several runs laid end to end, the input not below zero; run i is ``edges[i]`` to ``edges[i + 1]``."""
    out = np.empty_like(tension)
    for i in range(edges.size - 1):
        a, b = edges[i], edges[i + 1]
        out[a:b] = play_operator(np.maximum(tension[a:b], 0.0), gamma_p[i], 0.0, gamma_r[i], 0.0, start[i])
    return out


@njit(cache=True, nogil=True)
def bounded_runs(
    tension: Array,
    edges: Counts,
    table: Counts,
    pull: Array,
    release: Array,
    rows: Counts,
    tension_step: Array,
    scale: Array,
    scale0: Array,
    scale_step: Array,
    start: Array,
) -> Array:
    """Return the play of several runs laid end to end; run i lies between the tabulated envelopes ``table[i]``.

    Table k has the rows ``rows[k]`` to ``rows[k + 1]``; ``scale`` has shape (n,), or (1,) for a constant factor.
    """
    out = np.empty_like(tension)
    for i in range(edges.size - 1):
        a, b, k = edges[i], edges[i + 1], table[i]
        c, d = rows[k], rows[k + 1]
        mine = scale[a:b] if scale.size > 1 else scale
        out[a:b] = bounded_play(tension[a:b], pull[c:d], release[c:d], tension_step[k], mine, scale0[k], scale_step[k], start[i])
    return out
