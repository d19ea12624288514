"""Record a planned run on the rig."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from sstl_cli.core.errors import SstlError
from sstl_cli.core.runs import Run
from sstl_cli.physics.effect import Values
from sstl_cli.physics.rig import NoiseSpec, RigRun, RigSpec, simulate_rig
from sstl_cli.physics.scenario import Scenario

if TYPE_CHECKING:
    from sstl_cli.steps.simulate import Plan


def record(scenario: Scenario, p: Plan, effects: Mapping[str, Values], seed: int) -> Run:
    """Return the run as the rig's sensors show it (time in s, tensions in N, position in mm).

    Raises
    ------
    SstlError
        If the configuration gives propagation lines instead of theta, the rig refuses a value, or it did not converge.
    """
    from sstl_cli.steps.simulate import input_path, labels, neighbour_tension

    c = p.configuration
    if c.theta is None:
        raise SstlError(f"configuration {c.id} gives no theta, which the rig needs", fix="set theta", code="E718")
    time, command = input_path(scenario, p, seed)
    try:
        rig = scenario.rig
        spec = RigSpec(
            length_mm=rig.length_mm,
            ea_n=rig.ea_n,
            nodes=rig.nodes,
            bend_arc_fraction=rig.arc_fraction,
            bend_centres=dict(rig.bend_centres),
            load_k1_n_per_mm=rig.load_n_per_mm,
        )
        noise = NoiseSpec(scenario.noise.white_n, scenario.noise.coloured_n, scenario.noise.correlation_s)
        beside = neighbour_tension(scenario, p, seed)
        run = RigRun(p.system, c.theta, c.location, time, "tension", command, beside)
        result = simulate_rig(spec, run, {k: dict(v) for k, v in effects.items()}, noise, _seed(seed, p.run_id))
    except ValueError as error:
        # the rig shares no code with the rest and so raises no error of ours
        raise SstlError(str(error), where=f"run {p.run_id}", fix="change the scenario or the effect", code="E720") from error
    if result.unconverged > max(1, len(time) // 100_000):
        raise SstlError(
            f"{result.unconverged} of {len(time)} steps did not converge", where=f"run {p.run_id}", code="E719"
        )
    return Run(
        time_s=result.time_s,
        tension_in_n=result.tension_in_n,
        tension_out_n=result.tension_out_n,
        position_in_mm=result.position_in_mm if p.trajectory.record_position else None,
        tension_ref_n=command if p.trajectory.record_reference else None,
        **labels(p),  # type: ignore[arg-type]
    )


def _seed(seed: int, run_id: str) -> int:
    from sstl_cli.core.rng import stream

    return int(stream(seed, "rig", run_id).integers(2**63))
