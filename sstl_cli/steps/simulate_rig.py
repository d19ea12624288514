"""Record a planned run on a simulator that stands in for hardware: the rig, bristle friction or the law variants."""

from __future__ import annotations

from collections.abc import Callable, Container, Mapping

from sstl_cli.core.errors import SstlError
from sstl_cli.core.rng import stream
from sstl_cli.core.runs import Run
from sstl_cli.physics import bristle, rig, variant
from sstl_cli.physics.bristle import BristleRun, BristleSpec, simulate_bristle
from sstl_cli.physics.effect import Values
from sstl_cli.physics.effects import get
from sstl_cli.physics.given import Built, Recorded
from sstl_cli.physics.plan import Plan, input_path, labels, neighbour_tension
from sstl_cli.physics.rig import NoiseSpec, RigRun, RigSpec, simulate_rig
from sstl_cli.physics.scenario import Scenario
from sstl_cli.physics.variant import VariantRun, VariantSpec, simulate_variant

# the parameters of the effects that a simulator has code for
KNOWN: Mapping[str, Callable[[], Mapping[str, Container[str]]]] = {
    "rig": rig.parameters,
    "bristle": bristle.parameters,
    "variant": variant.parameters,
}


def record(scenario: Scenario, p: Plan, effects: Mapping[str, Values], seed: int) -> Run:
    """Return the run as the simulator's sensors show it (time in s, tensions in N, position in mm).

    Raises
    ------
    SstlError
        If the configuration gives propagation lines instead of theta, the simulator refuses a value, or it did not converge.
    """
    c = p.configuration
    if c.theta is None:
        raise SstlError(f"configuration {c.id} gives no theta, which the {scenario.simulator} needs", fix="set theta", code="E718")
    time, command = input_path(scenario, p, seed)
    beside = neighbour_tension(scenario, p, seed)
    built, heard = _built(scenario, p.system), NoiseSpec(**scenario.noise.model_dump())
    given = (p.system, c.theta * scenario.rig.mechanics().friction(p.system), c.location, time, "tension", command, beside)
    values = {effect_id: stated(effect_id, v, KNOWN[scenario.simulator]()) for effect_id, v in effects.items()}
    own = _seed(seed, scenario.simulator, p.run_id)
    result: Recorded
    try:
        if scenario.simulator == "bristle":
            result = simulate_bristle(BristleSpec(**built), BristleRun(*given), values, heard, own)
        elif scenario.simulator == "variant":
            spec = VariantSpec(**built, laws=scenario.laws, law_seed=_seed(seed, "laws", "") % 2**32)
            result = simulate_variant(spec, VariantRun(*given), values, heard, own)
        else:
            result = simulate_rig(RigSpec(**built), RigRun(*given), values, heard, own)
    except ValueError as error:
        # a simulator that stands in for hardware shares no code with the rest and so raises no error of ours
        raise SstlError(str(error), where=f"run {p.run_id}", fix="change the scenario or the effect", code="E720") from error
    if result.unconverged > max(1, len(time) // 100_000):
        raise SstlError(f"{result.unconverged} of {len(time)} steps did not converge", where=f"run {p.run_id}", code="E719")
    return Run(
        time_s=result.time_s,
        tension_in_n=result.tension_in_n,
        tension_out_n=result.tension_out_n,
        position_in_mm=result.position_in_mm if p.trajectory.record_position else None,
        tension_ref_n=command if p.trajectory.record_reference else None,
        **labels(p),
    )


def stated(effect_id: str, values: Values, known: Mapping[str, Container[str]]) -> dict[str, float]:
    """Return the values that a simulator is told: a parameter that it has no code for is no question where it does nothing."""
    effect = get(effect_id)
    idle = {p.name: p.neutral for p in effect.parameters if p.name not in known.get(effect_id, ())}
    # the shape of a law of which no strength is set
    active = any(values[n] != neutral for n, neutral in idle.items() if not effect.parameter(n).shape and n in values)
    return {n: x for n, x in values.items() if n not in idle or (active and x != idle[n])}


def _built(scenario: Scenario, system: str) -> Built:
    """Return geometry and mechanics under the names that all these simulators give them, with the load of a system."""
    rig = scenario.rig
    return Built(
        length_mm=rig.length_mm,
        ea_n=rig.ea_n,
        nodes=rig.nodes,
        bend_arc_fraction=rig.arc_fraction,
        bend_centres=dict(rig.bend_centres),
        load_k1_n_per_mm=rig.mechanics().end_n_per_mm(system),
    )


def _seed(seed: int, simulator: str, run_id: str) -> int:
    return int(stream(seed, simulator, run_id).integers(2**63))
