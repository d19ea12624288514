"""The base model re-tuned: one theta per configuration, by least squares on the play operator.

Written apart from the diagnosis, so that the strength of a case does not depend on the tool it tests.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

Array = NDArray[np.float64]


@njit(cache=True)
def play(u: Array, pull: float, release: float, start: float) -> Array:
    """Return Eq. (3) and (5) without bias: out = clip(out, pull u, release u), from a given start (N)."""
    out = np.empty_like(u)
    y = start
    for k in range(u.size):
        y = min(max(y, pull * u[k]), release * u[k])
        out[k] = y
    return out


@dataclass(frozen=True)
class Pair:
    """Input and output tension (N, shape (n,)) of one run, its configuration and its passes (1 or 2)."""

    config: int
    passes: int
    t_in: Array
    t_out: Array


def residuals(pairs: Sequence[Pair], theta: Sequence[float]) -> list[Array]:
    """Return measured minus base output (N) of every run."""
    found = []
    for p in pairs:
        factor = float(np.exp(p.passes * theta[p.config]))
        found.append(p.t_out - play(p.t_in, 1.0 / factor, factor, float(p.t_out[0])))
    return found


def retune(pairs: Sequence[Pair], first: Sequence[float]) -> list[float]:
    """Return the theta of each configuration that leaves the least squared error, from a first guess (rad)."""
    theta = [float(t) for t in first]
    for config in range(len(theta)):
        own = [p for p in pairs if p.config == config]
        if not own:
            continue
        single = [Pair(0, p.passes, p.t_in, p.t_out) for p in own]

        def cost(value: float, single: list[Pair] = single) -> float:
            return sum(float(r @ r) for r in residuals(single, [value]))

        grid = np.linspace(0.5, 1.6, 23) * max(theta[config], 0.05)
        best = int(np.argmin([cost(float(g)) for g in grid]))
        low, high = grid[max(best - 1, 0)], grid[min(best + 1, len(grid) - 1)]
        theta[config] = float(minimize_scalar(cost, bounds=(low, high), method="bounded", options={"xatol": 1e-7}).x)
    return theta


def gap_n(pairs: Sequence[Pair], first: Sequence[float]) -> tuple[float, list[float]]:
    """Return the RMS error (N) that the re-tuned base leaves, and its theta."""
    theta = retune(pairs, first)
    parts = residuals(pairs, theta)
    size = sum(r.size for r in parts)
    return float(np.sqrt(sum(float(r @ r) for r in parts) / max(size, 1))), theta
