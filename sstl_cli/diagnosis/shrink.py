"""How far the gap shrinks: bootstrap interval, intervals of parameters, regions made worse."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sstl_cli.core.rng import stream
from sstl_cli.diagnosis import by_run
from sstl_cli.diagnosis.constants import DRAWS, WORSE, WORSE_OF_ALL
from sstl_cli.diagnosis.evidence import inverse
from sstl_cli.diagnosis.fit import Fit, normal_equations
from sstl_cli.diagnosis.free import RUNS
from sstl_cli.diagnosis.heldout import blocks
from sstl_cli.diagnosis.simulator import Simulator

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Interval:
    """An estimate and its 95 % interval."""

    estimate: float
    low: float
    high: float


def shrinkage(sim: Simulator, base: Array, other: Array, fine_n: float = 0.0) -> Interval | None:
    """Return by how many percent the held-out RMSE falls, with a 95 % interval for a fresh recording of that length.

    It is a paired bootstrap over runs and their blocks: what is fresh differs from run to run more than from block to block.
    None where there is but one block: all draws of it are alike, which says nothing of how sure the number is.

    Parameters
    ----------
    base, other : ndarray, shape (samples,)
        Held-out residuals in N.
    fine_n : float
        Noise above the analysis rate (N), which both errors contain at the full rate.
    """
    w = sim.weight
    index = blocks(sim)
    a, b = np.bincount(index, w * base**2), np.bincount(index, w * other**2)
    n = np.bincount(index, w)
    if np.count_nonzero(n) < 2:
        return None
    draws = _draws(sim.run[np.unique(index, return_index=True)[1]])
    extra = fine_n**2

    def percent(x: Array, y: Array, count: Array) -> Array:
        return np.asarray(100.0 * (1.0 - np.sqrt((y / count + extra) / np.maximum(x / count + extra, 1e-300))))

    spread = percent(a[draws].sum(axis=1), b[draws].sum(axis=1), np.maximum(n[draws].sum(axis=1), 1.0))
    estimate = float(percent(a.sum(), b.sum(), np.maximum(n.sum(), 1.0)))
    # a fresh recording scatters as much as this one did; runs that are drawn among themselves scatter less than they do
    count = len(np.unique(sim.run))
    wider = np.sqrt(2.0 * count / max(count - 1, 1))
    low, high = estimate + wider * (np.percentile(spread, [2.5, 97.5]) - estimate)
    return Interval(estimate, float(min(low, estimate)), float(min(max(high, estimate), 100.0)))


def _draws(run_of_block: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return indices of blocks, shape (DRAWS, blocks): runs with replacement, then blocks of each drawn run likewise."""
    rng = stream(0, "shrink")
    starts = np.flatnonzero(np.diff(run_of_block, prepend=-1))
    lengths = np.diff(starts, append=len(run_of_block))
    runs = rng.integers(0, len(starts), (DRAWS, len(run_of_block)))
    # every block of a draw comes from the run drawn for its place
    runs = np.take_along_axis(runs, np.broadcast_to(run_of_block, runs.shape), axis=1)
    return np.asarray(starts[runs] + (rng.random(runs.shape) * lengths[runs]).astype(np.int64))


def parameter_intervals(sim: Simulator, f: Fit) -> list[Interval | None]:
    """Return 95 % intervals of the free parameters, None where the data do not hold one.

    The larger of what the noise gives and a sandwich over time blocks, so that coloured misfit widens them (White 1982).
    """
    jw, rw = f.whiten(f.jacobian), f.whiten.left(f.residual)
    a, _ = normal_equations(sim, jw, rw)
    configs = len(f.theta)
    index = blocks(sim)
    count = int(index.max()) + 1
    score = np.zeros((count, len(a)))
    score[:, :configs] = np.bincount(index * configs + sim.config, jw[:, 0] * rw, count * configs).reshape(count, configs)
    for i in range(len(f.free)):
        score[:, configs + i] = np.bincount(index, jw[:, 1 + i] * rw, count)
    known = inverse(a, 1e-9)
    sandwich = known @ (score.T @ score) @ known * (count / max(count - len(a), 1))
    # a direction without information gives a variance of rounding errors, of either sign
    se = np.sqrt(np.maximum(np.maximum(np.diag(sandwich), np.diag(known))[configs:], 0.0))
    found = [_interval(f, i, 1.96 * float(s)) for i, s in enumerate(se)]
    for i, x in enumerate(f.free):
        if x.effect is RUNS:
            found[i] = Interval(float(f.values[i]), *by_run.interval(sim, float(f.values[i])))
    return found


def _interval(f: Fit, i: int, reach: float) -> Interval | None:
    p, v = f.free[i].parameter, float(f.values[i])
    if not np.any(f.jacobian[:, 1 + i]) or reach == 0.0 or reach > p.most - p.least:
        return None
    return Interval(v, v - reach, v + reach)


def identifiability(f: Fit, i: int, interval: Interval | None) -> str:
    """Return whether a parameter is identifiable, weak or not identifiable on this data."""
    width = np.inf if interval is None else interval.high - interval.low
    if interval is None or width > 2.0 * f.free[i].width:
        return "not_identifiable"
    neutral = f.free[i].parameter.neutral
    clear = interval.low > neutral or interval.high < neutral
    return "identifiable" if (clear or f.free[i].parameter.shape) and width < 0.5 * f.free[i].width else "weak"


def worse_regions(sim: Simulator, base: Array, other: Array, code: NDArray[np.int64]) -> list[str]:
    """Return system and phase regions whose held-out error (N) grew by more than a tenth."""
    systems = sim.problem.systems
    of_run = np.array([systems.index(r.system) for r in sim.problem.records])
    key = of_run[sim.run] * 4 + code
    a = np.bincount(key, sim.weight * base**2, 4 * len(systems))
    b = np.bincount(key, sim.weight * other**2, 4 * len(systems))
    floor = WORSE_OF_ALL * a.sum()
    names = ("PB", "PP", "RB", "RP")
    return [f"{systems[k // 4]} {names[k % 4]}" for k in range(len(a)) if b[k] > WORSE * a[k] and b[k] - a[k] > floor]
