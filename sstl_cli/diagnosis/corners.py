"""What an input does at its corners: what holds keep says so.

A line holds the extreme that was reached, not the one that was sampled. A recorder of a steady rig misses it by a little each
time, and by less behind a drive that lags; a simulator that steps from sample to sample never does. Each hold is one reading of
which of them it was.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from sstl_cli.core.stretches import stretches
from sstl_cli.diagnosis.constants import DECIDES_NATS, HELD, ROUNDINGS, THETA_STEP
from sstl_cli.diagnosis.driven import WITHIN
from sstl_cli.diagnosis.fit import Fit, first_theta, fit
from sstl_cli.diagnosis.hypotheses import Hypothesis
from sstl_cli.diagnosis.records import Passes, Problem, passing, rounded
from sstl_cli.diagnosis.simulator import Simulator
from sstl_cli.diagnosis.whitening import white

Array = NDArray[np.float64]
# lags of a drive that rounds corners between two samples, in steps of the simulation
LAGS = (0.0, 0.5**2, 0.5, 1.0)


def likelier(sim: Simulator, nominal: Array) -> tuple[Simulator, Array]:
    """Return the simulator whose input does at corners what holds say, and the theta of its base (unwhitened).

    Parameters
    ----------
    sim : Simulator
        Its input keeps to its samples.
    nominal : ndarray, shape (configurations,)
    """
    liked = np.sum([r.rounds for r in sim.problem.records], axis=0)
    if liked.max() > DECIDES_NATS:
        # the readings themselves say that corners are rounded, and how far
        sim = replace(sim, problem=rounded(sim.problem, ROUNDINGS[int(np.argmax(liked))]))
        return sim, _base(sim, nominal).theta
    first = _base(sim, nominal)
    if all(r.corner is None for r in sim.problem.records):
        return sim, first.theta
    lags = [k * max(r.dt_s for r in sim.problem.records) for k in LAGS]
    ways = [passing(sim.problem, Passes(lag, WITHIN)) for lag in lags]
    steps = THETA_STEP * np.eye(len(first.theta))
    slopes = np.stack([sim.predict(first.theta + s, {}) - first.prediction for s in steps])
    found = passes(*_offered(sim, first, ways, slopes))
    if found is not None:
        new = passing(sim.problem, Passes(lags[found[0]], found[1]))
    else:
        new = rounded(sim.problem, ROUNDINGS[0])
        if passes(*_offered(sim, first, [new], slopes)) is None:
            return sim, first.theta
    sim = replace(sim, problem=new)
    return sim, _base(sim, nominal).theta


def _offered(sim: Simulator, first: Fit, ways: Sequence[Problem], slopes: Array) -> tuple[Array, Array, Array]:
    """Return the means of holds that the arguments of ``passes`` are: what is left, what ways add, what theta changes."""
    added = np.stack([replace(sim, problem=w).predict(first.theta, {}) - first.prediction for w in ways])
    means = holds(sim, first, np.concatenate((added, slopes)))
    return means[0], means[1 : 1 + len(ways)], means[1 + len(ways) :]


def _base(sim: Simulator, nominal: Array) -> Fit:
    whiten = white(1.0, sim.weight, [s.start for s in sim.slices()])
    return fit(sim, whiten, Hypothesis((), ()), first_theta(sim, nominal), np.zeros(0))


def holds(sim: Simulator, base: Fit, columns: Array) -> Array:
    """Return the mean of each hold that corners reach (N, shape (1 + k, holds)): of what the base leaves, and of columns.

    Parameters
    ----------
    columns : ndarray, shape (k, samples)
        First what sharp corners add to the prediction (N), then whatever else.
    """
    held = (sim.phases(base.theta, {}).slide < HELD) & (sim.weight > 0.0) & (columns[0] != 0.0)
    found = [(a + s.start, b + s.start) for s in sim.slices() for a, b in stretches(held[s])]
    rows = np.concatenate(((sim.y - base.prediction)[None], columns))
    return np.array([rows[:, a:b].mean(axis=1) for a, b in found]).reshape(-1, len(rows)).T


def passes(left: Array, added: Array, slopes: Array) -> tuple[int, float] | None:
    """Return by which of several ways to pass their samples holds are off, and the mean square that it leaves of corners; None if by none.

    At 49 to 1 over none, and neither by half of it nor by far more: an effect that is missing leaves holds off as
    well, but not in that measure. What theta does to holds is nobody's evidence.

    Parameters
    ----------
    left : ndarray, shape (holds,)
    added : ndarray, shape (ways, holds)
        What each way adds (N), the first that of sharp corners.
    slopes : ndarray, shape (configurations, holds)
    """
    if not np.any(added[0]):
        return None
    rows = np.concatenate((left[None], added)).T
    by_theta, _, rank, _ = np.linalg.lstsq(slopes.T, rows, rcond=None)
    left, *rest = (rows - slopes.T @ by_theta).T
    added = np.array(rest)
    squares = np.sum((left - added) ** 2, axis=1)
    best, free = int(np.argmin(squares)), len(left) - int(rank)
    own = float(added[best] @ added[best])
    if free < 1 or own <= 0.0:
        return None
    share = float(left @ added[best]) / own
    decided = squares[best] < float(left @ left) * float(np.exp(-2.0 * DECIDES_NATS / free))
    if not decided or round(share) not in (1, 2):
        return None
    return best, min(float(squares[best]) / float(added[0] @ added[0]), WITHIN)
