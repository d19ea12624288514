"""What to record next: which candidates the data cannot tell apart, and the movement that would.

After Hunter and Reiner (1965): the best experiment is the one on which two rival models, each
refitted, differ most.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sstl_cli.diagnosis.search import Search
from sstl_cli.diagnosis.simulator import as_effects
from sstl_cli.physics.effect import Mechanics
from sstl_cli.physics.scenario import Configuration, Scenario, Trajectory
from sstl_cli.physics.trajectories import tension_path, times
from sstl_cli.physics.transmission import activate, predict
from sstl_cli.physics.transmission.model import drive_of, observed_output

Array = NDArray[np.float64]
SAMPLING_HZ = 100.0
MENU = (
    Trajectory(kind="trapezoid", label="fast trapezoid", duration_s=8.0, drive="tension"),
    Trajectory(kind="trapezoid", label="slow trapezoid", duration_s=80.0, drive="tension"),
    Trajectory(kind="ramp_hold", label="ramps with holds", duration_s=60.0, hold_s=4.0),
    Trajectory(kind="minor_loops", label="minor loops", duration_s=40.0),
    Trajectory(kind="chirp", label="chirp", duration_s=60.0),
    Trajectory(kind="random", label="random", duration_s=120.0),
)


@dataclass(frozen=True)
class Experiment:
    """The movement that separates two candidates best, and by how much (RMS in N, refitted)."""

    separates: tuple[str, str]
    trajectory: Trajectory
    distance_n: float
    here_n: float


def isolability(search: Search) -> tuple[list[str], Array]:
    """Return candidate ids and the cosine between their whitened responses, base parameters projected out."""
    singles = search.leaders(1)[:12]
    sim = search.sim
    responses = []
    for f in singles:
        jw = search.whiten(f.jacobian)
        own = jw[:, 0]
        power = np.maximum(np.bincount(sim.config, own**2), 1e-12)
        columns = []
        for i in range(len(f.free)):
            if f.free[i].parameter.shape:
                continue
            column = jw[:, 1 + i]
            column = column - own * (np.bincount(sim.config, own * column, len(power)) / power)[sim.config]
            columns.append(column)
        q, r = np.linalg.qr(np.stack(columns, axis=1)) if columns else (np.zeros((len(own), 1)), np.ones((1, 1)))
        responses.append(q[:, np.abs(np.diag(r)) > 1e-9])
    n = len(singles)
    cosine = np.eye(n)
    for i in range(n):
        for j in range(i):
            if responses[i].shape[1] and responses[j].shape[1]:
                overlap = np.linalg.svd(responses[i].T @ responses[j], compute_uv=False)
                cosine[i, j] = cosine[j, i] = float(min(overlap[0], 1.0))
    return [f.ids[0] for f in singles], cosine


def best_experiment(
    search: Search, first: tuple[str, ...], second: tuple[str, ...], mechanics: Mechanics
) -> Experiment | None:
    """Return the movement of the menu on which two fitted models differ most after refitting the second.

    The second model's free parameters are refitted to the first by one linearised step, theta included.
    """
    a, b = search.fits.get(tuple(sorted(first))), search.fits.get(tuple(sorted(second)))
    if a is None or b is None:
        return None
    theta = float(np.mean(a.theta))
    best: Experiment | None = None
    for trajectory in MENU:
        time = times(trajectory, SAMPLING_HZ)
        truth, rival, columns = [], [], []
        for system in search.sim.problem.systems:
            path = tension_path(trajectory, system, time, np.random.default_rng(0))
            truth.append(_response(system, path, theta, a.effects, mechanics))
            at = _response(system, path, theta, b.effects, mechanics)
            rival.append(at)
            block = [(_response(system, path, theta + 1e-4, b.effects, mechanics) - at) / 1e-4]
            for i, f in enumerate(b.free):
                moved = b.values.copy()
                h = 2e-3 * f.width * (1.0 if moved[i] + 2e-3 * f.width <= f.parameter.high else -1.0)
                moved[i] += h
                block.append((_response(system, path, theta, as_effects(b.free, moved), mechanics) - at) / h)
            columns.append(np.stack(block, axis=1))
        gap, j = np.concatenate(truth) - np.concatenate(rival), np.concatenate(columns)
        step = np.linalg.lstsq(j, gap, rcond=1e-8)[0]
        distance = float(np.sqrt(np.mean((gap - j @ step) ** 2)))
        if best is None or distance > best.distance_n:
            here = a.prediction - b.prediction
            best = Experiment(
                (" + ".join(first), " + ".join(second)), trajectory, distance, float(np.sqrt(np.mean(here**2)))
            )
    return best


def _response(
    system: str, path: Array, theta: float, effects: Mapping[str, Mapping[str, float]], mechanics: Mechanics
) -> Array:
    if "line" in effects:
        from dataclasses import replace

        mechanics = replace(mechanics, load_n_per_mm=1.0 / effects["line"]["load_mm_per_n"])
        effects = {k: v for k, v in effects.items() if k != "line"}
    active = activate(effects)
    dt = 1.0 / SAMPLING_HZ
    drive = drive_of(system, "CP", dt, path, mechanics)
    out = predict(drive, theta, active, 0.5 * float(path[0]))
    return observed_output(system, dt, path, out, active)


def scenario_of(search: Search, trajectory: Trajectory) -> Scenario:
    """Return a scenario that records the trajectory on the configurations of the log, for ``sstl simulate``."""
    p = search.sim.problem
    theta = search.base.theta
    locations = {r.config: r.location for r in p.records}
    configurations = tuple(
        Configuration(id=name, location=locations.get(i), theta=float(np.round(theta[i], 4)))
        for i, name in enumerate(p.configs)
    )
    systems = p.systems
    return Scenario(
        configurations=configurations,
        trajectories=(trajectory.model_copy(update={"systems": systems}),),
        sampling_hz=500.0,
    )
