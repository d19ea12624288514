"""An accepted simulator on its own record once more: what exceeds chance there has to be exceeded later to mean a change."""

from __future__ import annotations

from dataclasses import replace

from sstl_cli.diagnosis import variation
from sstl_cli.diagnosis.constants import EXAMINED
from sstl_cli.diagnosis.gathering import Evidence, gather
from sstl_cli.diagnosis.question import Question
from sstl_cli.diagnosis.residuals import leftover
from sstl_cli.physics.effects import catalogue
from sstl_cli.physics.scenario import Scenario, Variation


def tried(found: Evidence, scenario: Scenario, asked: Question) -> Scenario:
    """Return an accepted simulator that knows what its own record shows beyond chance, where nothing has changed.

    What exceeds chance there has to be larger than that to mean a change: how much the rig seems to be another as a whole,
    tests of what is left (overdispersion, McCullagh and Nelder 1989, section 4.5), faults of the recorder.

    Parameters
    ----------
    found : Evidence
        Of the record that the simulator was accepted on.
    asked : Question
        What was asked of that record.
    """
    if scenario.wander is None:
        return scenario
    known = replace(asked, sim=scenario, max_effects=1)
    # the base alone
    once = gather(found.runs, replace(known, exclude=tuple(catalogue())), before=found).search
    kept, unit_n = scenario.wander, found.problem.unit_n

    def varying(whole: Variation) -> Scenario:
        own = variation.rescaled(kept.model_copy(update={"whole": whole}), unit_n)
        return scenario.model_copy(update={"wander": kept.model_copy(update={"whole": own.whole})})

    whole = variation.of_the_whole(once.sim, once.base, variation.ways(found.search.singles.values()))
    again = gather(found.runs, replace(known, sim=varying(whole)), before=found)
    scenario = varying(variation.seen_in(whole, (v[0] for v in again.search.singles.values())))
    usual = dict(scenario.dispersion)
    # models that add to it without being more evident are as right as it is
    tries = [(s, f) for s in (once, again.search) for f in [s.base, *(w.fit for w in s.ranked()[:EXAMINED])]]
    for s, f in tries:
        for t in leftover(s.sim, f).tests:
            usual[t.name] = max(usual.get(t.name, 1.0), float(t.dispersion))
    readings = sum(len(r.raw) for r in again.problem.records)
    carried = {e.id: scenario.faults.get(e.id, 0.0) + e.at_most_n2 * again.problem.unit_n**2 / readings for e in again.recorder}
    return scenario.model_copy(update={"dispersion": usual, "faults": {**scenario.faults, **carried}})
