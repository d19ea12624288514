"""What a scenario asks to be recorded: its runs in order, their movements and labels; the same for every simulator."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TypedDict

import numpy as np

from sstl_cli.core.errors import SstlError
from sstl_cli.core.rng import stream
from sstl_cli.physics.generator import generate
from sstl_cli.physics.scenario import Configuration, Lines, Scenario, Tendon, Trajectory
from sstl_cli.physics.trajectories import probe, tension_path, times


@dataclass(frozen=True)
class Plan:
    """One run to be recorded."""

    run_id: str
    configuration: Configuration
    trajectory: Trajectory
    system: str
    tendon: Tendon | None = None


def plan(scenario: Scenario, seed: int) -> list[Plan]:
    """Return the runs of a scenario in the order in which they are recorded."""
    configurations = list(scenario.configurations)
    if scenario.generator:
        configurations += generate(scenario.generator, stream(seed, "configurations"))
    if not configurations:
        raise SstlError("scenario has no configuration", fix="add a [[configurations]] block", code="E713")
    if not scenario.trajectories:
        raise SstlError("scenario has no trajectory", fix="add a [[trajectories]] block", code="E714")
    plans = [
        Plan(f"{c.id}-{i}-{t.kind}-{system}" + (f"-{tendon.id}" if tendon else ""), _wrapped(c, tendon), t, system, tendon)
        for c in configurations
        for i, t in enumerate(scenario.trajectories)
        for system in t.systems
        if c.theta is not None or getattr(c, system) is not None
        for tendon in _tendons(scenario, system)
    ]
    if not plans:
        raise SstlError("no configuration describes a recorded system", fix="give theta, act or sstl", code="E715")
    return plans


def _tendons(scenario: Scenario, system: str) -> tuple[Tendon | None, ...]:
    """Return the tendons that are recorded: all actuation tendons one by one, the sensing loop once."""
    return scenario.tendons if scenario.tendons and system == "act" else (None,)


def _wrapped(c: Configuration, tendon: Tendon | None) -> Configuration:
    if tendon is None or c.theta is None:
        return c
    return c.model_copy(update={"theta": c.theta * tendon.theta_factor})


def input_path(scenario: Scenario, p: Plan, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the sampling times (s) and the input tension (N) of a planned run."""
    time = times(p.trajectory, scenario.sampling_hz)
    mechanics = scenario.rig.mechanics()
    if (p.trajectory.drive or "position") == "position" and p.trajectory.kind == "trapezoid":
        args = (mechanics.tendon_mm_per_n, mechanics.end_mm_per_n(p.system))
        path = probe(p.trajectory, p.system, time, _lines(p.configuration, p.system), *args)
        return time, _moved(time, path, p.tendon)
    # the same movement for every configuration, as a lab would command it
    path = tension_path(p.trajectory, p.system, time, stream(seed, "path", p.trajectory.name, p.system))
    return time, _moved(time, path, p.tendon)


def _moved(time: np.ndarray, path: np.ndarray, tendon: Tendon | None) -> np.ndarray:
    if tendon is None:
        return path
    return np.asarray(tendon.level * np.interp(time - tendon.delay_s, time, path))


def neighbour_tension(scenario: Scenario, p: Plan, seed: int) -> np.ndarray | None:
    """Return the summed input tension (N, shape (n,)) of the other tendons while a planned run is recorded."""
    if p.tendon is None:
        return None
    total = None
    for other in scenario.tendons:
        if other.id == p.tendon.id:
            continue
        theta = None if p.configuration.theta is None else p.configuration.theta / p.tendon.theta_factor
        straight = p.configuration.model_copy(update={"theta": theta})
        path = input_path(scenario, replace(p, configuration=_wrapped(straight, other), tendon=other), seed)[1]
        total = path if total is None else total + path
    return total


class Labels(TypedDict):
    """What a run is called in the log."""

    run_id: str
    config_id: str | None
    system: str
    location: str | None
    lead_mm: float | None
    trajectory: str | None
    tendon: str | None


def labels(p: Plan) -> Labels:
    """Return the labels that a planned run carries in the log."""
    c, tendon = p.configuration, None if p.tendon is None else p.tendon.id
    return Labels(
        run_id=p.run_id,
        config_id=c.id,
        system=p.system,
        location=c.location,
        lead_mm=c.lead_mm,
        trajectory=p.trajectory.name,
        tendon=tendon,
    )


def _lines(c: Configuration, system: str) -> Lines:
    given: Lines | None = getattr(c, system)
    if given is not None:
        return given
    n = 2 if system == "sstl" else 1
    theta = c.theta if c.theta is not None else 0.0
    return Lines(gamma_p=float(np.exp(-n * theta)), beta_p=0.0, gamma_r=float(np.exp(n * theta)), beta_r=0.0)
