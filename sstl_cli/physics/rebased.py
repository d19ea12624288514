"""Diagnose another simulator: its log for the same input takes the place of the built-in base."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from sstl_cli.core.errors import SstlError
from sstl_cli.core.runs import Run
from sstl_cli.physics.transmission import play_operator

# the extra channel that holds what the other simulator misses, in the unit of the output
MISSED = "missed_by_other"


def rebase(measured: Sequence[Run], simulated: Sequence[Run]) -> list[Run]:
    """Return measured runs with the other simulator's error put on the built-in base.

    What the other simulator misses, ``measured - simulated``, is added to the output of the built-in
    base for the same input. The diagnosis then finds which effect, added to that simulator, explains it. What is missed stands in
    ``extra`` as well: the theta of that base is nobody's, so that as given the base would be off by something else.

    Raises
    ------
    SstlError
        If a measured run has no simulated twin (same run_id), the two inputs do not overlap in time, or both outputs are the same.
    """
    twins = {r.run_id: r for r in simulated}
    bends: dict[tuple[str | None, str | None], list[Run]] = {}
    for of in simulated:
        if len(of):
            bends.setdefault(_bend(of), []).append(of)
    # a theta for each run would make a difference between systems of what the other simulator holds
    thetas = {bend: _theta(runs) for bend, runs in bends.items()}
    out = []
    for run in measured:
        twin = twins.get(run.run_id)
        if twin is None or not len(twin):
            raise SstlError(
                f"run {run.run_id!r} has no twin in the simulated log",
                fix="use the same run_id in both; for what has changed since another session: --before LOG",
                code="E910",
            )
        inside = (run.time_s >= twin.time_s[0]) & (run.time_s <= twin.time_s[-1])
        if inside.sum() < 0.5 * len(run):
            fix = "give logs of the same recording, on one clock"
            raise SstlError(f"run {run.run_id!r}: the two logs overlap in less than half of the time", fix=fix, code="E911")
        there = np.interp(run.time_s, twin.time_s, twin.tension_out_n)
        if np.array_equal(run.tension_out_n[inside], there[inside]):
            # what is left would be the base itself, without noise, which the gate takes for a sensor that is stuck
            fix = "give --against the log of the other simulator"
            raise SstlError(f"run {run.run_id!r}: both logs hold the same output, so that no gap is left", fix=fix, code="E911")
        theta = thetas[_bend(twin)]
        n = run.passes
        base = play_operator(run.tension_in_n, np.exp(-n * theta), 0.0, np.exp(n * theta), 0.0, float(run.tension_out_n[0]))
        missed = run.tension_out_n - there
        moved = replace(run, tension_out_n=base + missed, extra={**run.extra, MISSED: missed})
        out.append(moved.cut(inside))
    return out


def _bend(run: Run) -> tuple[str | None, str | None]:
    """Return what has one theta for both systems: the configuration, of an unlabelled run the run itself."""
    return (run.config_id, run.tendon) if run.config_id is not None else (run.run_id, None)


def _theta(runs: Sequence[Run]) -> float:
    """Return the theta that the other simulator most nearly has in one bend: least squares on a grid, then refined."""

    def error(theta: float) -> float:
        angles = [(r, r.passes * theta) for r in runs]
        each = (
            play_operator(r.tension_in_n, np.exp(-x), 0.0, np.exp(x), 0.0, float(r.tension_out_n[0])) - r.tension_out_n for r, x in angles
        )
        return float(np.mean(np.concatenate(list(each)) ** 2))

    grid = np.linspace(0.02, 1.5, 75)
    best = grid[int(np.argmin([error(t) for t in grid]))]
    from scipy.optimize import minimize_scalar

    return float(minimize_scalar(error, bounds=(max(best - 0.03, 0.01), best + 0.03), method="bounded").x)
