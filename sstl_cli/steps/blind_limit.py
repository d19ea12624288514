"""What the recordings of a case could tell: distances from its truth to the base and to the nearest rival."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from sstl_cli.core.errors import SstlError
from sstl_cli.core.runs import Run
from sstl_cli.diagnosis.fit import Fit, fit, settle
from sstl_cli.diagnosis.limit import DECIDABLE, distance2
from sstl_cli.diagnosis.search import Search
from sstl_cli.physics.effects import catalogue, get
from sstl_cli.physics.scenario import Scenario

SCHEMA, CASE = "sstl.blind.limit/1", "sstl.blind.limit.case/1"
# rivals that are looked at besides look-alikes: those that fit the recordings best
RIVALS = 6


def run(case: str, runs: Sequence[Run], sim: Scenario, effects: tuple[str, ...]) -> dict[str, Any]:
    """Return the squared distances of one case, whatever was excluded from its candidates.

    The withheld effects are fitted to the recordings in the fast model; what this fit shows is then followed by the base
    and by each rival as well as they can. Distances are None where the fast model holds no such effect.
    """
    body: dict[str, Any] = {
        "schema": CASE, "case": case, "effects": list(effects), "d2_base": None, "d2_rival": None, "rival": None,
        "decidable": False, "why": None,
    }  # fmt: skip
    if not effects:
        return {**body, "why": "nothing was withheld"}
    known = catalogue()
    if not all(e in known and get(e).fitted and get(e).channel == "out" and e not in sim.effects for e in effects):
        return {**body, "why": "the fast model holds no such effect of the output"}
    try:
        return body | _distances(runs, sim, effects)
    except SstlError as error:
        return {**body, "why": error.what}


def _distances(runs: Sequence[Run], sim: Scenario, effects: tuple[str, ...]) -> dict[str, Any]:
    from sstl_cli.steps.diagnose import DiagnoseOptions, gather

    found = gather(runs, DiagnoseOptions(sim=sim, max_effects=1)).search
    if not all(e in found.singles for e in effects):
        return {"why": "these recordings cannot show the effect in the fast model"}
    truth = _truth(found, effects)
    base = distance2(found.sim, truth, found.base)
    distances = {r: distance2(found.sim, truth, found.singles[r][0].fit) for r in rivals(found, effects)}
    nearest = min(distances, key=lambda r: (distances[r], r), default=None)
    apart = [base, *distances.values()]
    return {
        "d2_base": base,
        "d2_rival": None if nearest is None else distances[nearest],
        "rival": nearest,
        "decidable": min(apart) >= DECIDABLE,
    }


def _truth(found: Search, effects: tuple[str, ...]) -> Fit:
    """Return the fit of the withheld effects together."""
    parts = [found.singles[e][0].fit for e in effects]
    first = parts[0]
    if len(parts) == 1:
        return first
    hypothesis, values = first.hypothesis, first.values
    for part in parts[1:]:
        known = dict(zip(part.free, part.values, strict=True))
        joined = hypothesis.joined(part.hypothesis)
        values = np.concatenate((values, [known[f] for f in joined.free[len(hypothesis.free) :]]))
        hypothesis = joined
    return settle(found.sim, found.noise, fit(found.sim, first.whiten, hypothesis, first.theta, values), 1)


def rivals(found: Search, effects: tuple[str, ...]) -> list[str]:
    """Return the single effects that might pass for the withheld ones: the best fitting, look-alikes, parts of a pair."""
    alike = {a for e in effects for a in get(e).look_alikes} | (set(effects) if len(effects) > 1 else set())
    others = [w.ids[0] for w in found.ranked() if len(w.ids) == 1 and (len(effects) > 1 or w.ids[0] not in effects)]
    return [e for i, e in enumerate(others) if i < RIVALS or e in alike]


def document(rows: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """Return the distances of a set, ``sstl.blind.limit/1``."""
    kept = ("case", "effects", "d2_base", "d2_rival", "rival", "decidable", "why")
    judged = [r for r in rows if r["d2_base"] is not None]
    return {
        "schema": SCHEMA,
        "cases": len(rows),
        "judged": len(judged),
        "decidable": sum(bool(r["decidable"]) for r in judged),
        "decidable_d2": DECIDABLE,
        "distances": [{k: r[k] for k in kept} for r in rows],
    }
