"""How far the gap shrinks: held-out errors, bootstrap interval, regions made worse, stability of parameters."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sstl_cli.core.rng import stream
from sstl_cli.diagnosis.decide import Candidate, Decision
from sstl_cli.diagnosis.fit import normal_equations
from sstl_cli.diagnosis.heldout import blocks
from sstl_cli.diagnosis.search import Search

Array = NDArray[np.float64]
# so much wider hold 95 % of the parameters of the rig, more of the fast model (tools/statistics_table.py, seed 77)
WIDER = 2.0
DRAWS = 1000


@dataclass(frozen=True)
class Interval:
    """An estimate and its 95 % interval."""

    estimate: float
    low: float
    high: float


def shrinkage(search: Search, base: Candidate, other: Candidate, fine_n: float = 0.0) -> Interval:
    """Return by how many percent the held-out RMSE falls, with a 95 % interval for a fresh recording of that length.

    It is a paired bootstrap over runs and their blocks: what is fresh differs from run to run more than from block to block.

    Parameters
    ----------
    fine_n : float
        Noise above the analysis rate (N), which both errors contain at the full rate.
    """
    w = search.sim.weight
    index = blocks(search.sim)
    a, b = np.bincount(index, w * base.raw**2), np.bincount(index, w * other.raw**2)
    n = np.bincount(index, w)
    draws = _draws(search.sim.run[np.unique(index, return_index=True)[1]])
    extra = fine_n**2

    def percent(x: Array, y: Array, count: Array) -> Array:
        return np.asarray(100.0 * (1.0 - np.sqrt((y / count + extra) / np.maximum(x / count + extra, 1e-300))))

    spread = percent(a[draws].sum(axis=1), b[draws].sum(axis=1), np.maximum(n[draws].sum(axis=1), 1.0))
    estimate = float(percent(a.sum(), b.sum(), np.maximum(n.sum(), 1.0)))
    # a fresh recording scatters as much as this one did
    low, high = estimate + np.sqrt(2.0) * (np.percentile(spread, [2.5, 97.5]) - estimate)
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


def parameter_intervals(search: Search, c: Candidate) -> list[Interval]:
    """Return 95 % intervals of the free parameters: a sandwich over time blocks, so coloured misfit widens them.

    What noise of the input does to the slopes is no scatter but a bias, which grows with that scatter: hence ``WIDER``.
    """
    f, sim = c.fit, search.sim
    jw, rw = search.whiten(f.jacobian), search.whiten(f.residual)
    a, _ = normal_equations(sim, jw, rw)
    configs = len(f.theta)
    index = blocks(sim)
    count = int(index.max()) + 1
    score = np.zeros((count, len(a)))
    np.add.at(score, (index, sim.config), jw[:, 0] * rw)
    for i in range(len(f.free)):
        score[:, configs + i] = np.bincount(index, jw[:, 1 + i] * rw, count)
    inverse = np.linalg.pinv(a + 1e-9 * np.diag(np.diag(a) + 1e-12))
    sandwich = inverse @ (score.T @ score) @ inverse * (count / max(count - len(a), 1))
    # a direction without information gives a variance of rounding errors, of either sign
    se = np.sqrt(np.maximum(np.maximum(np.diag(sandwich), np.diag(inverse))[configs:], 0.0))
    reach = 1.96 * WIDER * se
    return [Interval(float(v), float(v - r), float(v + r)) for v, r in zip(f.values, reach, strict=True)]


def identifiability(c: Candidate, i: int, interval: Interval) -> str:
    """Return whether a parameter is identifiable, weak or not identifiable on this data."""
    f = c.fit.free[i]
    width = interval.high - interval.low
    if not np.any(c.fit.jacobian[:, 1 + i]) or width > 2.0 * f.width:
        return "not_identifiable"
    neutral = f.parameter.neutral
    clear = interval.low > neutral or interval.high < neutral
    return "identifiable" if (clear or f.parameter.shape) and width < 0.5 * f.width else "weak"


def worse_regions(search: Search, base: Candidate, other: Candidate, code: NDArray[np.int64]) -> list[str]:
    """Return system and phase regions whose held-out error grew by more than a tenth."""
    sim = search.sim
    systems = sim.problem.systems
    of_run = np.array([systems.index(r.system) for r in sim.problem.records])
    key = of_run[sim.run] * 4 + code
    a = np.bincount(key, sim.weight * base.raw**2, 4 * len(systems))
    b = np.bincount(key, sim.weight * other.raw**2, 4 * len(systems))
    floor = 0.02 * a.sum()
    names = ("PB", "PP", "RB", "RP")
    return [f"{systems[k // 4]} {names[k % 4]}" for k in range(len(a)) if b[k] > 1.21 * a[k] and b[k] - a[k] > floor]


def stable(search: Search, decision: Decision) -> bool:
    """Whether the winner's parameters agree between folds (a deceptive repair differs from run to run)."""
    c = decision.winner
    if c is None or decision.folds.count < 2 or not len(c.fit.free):
        return True
    sim = search.sim
    jw, rw = search.whiten(c.fit.jacobian), search.whiten(c.fit.residual)
    intervals = parameter_intervals(search, c)
    configs = len(c.fit.theta)
    for fold in range(decision.folds.count):
        rows = decision.folds.of_sample != fold
        a, b = normal_equations(sim, jw * rows[:, None], rw)
        step = np.linalg.lstsq(a + 1e-9 * np.diag(np.diag(a) + 1e-12), b, rcond=1e-10)[0][configs:]
        for i, interval in enumerate(intervals):
            if c.fit.free[i].parameter.shape:
                continue
            half = 0.5 * (interval.high - interval.low)
            size = abs(c.fit.values[i] - c.fit.free[i].parameter.neutral)
            if abs(step[i]) > 4.0 * half and abs(step[i]) > 0.3 * size:
                return False
    return True
