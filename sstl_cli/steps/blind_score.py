"""Score the results of a withheld-effect check against its opened truth."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from sstl_cli.blind import accepted, sides
from sstl_cli.blind.judge import Judged, judge
from sstl_cli.blind.score import document
from sstl_cli.core.config import parse
from sstl_cli.core.runs import Run
from sstl_cli.physics.effects import get
from sstl_cli.physics.scenario import Scenario

Fresh = Callable[[str], Sequence[Run]]


def run(
    truth: Mapping[str, Any],
    plan: Mapping[str, Mapping[str, Any]],
    results: Mapping[str, Mapping[str, Any]],
    fresh: Fresh | None,
    advance: Callable[[float], None] = lambda _: None,
    distances: Mapping[str, Mapping[str, Any]] | None = None,
) -> dict[str, Any]:
    """Return the score of a set, ``sstl.blind.score/1``.

    Parameters
    ----------
    truth : mapping
        The opened and verified truth document.
    plan, results : mappings by case name
        What was asked, and what came out; cases without a result are left out and counted.
    fresh : callable or None
        Returns the recordings of a case that nobody diagnosed, for the realised shrinkage.
    distances : mapping by case name, optional
        How far the truth of each case is from base and rivals (``sstl blind limit``); then rates come twice.
    """
    judged: list[Judged] = []
    for name in sorted(results):
        realised = None
        if fresh is not None:
            realised = _realised(plan[name], results[name], fresh, name)
        judged.append(judge(name, truth["truths"][name], results[name], realised))
        advance(1)
    body = document(judged)
    body |= sides.document(judged, distances)
    body["missing_results"] = len(truth["truths"]) - len(judged)
    body["quick"] = truth["quick"]
    return body


def _realised(asked: Mapping[str, Any], result: Mapping[str, Any], fresh: Fresh, name: str) -> float | None:
    verdict = result["diagnosis"]["verdict"]
    if verdict["status"] not in ("identified", "ambiguous") or result["model"] is None:
        return None
    if not all(get(e).fitted and get(e).channel == "out" for e in verdict["effects"]):
        # a fault of the recorder is masked, not simulated: there is nothing to apply to other recordings
        return None
    model = parse(Scenario, result["model"], "model of a result")
    base = accepted.retuned(parse(Scenario, asked["sim"], "plan"), result["diagnosis"]["analysis"]["theta"])
    runs = list(fresh(name))
    return accepted.realised_shrink_pct(base, model, runs) if runs else None
