"""Score the results of a withheld-effect check against its opened truth."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

from sstl_cli.blind import accepted, kept, sides
from sstl_cli.blind.judge import NAMED, Judged, by_others, judge
from sstl_cli.blind.result import Result
from sstl_cli.blind.score import Set, document
from sstl_cli.blind.seal import Planned, Truth
from sstl_cli.core.config import parse
from sstl_cli.core.documents.blind import BlindScoreDocument, CaseDistance, SimulatorRow
from sstl_cli.core.runs import Run
from sstl_cli.diagnosis.weights import Weights, learned
from sstl_cli.physics.effects import get
from sstl_cli.physics.scenario import Scenario

Fresh = Callable[[str], Sequence[Run]]


def run(
    truth: Truth,
    plan: Mapping[str, Planned],
    results: Mapping[str, Result],
    fresh: Fresh | None,
    of_set: Set,
    advance: Callable[[float], None] = lambda _: None,
    distances: Mapping[str, CaseDistance] | None = None,
    weights: Weights | None = None,
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
    weights : Weights, optional
        Those of which each simulator was left out in turn; by default the ones that come with the package.
    """
    judged: list[Judged] = []
    for name in sorted(results):
        realised = None
        if fresh is not None:
            realised = _realised(plan[name], results[name], fresh, name)
        judged.append(judge(name, truth.truths[name], results[name], realised))
        advance(1)
    of_set = replace(of_set, missing_results=len(truth.truths) - len(judged), quick=truth.quick)
    beside = replace(sides.compared(judged, distances), left_out=_left_out(judged, results, weights or learned()))
    return document(judged, beside, of_set)


def _left_out(judged: Sequence[Judged], results: Mapping[str, Result], weights: Weights) -> list[SimulatorRow] | None:
    """Return the rates of each simulator by weights that have not seen it, None where not every result keeps its rows.

    A diagnosis that failed has none, and stays as it is.
    """
    found = []
    for case in judged:
        result, without = results[case.case], weights.without.get(case.truth.simulator)
        if result.error is not None:
            found.append(case)
        elif without is None or result.rows is None:
            return None
        else:
            found.append(by_others(case, kept.from_document(result.rows), without))
    return sides.rows(found)


def _realised(asked: Planned, result: Result, fresh: Fresh, name: str) -> float | None:
    found, verdict = result.diagnosis, result.diagnosis.verdict
    if verdict.status not in NAMED or result.model is None or found.analysis is None:
        return None
    if not all(get(e).fitted and get(e).channel == "out" for e in verdict.effects):
        # a fault of the recorder is masked, not simulated: there is nothing to apply to other recordings
        return None
    model = parse(Scenario, result.model, "model of a result")
    base = accepted.retuned(parse(Scenario, asked.sim, "plan"), found.analysis.theta)
    runs = list(fresh(name))
    return accepted.realised_shrink_pct(base, model, runs) if runs else None
