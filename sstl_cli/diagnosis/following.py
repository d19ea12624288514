"""What to record next: which candidates the data cannot tell apart, and the movement that would.

After Hunter and Reiner (1965): the best experiment is the one on which two rival models, each refitted, differ most; here
in squared standard deviations of this rig's noise (D^2), at the highest rate that was recorded.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from sstl_cli.core.errors import SstlError
from sstl_cli.core.observer import ideal
from sstl_cli.core.rng import stream
from sstl_cli.core.runs import Run
from sstl_cli.diagnosis.constants import (
    ANGLE_DIGITS,
    DECIDABLE,
    FASTEST_HZ,
    ISOLATED,
    LONGEST_S,
    MENU,
    RATE_DIGITS,
    REPEATABLE,
    SLOWER,
    SLOWINGS,
    TENSION_DIGITS,
)
from sstl_cli.diagnosis.evidence import Weighed
from sstl_cli.diagnosis.features import Rows
from sstl_cli.diagnosis.fit import Fit, fit
from sstl_cli.diagnosis.found import Search
from sstl_cli.diagnosis.limit import distance2
from sstl_cli.diagnosis.noise import of_readings
from sstl_cli.diagnosis.reasons import without_name
from sstl_cli.diagnosis.records import Problem, prepare
from sstl_cli.diagnosis.simulator import Simulator
from sstl_cli.diagnosis.verdict import IDENTIFIED, NOTHING, Verdict
from sstl_cli.diagnosis.whitening import Noise, whitener
from sstl_cli.physics.scenario import Configuration, RigSection, Scenario, Trajectory
from sstl_cli.physics.trajectories import SPAN_HZ, span_hz, tension_path, times

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Limits:
    """What the rig may be asked for: input tension (N) and its rate of change (N/s); None: what was recorded."""

    tension_n: float | None = None
    rate_n_per_s: float | None = None


@dataclass(frozen=True)
class Movement:
    """A movement of the menu within the limits of one system: instants (s) and input tension (N), shape (n,)."""

    system: str
    trajectory: Trajectory
    time_s: Array
    tension_n: Array


@dataclass(frozen=True)
class Experiment:
    """The movement that separates two candidates best, and the D^2 that it would bring; ``d2_here`` is that of this data."""

    separates: tuple[str, str]
    movements: tuple[Movement, ...]
    d2: float
    d2_here: float

    @property
    def trajectory(self) -> Trajectory:
        """The movement of the menu."""
        return self.movements[0].trajectory

    @property
    def settles(self) -> bool:
        """Whether the movement would tell the two apart."""
        return self.d2 >= DECIDABLE

    @property
    def chance(self) -> float:
        """In which share of recordings of the movement the noise lets 49 to 1 for the true one of the two come out, were laws exact."""
        return ideal(self.d2)


def rivals(models: Iterable[Weighed], verdict: Verdict) -> list[Weighed]:
    """Return the models of one effect that foretell a recording: those of the ambiguity group first, among them the most probable."""
    p, group = verdict.probabilities, verdict.group
    return sorted(
        (w for w in models if len(w.ids) == 1 and w.fit.hypothesis.foretold), key=lambda w: (w.ids not in group, -p.get(w.ids, 0.0))
    )


def proposed(found: Search, rows: Rows, said: Verdict, limits: Limits | None, passed: Callable[[str], bool]) -> Experiment | None:
    """Return the movement that separates the two leading rivals, if any of the menu can.

    Where the two are told apart here, were laws exact, a movement that shows less of the difference would add nothing.

    Parameters
    ----------
    passed : callable
        Whether a stage that can be left out has to be (see core.deadline).
    """
    ranked = rivals(found.ranked(), said)
    # whoever is behind what has no name need not be told from one another, and where nothing propagates only a larger stroke helps
    settled = said.status in (NOTHING, IDENTIFIED) or without_name(found, rows) is not None or rows.log.propagates < 1.0
    if settled or len(ranked) < 2 or passed("next experiment"):
        return None
    first, second = ranked[:2]
    experiment = best_experiment(found, first, second, limits)
    return None if experiment is None or max(experiment.d2, DECIDABLE) <= experiment.d2_here else experiment


def isolability(found: Search, most: int = ISOLATED) -> tuple[list[str], Array]:
    """Return candidate ids and the cosine between their whitened responses, base parameters projected out."""
    singles = [w.fit for w in found.ranked() if len(w.ids) == 1][:most]
    responses = [span(strengths(found, f)) for f in singles]
    n = len(singles)
    cosine = np.eye(n)
    for i in range(n):
        for j in range(i):
            if responses[i].shape[1] and responses[j].shape[1]:
                overlap = np.linalg.svd(responses[i].T @ responses[j], compute_uv=False)
                cosine[i, j] = cosine[j, i] = float(min(overlap[0], 1.0))
    return [f.ids[0] for f in singles], cosine


def strengths(found: Search, f: Fit) -> Array:
    """Return the whitened responses to the strengths of a model, base parameters projected out, shape (samples, strengths)."""
    config, jw = found.sim.config, found.base.whiten(f.jacobian)
    own = jw[:, 0]
    power = np.maximum(np.bincount(config, own**2), 1e-12)
    columns = [jw[:, 1 + i] for i, x in enumerate(f.free) if not x.parameter.shape]
    left = [c - own * (np.bincount(config, own * c, len(power)) / power)[config] for c in columns]
    return np.stack(left, axis=1) if left else np.zeros((len(own), 0))


def span(columns: Array) -> Array:
    """Return an orthonormal basis of what columns span, without those that add nothing."""
    q, r = np.linalg.qr(columns)
    return np.asarray(q[:, np.abs(np.diag(r)) > 1e-9])


def best_experiment(found: Search, first: Weighed, second: Weighed, limits: Limits | None = None) -> Experiment | None:
    """Return the movement of the menu on which two fitted models differ most after refitting the second, if any can."""
    best: Experiment | None = None
    here = distance2(found.sim, first.fit, second.fit)
    for trajectory in MENU:
        movements = within(found, trajectory, limits or Limits())
        sim = planned(found, movements)
        if sim is None:
            continue
        d2 = distance2(sim, _moved(sim, found, first.fit), _moved(sim, found, second.fit))
        if best is None or d2 > best.d2:
            best = Experiment((" + ".join(first.ids), " + ".join(second.ids)), movements, d2, here)
    return best


def within(found: Search, trajectory: Trajectory, limits: Limits) -> tuple[Movement, ...]:
    """Return a movement of the menu for every recorded system, between its tensions and no faster than its limits.

    What is too fast is slowed down; the sampling is the fastest that was recorded. Movements that would last too long are left out.
    """
    problem, dt = found.sim.problem, sampling_s(found)
    movements = []
    for system in problem.systems:
        mine = [r for r in problem.records if r.system == system]
        slack = 0.0 - found.sim.mechanics.preload(system)
        low, most = recorded_n(problem, system, -slack)
        high = most if limits.tension_n is None else limits.tension_n / problem.unit_n
        fastest = max(float(np.quantile(np.abs(r.rate), REPEATABLE)) for r in mine)
        if limits.rate_n_per_s is not None:
            fastest = limits.rate_n_per_s / problem.unit_n
        if high <= low or fastest <= 0.0:
            continue
        # rounded it may be one at which the tendon is slack
        low = max(round(low, TENSION_DIGITS), slack)
        own = trajectory.model_copy(update={"low_n": low, "high_n": round(high, TENSION_DIGITS), "systems": (system,)})
        slow = _slowed(own, system, dt, fastest)
        if slow is not None:
            movements.append(slow)
    return tuple(movements)


def recorded_n(problem: Problem, system: str, preload_n: float = 0.0) -> tuple[float, float]:
    """Return lowest (none at which a tendon stretched by the preload would be slack) and highest input tension (N) that was recorded of a system."""
    mine = [r.u for r in problem.records if r.system == system]
    return max(min(float(u.min()) for u in mine), 0.0 - preload_n), max(float(u.max()) for u in mine)


def sampling_s(found: Search) -> float:
    """Return the sampling period (s) of a plan: the shortest that was recorded, as far as it tells more of a line."""
    return max(min(r.raw.dt_s for r in found.sim.problem.records), 1.0 / FASTEST_HZ)


def _slowed(trajectory: Trajectory, system: str, dt_s: float, fastest: float) -> Movement | None:
    """Return a movement whose tension changes by no more than ``fastest`` (N/s), None where that would take too long."""
    for _ in range(SLOWINGS):
        time = times(trajectory, 1.0 / dt_s)
        # the same draw as in the plan that is judged: what is written is what was judged
        path = np.asarray(tension_path(trajectory, system, time, np.random.default_rng(0)))
        share = fastest / max(float(np.abs(np.diff(path)).max()) / dt_s, 1e-12)
        if share >= 1.0:
            return Movement(system, trajectory, time, path)
        share *= SLOWER
        if trajectory.kind in SPAN_HZ:
            low, top = span_hz(trajectory)
            # a chirp keeps its slow beginning as far as it can
            slower = {
                "frequency_hz": min(low, 0.5 * top * share) if trajectory.kind == "chirp" else low * share,
                "top_frequency_hz": top * share,
            }
            trajectory = trajectory.model_copy(update=slower)
        else:
            trajectory = trajectory.model_copy(update={"speed": trajectory.speed * share})
        if (trajectory.duration_s or 0.0) / trajectory.speed > LONGEST_S:
            return None
    return None


def planned(found: Search, movements: Sequence[Movement]) -> Simulator | None:
    """Return the simulator of movements that are not recorded yet, on the middle bend, with this rig's noise."""
    sim, runs = found.sim, []
    for m in movements:
        noise = found.noise.input[m.system].white_n * stream(0, "plan", m.system).standard_normal(len(m.time_s))
        out, place = 0.5 * m.tension_n + noise[::-1], sim.problem.records[0].location
        runs.append(
            Run(
                f"plan-{m.system}",
                m.system,
                m.time_s,
                m.tension_n + noise,
                out,
                config_id="plan",
                location=place,
                trajectory=m.trajectory.name,
            )
        )
    try:
        return Simulator(prepare(runs, sim.problem.unit_n), sim.mechanics, sim.fixed, zeros_n=sim.zeros_n)
    except SstlError:
        # a movement that cannot be diagnosed settles nothing
        return None


def _moved(sim: Simulator, found: Search, f: Fit) -> Fit:
    """Return a fit with its parameters put on a planned movement."""
    theta, noise = np.array([float(np.median(f.theta))]), _of_steps(sim, found)
    start = whitener(sim.constants({}, noise), sim.phases(theta, f.effects, noise))
    return fit(sim, start, f.hypothesis, theta, f.values, 0)


def _of_steps(sim: Simulator, found: Search) -> Noise:
    """Return the noise of this rig where a step of the simulation holds as many readings as on a plan, which need not be as many as here."""
    noise, thin = of_readings(found.sim.problem.records, found.noise), float(np.sqrt(sim.problem.records[0].thin))
    return replace(noise, output={k: replace(s, white_n=s.white_n / thin) for k, s in noise.output.items()})


def scenario_of(found: Search, experiment: Experiment) -> Scenario:
    """Return a scenario that records the movements on the configurations of the log, for ``sstl simulate``."""
    p = found.sim.problem
    locations = {r.config: r.location for r in p.records}
    configurations = tuple(
        Configuration(id=name, location=locations.get(i), theta=float(np.round(found.base.theta[i], ANGLE_DIGITS)))
        for i, name in enumerate(p.configs)
    )
    return Scenario(
        rig=RigSection(preload_n=dict(found.sim.mechanics.preload_n) or None),
        configurations=configurations,
        trajectories=tuple(m.trajectory for m in experiment.movements),
        sampling_hz=round(1.0 / sampling_s(found), RATE_DIGITS),
    )


def table(scenario: Scenario, factor: float = 1.0) -> str:
    """Return the movements of a proposed scenario as CSV, one row a sample: ``system,time_s,tension_in_n``.

    ``factor`` is one N of the scenario in the unit of the recording.
    """
    rows = ["system,time_s,tension_in_n"]
    for trajectory in scenario.trajectories:
        time = times(trajectory, scenario.sampling_hz)
        for system in trajectory.systems:
            path = tension_path(trajectory, system, time, np.random.default_rng(0))
            rows += [f"{system},{t:.6g},{v * factor:.6g}" for t, v in zip(time, path, strict=True)]
    return "\n".join(rows) + "\n"
