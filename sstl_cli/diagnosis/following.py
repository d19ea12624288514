"""What to record next: which candidates the data cannot tell apart, and the movement that would.

After Hunter and Reiner (1965): the best experiment is the one on which two rival models, each refitted, differ most; here
in squared standard deviations of this rig's noise (D^2), at the highest rate that was recorded.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sstl_cli.core.errors import SstlError
from sstl_cli.core.rng import stream
from sstl_cli.core.runs import Run
from sstl_cli.diagnosis.evidence import Weighed
from sstl_cli.diagnosis.fit import Fit, fit
from sstl_cli.diagnosis.limit import DECIDABLE, distance2
from sstl_cli.diagnosis.records import prepare
from sstl_cli.diagnosis.search import Search
from sstl_cli.diagnosis.simulator import Simulator
from sstl_cli.diagnosis.whitening import whitener
from sstl_cli.physics.scenario import Configuration, Scenario, Trajectory
from sstl_cli.physics.trajectories import tension_path, times

Array = NDArray[np.float64]
MENU = (
    Trajectory(kind="trapezoid", label="fast trapezoid", duration_s=8.0, drive="tension"),
    Trajectory(kind="trapezoid", label="slow trapezoid", duration_s=80.0, drive="tension"),
    Trajectory(kind="ramp_hold", label="ramps with holds", duration_s=60.0, hold_s=4.0),
    Trajectory(kind="minor_loops", label="minor loops", duration_s=40.0),
    Trajectory(kind="chirp", label="chirp", duration_s=60.0),
    Trajectory(kind="random", label="random", duration_s=120.0),
)
# a plan is judged at no more than this: what is faster tells no more of a line, and lasts longer
FASTEST_HZ = 500.0


@dataclass(frozen=True)
class Experiment:
    """The movement that separates two candidates best, and the D^2 that it would bring; ``d2_here`` is that of this data."""

    separates: tuple[str, str]
    trajectory: Trajectory
    d2: float
    d2_here: float

    @property
    def settles(self) -> bool:
        """Whether the movement would tell the two apart."""
        return self.d2 >= DECIDABLE


def isolability(found: Search, most: int = 12) -> tuple[list[str], Array]:
    """Return candidate ids and the cosine between their whitened responses, base parameters projected out."""
    singles = [w.fit for w in found.ranked() if len(w.ids) == 1][:most]
    sim, responses = found.sim, []
    for f in singles:
        jw = found.base.whiten(f.jacobian)
        own = jw[:, 0]
        power = np.maximum(np.bincount(sim.config, own**2), 1e-12)
        columns = []
        for i, x in enumerate(f.free):
            if not x.parameter.shape:
                column = jw[:, 1 + i]
                columns.append(column - own * (np.bincount(sim.config, own * column, len(power)) / power)[sim.config])
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


def best_experiment(found: Search, first: Weighed, second: Weighed) -> Experiment | None:
    """Return the movement of the menu on which two fitted models differ most after refitting the second, if any can."""
    best: Experiment | None = None
    here = distance2(found.sim, first.fit, second.fit)
    for trajectory in MENU:
        sim = planned(found, trajectory)
        if sim is None:
            continue
        d2 = distance2(sim, _moved(sim, found, first.fit), _moved(sim, found, second.fit))
        if best is None or d2 > best.d2:
            best = Experiment((" + ".join(first.ids), " + ".join(second.ids)), trajectory, d2, here)
    return best


def planned(found: Search, trajectory: Trajectory) -> Simulator | None:
    """Return the simulator of a movement that is not recorded yet, on the middle bend, with this rig's noise."""
    sim = found.sim
    dt = max(min(r.raw.dt_s for r in sim.problem.records), 1.0 / FASTEST_HZ)
    time = times(trajectory, 1.0 / dt)
    location = sim.problem.records[0].location
    runs = []
    for system in sim.problem.systems:
        path = tension_path(trajectory, system, time, np.random.default_rng(0))
        noise = found.noise.input[system].white_n * stream(0, "plan", system).standard_normal(len(time))
        out = 0.5 * path + noise[::-1]
        runs.append(Run(f"plan-{system}", system, time, path + noise, out, config_id="plan", location=location, trajectory=trajectory.name))
    try:
        return Simulator(prepare(runs, sim.problem.unit_n), sim.mechanics, sim.fixed)
    except SstlError:
        # a movement that cannot be diagnosed settles nothing
        return None


def _moved(sim: Simulator, found: Search, f: Fit) -> Fit:
    """Return a fit with its parameters put on a planned movement."""
    theta = np.array([float(np.median(f.theta))])
    start = whitener(sim.problem.records, sim.phases(theta, f.effects, found.noise), found.noise)
    return fit(sim, start, f.hypothesis, theta, f.values, 0)


def scenario_of(found: Search, trajectory: Trajectory) -> Scenario:
    """Return a scenario that records the trajectory on the configurations of the log, for ``sstl simulate``."""
    p = found.sim.problem
    locations = {r.config: r.location for r in p.records}
    configurations = tuple(
        Configuration(id=name, location=locations.get(i), theta=float(np.round(found.base.theta[i], 4)))
        for i, name in enumerate(p.configs)
    )
    return Scenario(
        configurations=configurations,
        trajectories=(trajectory.model_copy(update={"systems": p.systems}),),
        sampling_hz=FASTEST_HZ,
    )
