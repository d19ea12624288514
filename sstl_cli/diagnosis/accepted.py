"""What is kept of a diagnosis: the accepted simulator, and what it is known to leave."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from sstl_cli import __version__
from sstl_cli.diagnosis import by_run, discrepancy, misfit, nameless, scaling, variation, verdict
from sstl_cli.diagnosis.fit import Fit
from sstl_cli.diagnosis.found import Search
from sstl_cli.diagnosis.free import LINE, LOOP
from sstl_cli.diagnosis.gathering import Evidence
from sstl_cli.diagnosis.latent import WHITE_ONLY
from sstl_cli.diagnosis.movements import with_movements
from sstl_cli.diagnosis.noise import of_readings, white_only
from sstl_cli.diagnosis.reasons import without_name
from sstl_cli.diagnosis.records import told
from sstl_cli.diagnosis.residuals import leftover
from sstl_cli.diagnosis.simulator import Simulator
from sstl_cli.physics.effects import get
from sstl_cli.physics.scenario import Configuration, OutputScale, Scenario


def accepted(found: Evidence, said: verdict.Verdict) -> Fit:
    """Return the fit of the named effects, or the re-tuned base where none of the output is named."""
    # what a fault of the recorder has spoilt is left out of every fit
    named = tuple(sorted(set(said.effects) - {r.id for r in found.recorder}))
    if named and _fitted(found.search, named):
        return found.search.best(named).fit
    return found.search.base


def kept(found: Evidence, said: verdict.Verdict) -> Fit:
    """Return the fit that a model is made of: friction of its own for the sensing loop is a constant of a rig, though no effect."""
    own = without_name(found.search, found.rows) if said.status == verdict.UNDECIDED else None
    return accepted(found, said) if own is None or own.fit.hypothesis != nameless.HYPOTHESIS else own.fit


def _fitted(found: Search, named: tuple[str, ...]) -> bool:
    return named in found.combined if len(named) > 1 else named[0] in found.singles


def _ending(base: Scenario, sim: Simulator, values: Mapping[str, float], unit_n: float) -> Scenario:
    """Return a scenario with the stiffness of what the lines of a fit end at; the loop's own where it has one."""
    ends = {system: 1.0 / scaling.parameter(sim.end_mm_per_n(system, values), "mm/N", unit_n) for system in ("act", "sstl")}
    own = base.rig.loop_load_n_per_mm is not None or "loop_load_mm_per_n" in values
    return base.with_rig(load_n_per_mm=ends["act"], loop_load_n_per_mm=ends["sstl"] if own else None)


def model(found: Evidence, said: verdict.Verdict, base: Scenario) -> Scenario:
    """Return a scenario that predicts the record as the accepted fit does, in the units of the recording."""
    chosen = by_run.lasting(found.search, kept(found, said))
    unit_n = found.problem.unit_n
    effects = {**base.effects}
    for effect_id, values in chosen.effects.items():
        if effect_id == LINE.id:
            base = _ending(base, found.search.sim, values, unit_n)
            continue
        if effect_id == LOOP.id:
            base = base.with_rig(loop_friction=found.search.sim.loop_friction(chosen.effects))
            continue
        effects[effect_id] = scaling.in_recording(effect_id, found.search.sim.changed(effect_id, values), unit_n)
    for fault in found.recorder:
        if fault.id in said.effects:
            effects[fault.id] = get(fault.id).complete(
                scaling.in_recording(fault.id, {k: v for k, v in fault.parameters.items() if v}, unit_n)
            )
    for gap in found.beside:
        if (gap.effect,) == said.effects:
            effects[gap.effect] = scaling.in_recording(gap.effect, gap.values, unit_n)
    base = base.with_rig(preload_n=found.preload_n or None)
    locations = {r.config: r.location for r in found.problem.records}
    configurations = tuple(
        Configuration(id=name, location=locations.get(i), theta=float(chosen.theta[i])) for i, name in enumerate(found.problem.configs)
    )
    # of holds and second differences only: what the model leaves is no noise of a sensor
    noise = of_readings(found.problem.records, found.search.measured).output.values()
    heard = {
        "white_n": unit_n * float(np.median([s.white_n for s in noise])),
        "coloured_n": unit_n * float(np.median([s.coloured_n for s in noise])),
        "correlation_s": float(np.median([s.correlation_s for s in noise])),
    }
    told = base.model_copy(
        update={
            "configurations": configurations,
            "effects": effects,
            "generator": None,
            "misfits": (),
            "dispersion": {},
            "faults": {},
            "wander": None,
            "package_version": __version__,
            "output": None
            if found.scale is None
            else OutputScale(unit=found.scale.unit, per_n=found.scale.per_n, origin=found.scale.origin),
            "noise": base.noise.model_copy(update=heard),
        }
    )
    return with_movements(told, found.problem)


def known(found: Evidence, said: verdict.Verdict, base: Scenario) -> Scenario:
    """Return the accepted simulator with what it leaves of the record, in N: what was known already, and what is new."""
    sim, chosen = _unheard(found.search.sim, by_run.lasting(found.search, kept(found, said)))
    problem, noise = sim.problem, white_only(found.search.measured)
    phases = sim.phases(chosen.theta, chosen.effects, noise)
    sections = discrepancy.learned(problem, chosen.residual + misfit.known(problem), phases, noise)
    bare = model(found, said, base)
    if not sections:
        return bare
    usual = {t.name: float(t.dispersion) for t in leftover(*misfit.beyond(sim, chosen, sections, noise, told=False)).tests}
    own = variation.ways(found.search.singles.values())
    varies = variation.learned(*misfit.beyond(sim, chosen, sections, noise, told=True), own)
    return bare.model_copy(
        update={
            "misfits": tuple(misfit.rescaled(s, problem.unit_n) for s in sections),
            "dispersion": usual,
            "wander": variation.rescaled(varies, problem.unit_n),
        }
    )


def _unheard(sim: Simulator, chosen: Fit) -> tuple[Simulator, Fit]:
    """Return simulator and fit driven by inputs that were told of no slow noise: so they are where a model that knows is tried.

    What was found is the model's own from now on: friction at the end is in its line, and beside that it is learned what else is left.
    """
    plain = replace(sim, behind=False, problem=replace(sim.problem, records=tuple(replace(r, wander=None) for r in sim.problem.records)))
    if any(r.told_n != 0.0 for r in sim.problem.records):
        plain = replace(plain, problem=told(plain.problem, dict.fromkeys(sim.problem.systems, WHITE_ONLY)))
    prediction = plain.predict(chosen.theta, chosen.effects)
    return plain, replace(chosen, prediction=prediction, residual=plain.y - prediction)
