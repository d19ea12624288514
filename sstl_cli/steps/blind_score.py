"""Score the results of a withheld-effect check against its opened truth."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

from sstl_cli.blind import accepted, sides
from sstl_cli.blind.judge import Judged, judge
from sstl_cli.blind.score import Set, document
from sstl_cli.blind.seal import Planned, Truth
from sstl_cli.core.config import parse
from sstl_cli.core.documents.blind import BlindScoreDocument, CaseDistance
from sstl_cli.core.runs import Run
from sstl_cli.physics.effects import get
from sstl_cli.physics.scenario import Scenario

Fresh = Callable[[str], Sequence[Run]]


def run(
    truth: Truth,
    plan: Mapping[str, Planned],
    results: Mapping[str, Mapping[str, Any]],
    fresh: Fresh | None,
    of_set: Set,
    advance: Callable[[float], None] = lambda _: None,
    distances: Mapping[str, CaseDistance] | None = None,
) -> BlindScoreDocument:
    """Return the score of a set, ``sstl.blind.score/1``.

    Parameters
    ----------
    truth : Truth
        The opened and verified truth of the set.
    plan, results : mappings by case name
        What was asked, and what came out; cases without a result are left out and counted.
    fresh : callable or None
        Returns the recordings of a case that nobody diagnosed, for the realised shrinkage.
    of_set : Set
        Seal and seeds; cases without a result are counted here.
    distances : mapping by case name, optional
        How far the truth of each case is from base and rivals (``sstl blind limit``); then rates come twice.
    """
    judged: list[Judged] = []
    for name in sorted(results):
        realised = None
        if fresh is not None:
            realised = _realised(plan[name], results[name], fresh, name)
        judged.append(judge(name, truth.truths[name], results[name], realised))
        advance(1)
    of_set = replace(of_set, missing_results=len(truth.truths) - len(judged), quick=truth.quick)
    return document(judged, sides.compared(judged, distances), of_set)


def _realised(asked: Planned, result: Mapping[str, Any], fresh: Fresh, name: str) -> float | None:
    verdict = result["diagnosis"]["verdict"]
    if verdict["status"] not in ("identified", "ambiguous") or result["model"] is None:
        return None
    if not all(get(e).fitted and get(e).channel == "out" for e in verdict["effects"]):
        # a fault of the recorder is masked, not simulated: there is nothing to apply to other recordings
        return None
    model = parse(Scenario, result["model"], "model of a result")
    base = accepted.retuned(parse(Scenario, asked.sim, "plan"), result["diagnosis"]["analysis"]["theta"])
    runs = list(fresh(name))
    return accepted.realised_shrink_pct(base, model, runs) if runs else None
