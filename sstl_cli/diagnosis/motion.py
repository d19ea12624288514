"""Recordings that are driven by motion: the recorded position sets the sign of friction, not the input force.

A cylinder at constant pressure, or a sheath pulled over a tendon under dead load, slides although its input
hardly moves. Each propagation line then holds while the motion lasts; between them nothing is known.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sstl_cli.core.runs import Run
from sstl_cli.diagnosis.constants import BEFORE_TURN, BREAKAWAY_SHARE, EXPLAINED, LEAST_REVERSALS, SWING
from sstl_cli.diagnosis.latent import block_mean

Array = NDArray[np.float64]


def slip_of(run: Run, thin: int, n: int) -> Array | None:
    """Return the direction of slip on the simulation grid, shape (n,), or None where tensions drive the run.

    1 is pulling (output below input), -1 releasing; halves of it are a reversal, which turns where the motion does.
    """
    if run.position_in_mm is None or not np.isfinite(run.position_in_mm).all():
        return None
    x, u, y = (block_mean(v, thin)[:n] for v in (run.position_in_mm, run.tension_in_n, run.tension_out_n))
    slip = _sliding(x)
    sliding = np.abs(slip) == 1.0
    reversals = int(np.count_nonzero(np.diff(slip[sliding]) != 0.0)) if sliding.any() else 0
    if reversals < LEAST_REVERSALS or np.std(y) < SWING * np.std(u):
        return None
    s, out = slip[sliding], y[sliding]
    by_direction = out - np.where(s > 0, out[s > 0].mean(), out[s < 0].mean())
    if np.var(by_direction) > (1.0 - EXPLAINED) * np.var(out):
        return None
    # which way is pulling is a matter of how the position was counted: friction takes away there
    return slip if out[s > 0].mean() < out[s < 0].mean() else -slip


def _sliding(x: Array) -> Array:
    """Return the direction of a motion, half of it until it has come clear of its last turning point."""
    clear = BREAKAWAY_SHARE * float(np.ptp(x))
    slip = np.zeros(len(x))
    if clear == 0.0:
        return slip
    # between two successive turning points that lie further apart than ``clear``
    turn, at, direction = [0], 0, 0
    for i in range(1, len(x)):
        step = x[i] - x[at]
        if direction == 0:
            if abs(step) > clear:
                direction, at = int(np.sign(step)), i
        elif step * direction > 0:
            at = i
        elif -step * direction > clear:
            turn.append(at)
            direction, at = -direction, i
    turn.append(len(x) - 1)
    for a, b in zip(turn[:-1], turn[1:], strict=True):
        part = x[a : b + 1]
        way = np.sign(part[-1] - part[0])
        inside = (np.abs(part - part[0]) > clear) & (np.abs(part - part[-1]) > BEFORE_TURN * clear)
        slip[a : b + 1] = np.where(inside, way, 0.5 * way)
    return slip
