"""A drive that pulls both ways: a pair of tendons stretched against each other, of which the readings are the difference.

A tendon cannot push. Where an input goes well below zero it is no tension of one tendon but what a pair, or a rod, carries beyond a
preload; friction acts on all of it, so that a loop is wide even where nothing is read. How far the pair is stretched is a constant of
the rig like its stiffness, and nobody's fault.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from sstl_cli.core.runs import Run
from sstl_cli.diagnosis.constants import HALF, MAX_ITERATIONS, PRELOADS, START_FACTORS, THETA_HIGH, THETA_LOW, THETA_STEP, UNSEEN_SHARE
from sstl_cli.diagnosis.records import Problem, prepare, representatives
from sstl_cli.diagnosis.simulator import Simulator
from sstl_cli.identification.gate.shapes import BOTH_WAYS
from sstl_cli.physics.effect import NOMINAL_THETA, Mechanics
from sstl_cli.physics.scenario import Scenario

Array = NDArray[np.float64]


def preload_of(runs: Sequence[Run], sim: Scenario | None) -> dict[str, float]:
    """Return by how much (N) the tendons of each system are stretched where they read nothing; systems that only pull are left out.

    Parameters
    ----------
    sim : Scenario, optional
        The user's simulator: what it says holds, and a model that was accepted before has said it.

    Raises
    ------
    SstlError
        If no run of a system that pulls both ways can be used.
    """
    if sim is not None and (sim.rig.preload_n is not None or sim.package_version is not None):
        return {str(k): v for k, v in (sim.rig.preload_n or {}).items()}
    found = {}
    for system in sorted({r.system for r in runs}):
        own = [r for r in runs if r.system == system and np.isfinite(r.tension_in_n).any()]
        # one run that goes below zero among others that pull is at fault
        if own and np.mean([_both_ways(*_range([r])) for r in own]) >= HALF:
            found[system] = _likeliest(own, *_range(own))
    return found


def _both_ways(low: float, high: float) -> bool:
    # negative throughout is a sign, not a drive that goes both ways
    return low < -BOTH_WAYS * high < 0.0


def _range(runs: Sequence[Run]) -> tuple[float, float]:
    """Return between which tensions (N) inputs were read, but for a small share at either end."""
    read = [np.nanquantile(r.tension_in_n, [UNSEEN_SHARE, 1.0 - UNSEEN_SHARE]) for r in runs]
    return min(float(x[0]) for x in read), max(float(x[1]) for x in read)


def _likeliest(runs: Sequence[Run], low: float, high: float) -> float:
    """Return the preload (N) with which friction alone leaves least of some runs, whatever the scale and the zero of the output.

    Sought together with a theta for each bend (variable projection, Golub and Pereyra 1973), from the best of a few of either.
    """
    problem = representatives(prepare(runs))
    system, root = problem.systems[0], np.sqrt(np.concatenate([r.weight for r in problem.records]))
    first = _reading(problem) if any(r.unit_out != "N" for r in runs) else (1.0, 0.0)

    def preload(x: Array) -> float:
        return float(np.exp(x[-1])) * (high - low) - low

    def left(x: Array) -> Array:
        sim, read = Simulator(problem, Mechanics(preload_n={system: preload(x)})), first
        # where an output begins is known once its scale is
        for _ in range(2):
            sim.read_as(*read)
            predicted = sim.predict(np.exp(x[:-1]), {})
            columns = np.column_stack((predicted, np.ones(len(predicted)))) * root[:, None]
            read = np.linalg.lstsq(columns, root * sim.y, rcond=None)[0]
        return np.asarray(root * sim.y - columns @ read, np.float64)

    tried = [np.array([*[np.log(NOMINAL_THETA * f)] * len(problem.configs), np.log(share)]) for f in START_FACTORS for share in PRELOADS]
    begin = min(tried, key=lambda x: float(np.sum(left(x) ** 2)))
    lowest = [*[np.log(THETA_LOW)] * len(problem.configs), np.log(PRELOADS[0])]
    highest = [*[np.log(THETA_HIGH)] * len(problem.configs), np.log(PRELOADS[-1])]
    return preload(least_squares(left, begin, bounds=(lowest, highest), diff_step=THETA_STEP, max_nfev=MAX_ITERATIONS).x)


def _reading(problem: Problem) -> tuple[float, float]:
    """Return gain and zero (in the output's unit) with which outputs would read what inputs do on average."""
    u, y = np.concatenate([r.u for r in problem.records]), np.concatenate([r.y for r in problem.records])
    gain = float(np.ptp(y) / np.ptp(u)) or 1.0
    return gain, float(np.mean(y) - gain * np.mean(u))
