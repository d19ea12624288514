"""Diagnose the cases of a withheld-effect check, each from its recordings alone."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from typing import NamedTuple

from sstl_cli.blind import kept
from sstl_cli.blind.result import SCHEMA
from sstl_cli.core.documents.diagnosis import DiagnosisDocument
from sstl_cli.core.errors import SstlError
from sstl_cli.core.runs import Run
from sstl_cli.diagnosis.features import Rows
from sstl_cli.physics.scenario import Scenario

# recordings, the simulator as stated, effects that are no candidates -> diagnosis document and accepted simulator
Diagnoser = Callable[[Sequence[Run], Scenario, tuple[str, ...]], "Answer"]
# parts of a diagnosis that are for drawing only
DRAWN = ("loops",)


class Answer(NamedTuple):
    """A diagnosis as its document, the accepted simulator and the rows that the verdict was made from, None where there are none."""

    document: DiagnosisDocument
    model: Scenario | None
    rows: Rows | None = None


def diagnose(runs: Sequence[Run], sim: Scenario, exclude: tuple[str, ...]) -> Answer:
    """Return the diagnosis of recordings as ``sstl diagnose`` makes it, and the accepted simulator."""
    from sstl_cli.steps import diagnose as step

    # who records the position wants it explained
    position = any(r.position_in_mm is not None for r in runs)
    found = step.run(list(runs), step.DiagnoseOptions(sim=sim, exclude=exclude, workers=1, position=position))
    return Answer(found.body, found.bare(), found.evidence.rows)


def run(case: str, runs: Sequence[Run], sim: Scenario, exclude: tuple[str, ...], diagnoser: Diagnoser = diagnose) -> dict[str, object]:
    """Return the result of one case (``sstl.blind.result/1``); a diagnosis that fails is a result, too.

    Parameters
    ----------
    case : str
        Neutral name; it goes into the result and nowhere else.
    diagnoser : callable
        What is being checked; by default the diagnosis of this package.
    """
    started = time.perf_counter()
    error = None
    try:
        found, model, rows = Answer(*diagnoser(runs, sim, exclude))
        document = found.plain()
    except SstlError as failure:
        error = failure.line()
        document, model, rows = failed(error), None, None
    seconds = time.perf_counter() - started
    return {
        "schema": SCHEMA,
        "case": case,
        "seconds": seconds,
        "error": error,
        "diagnosis": {k: v for k, v in document.items() if k not in DRAWN},
        "model": None if model is None else model.model_dump(mode="json", by_alias=True, exclude_none=True),
        "rows": None if rows is None else kept.to_document(rows),
    }


def failed(why: str) -> dict[str, object]:
    """Return the diagnosis that stands for a failure: no verdict, no confidence."""
    return {
        "verdict": {"status": "failed", "effects": [], "confidence": 0.0, "ambiguity_group": [], "why": why},
        "gap": {"shrink_pct": None},
        "candidates": [],
        "baselines": {},
        "analysis": {"theta": {}},
    }
