"""Simulate the recordings of a scenario with the fast model or one that stands in for hardware, run by run."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from sstl_cli.core.config import parse as parse_model
from sstl_cli.core.errors import SstlError
from sstl_cli.core.rng import stream
from sstl_cli.core.runs import Run
from sstl_cli.core.sound import LARGEST, unsound
from sstl_cli.physics.effect import Values
from sstl_cli.physics.effects import get, parse
from sstl_cli.physics.noise import NoiseModel, sensor_noise
from sstl_cli.physics.plan import Plan, input_path, labels, neighbour_tension, plan
from sstl_cli.physics.scenario import Lines, OutputScale, Scenario, Trajectory
from sstl_cli.physics.transmission import activate, measure, play_operator, predict, predict_position
from sstl_cli.physics.transmission.model import Active, drive_of


def adjusted(scenario: Scenario, simulator: str | None = None, noise_n: float | None = None) -> Scenario:
    """Return the scenario with another simulator or another white noise of the sensors (N), checked.

    Raises
    ------
    SstlError
        E143 if a value does not fit.
    """
    document = scenario.model_dump(by_alias=True)
    if simulator is not None:
        document["simulator"] = simulator
    if noise_n is not None:
        document["noise"]["white_n"] = noise_n
    return parse_model(Scenario, document, "scenario")


def effects_of(given: Mapping[str, Mapping[str, float]] | Iterable[str]) -> dict[str, Values]:
    """Return effects by id, from ``ID[:param=value,...]`` as typed or from a mapping; missing values are neutral.

    Raises
    ------
    SstlError
        For an unknown effect or parameter, or a value outside its range.
    """
    if isinstance(given, Mapping):
        return {get(name).id: get(name).complete(dict(values)) for name, values in given.items()}
    return dict(parse(text) for text in given)


def run(scenario: Scenario, effects: Mapping[str, Values], seed: int) -> Iterator[Run]:
    """Yield the simulated runs of a scenario (time in s, tensions in N, position in mm; the output in the unit of the scenario's ``output``).

    Raises
    ------
    SstlError
        If an effect needs a channel or a theta that the scenario does not record or give.
    """
    plans = plan(scenario, seed)
    own = output_scale(scenario, {p.system for p in plans})
    for made in _recorded(scenario, plans, {**scenario.effects, **effects}, seed, own):
        yield made if own is None else _in_unit(made, own)


def output_scale(scenario: Scenario, systems: Iterable[str]) -> OutputScale | None:
    """Return the scale of the outputs of these systems, None where they are in newtons: a log has one unit, so each needs its own factor."""
    own = scenario.output
    return own if own is not None and set(systems) <= set(own.per_n) else None


def _in_unit(made: Run, own: OutputScale) -> Run:
    """Return a run with its output as a recording has it of which the scenario is a model."""
    out = own.origin.get(made.system, 0.0) + own.per_n[made.system] * made.tension_out_n
    return replace(made, tension_out_n=out, unit_out=own.unit)


def _recorded(
    scenario: Scenario, plans: Sequence[Plan], effects: Mapping[str, Values], seed: int, own: OutputScale | None
) -> Iterator[Run]:
    """Yield the runs that are planned, in N, or say which effect they cannot show."""
    active = activate(effects)
    for effect, _ in active.items:
        if effect.channel == "neighbour" and len(scenario.tendons) < 2:
            raise SstlError(
                f"effect {effect.id} needs a neighbour, but the scenario has {len(scenario.tendons) or 'one'} tendon(s)",
                fix="add two [[tendons]] blocks that do not move alike (delay_s, level)",
                code="E721",
            )
        for p in plans:
            missing = [n for n in effect.needs if not _records(p.trajectory, n)]
            if missing:
                raise SstlError(
                    f"effect {effect.id} shows only in {missing[0]}, which trajectory '{p.trajectory.name}' does not record",
                    fix="set record_position or record_reference in the scenario",
                    code="E716",
                )
            if p.configuration.theta is None:
                raise SstlError(
                    f"effects need theta, but configuration {p.configuration.id} gives propagation lines",
                    fix="give theta in the scenario",
                    code="E717",
                )
    if scenario.simulator != "transmission":
        # a tenth of a second for those that take the fast model, which are most
        from sstl_cli.steps.simulate_rig import record

        for p in plans:
            yield record(scenario, p, effects, seed)
        return
    for p in plans:
        yield _record(scenario, p, active, seed, 0.0 if own is None else -own.origin.get(p.system, 0.0) / own.per_n[p.system])


def _records(trajectory: Trajectory, channel: str) -> bool:
    return trajectory.record_position if channel == "position_in_mm" else trajectory.record_reference


def _require_possible(run_id: str, tension: np.ndarray, out: np.ndarray) -> None:
    for name, values in (("input", tension), ("output", out)):
        lost = int(np.count_nonzero(unsound(values)))
        if lost:
            raise SstlError(
                f"the {name} is no number up to {LARGEST:.0e} at {lost} of {len(values)} samples",
                where=f"run {run_id}",
                fix="correct what the scenario says of its movement or lines",
                code="E723",
            )


def _record(scenario: Scenario, p: Plan, active: Active, seed: int, zero_n: float) -> Run:
    time, command = input_path(scenario, p, seed)
    dt = 1.0 / scenario.sampling_hz
    tension = command
    for effect, values in active.of_hook("loop"):
        tension = effect.loop(command, dt, values)  # type: ignore[misc]
    drive = drive_of(p.system, p.configuration.location, dt, tension, scenario.rig.mechanics())
    drive = replace(drive, neighbour_n=neighbour_tension(scenario, p, seed))
    given: Lines | None = getattr(p.configuration, p.system)
    theta = float(p.configuration.theta or 0.0)
    if given is not None:
        out = play_operator(tension, given.gamma_p, given.beta_p, given.gamma_r, given.beta_r, np.nan)
    else:
        out = predict(drive, theta, active)
    _require_possible(p.run_id, tension, out)
    position = predict_position(drive, theta, active, out)
    noise = NoiseModel(scenario.noise.white_n, scenario.noise.coloured_n, scenario.noise.correlation_s)
    rng = stream(seed, "noise", p.run_id)
    noisy_in = tension + sensor_noise(noise, len(time), dt, rng)
    noisy_out = out + sensor_noise(noise, len(time), dt, rng)
    # noise is added before the recorder rounds, clips or drops samples
    seen_in, seen_out = measure(p.system, dt, noisy_in, noisy_out, active, stream(seed, "faults", p.run_id), theta, zero_n)
    return Run(
        time_s=time,
        tension_in_n=seen_in,
        tension_out_n=seen_out,
        position_in_mm=position if p.trajectory.record_position else None,
        tension_ref_n=command if p.trajectory.record_reference else None,
        **labels(p),
    )
