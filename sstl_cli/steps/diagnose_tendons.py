"""Diagnose logs with several actuation tendons: each tendon together with the sensing loop they share."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

from sstl_cli.core.documents.diagnosis import DiagnosisDocument, TendonBlock, Verdict
from sstl_cli.core.errors import SstlError
from sstl_cli.core.runs import Run
from sstl_cli.diagnosis.neighbours import with_neighbours
from sstl_cli.physics.effects import catalogue
from sstl_cli.physics.scenario import Scenario
from sstl_cli.steps import diagnose
from sstl_cli.steps.diagnose import DiagnoseOptions, Diagnosis

# of a tendon's document, what its block repeats
BLOCK = ("sentence", "verdict", "gap", "where", "candidates", "next_experiment", "beside", "downstream", "notes")


@dataclass(frozen=True)
class TendonsDiagnosis:
    """One diagnosis a tendon; the one with the largest gap speaks for the log."""

    first: Diagnosis
    body: DiagnosisDocument

    def document(self) -> dict[str, Any]:
        """Return the leading tendon's document as its JSON is written, with ``tendon`` and one block a tendon in ``tendons``."""
        return self.body.plain()

    def model(self) -> Scenario:
        """Return the accepted simulator of the leading tendon."""
        return self.first.model()

    def bare(self) -> Scenario:
        """Return the accepted simulator of the leading tendon without what it is known to leave."""
        return self.first.bare()

    @property
    def given(self) -> Scenario:
        """The simulator that was given, or the one that was assumed."""
        return self.first.given


Diagnosed = Diagnosis | TendonsDiagnosis


def tendons_of(runs: Sequence[Run]) -> list[str]:
    """Return the names of the actuation tendons, sorted; a run without one counts as ''."""
    return sorted({r.tendon or "" for r in runs if r.system == "act"})


def parts(runs: Sequence[Run], earlier: Sequence[Run] | None = None) -> int:
    """Return how many diagnoses these runs ask for, which is what ``run`` tells ``advance`` in all."""
    return sum(max(len(tendons_of(r)), 1) for r in (earlier, runs) if r is not None)


def run(
    runs: Sequence[Run],
    options: DiagnoseOptions,
    advance: Callable[[float], None] = lambda _: None,
    since: float | None = None,
    earlier: Sequence[Run] | None = None,
) -> Diagnosed:
    """Return the diagnosis of recorded runs, per tendon where there are several.

    Each tendon is judged by its own runs, those of the sensing loop, and, where they were recorded at the same time, by the
    tension of its neighbours. Top level of the document is the tendon with the largest gap.

    Parameters
    ----------
    since : float, optional
        When the clock of ``max_seconds`` began (``time.monotonic``; default: now).
    earlier : sequence of Run, optional
        What was recorded before a change: the model that is fitted to it is the simulator.

    Raises
    ------
    SstlError
        If no tendon can be diagnosed.
    """
    since = time.monotonic() if since is None else since
    if earlier is not None:
        # the odds are those of what has changed
        alone = replace(options, prior={}, odd_runs=False)
        was = _run(earlier, alone, lambda share: advance(parts(earlier) * share), since)
        options = replace(options, sim=was.model())
    return _run(runs, options, lambda share: advance(parts(runs) * share), since)


def _run(runs: Sequence[Run], options: DiagnoseOptions, advance: Callable[[float], None], since: float) -> Diagnosed:
    names = tendons_of(runs)
    if len(names) < 2:
        return diagnose.run(runs, options, advance, since)
    shared = [r for r in runs if r.system == "sstl"]
    found: dict[str, Diagnosis] = {}
    failed: dict[str, SstlError] = {}
    for name in names:
        own = [with_neighbours(r, runs) for r in runs if r.system == "act" and (r.tendon or "") == name]
        try:
            said = diagnose.run([*own, *shared], options, lambda share: advance(share / len(names)), since)
            found[name] = replace(said, body=_left_to_the_user(said.body))
        except SstlError as error:
            failed[name] = error
    if not found:
        raise next(iter(failed.values()))
    first = max(found, key=lambda n: (found[n].body.verdict.status != "none", _reducible(found[n].body), n))
    leading = found[first].body
    told = {
        "tendon": first,
        "tendons": [_block(name, found[name].body) if name in found else _failure(name, failed[name]) for name in names],
        "sentence": f"Tendon {first or 'without name'}: {leading.sentence}",
        "analysis": leading.analysis and leading.analysis.model_copy(update={"set_aside": _set_aside(runs, found, failed)}),
    }
    return TendonsDiagnosis(found[first], leading.model_copy(update=told))


def lines(document: DiagnosisDocument) -> list[str]:
    """Return one line a tendon for the screen."""
    return [f"tendon {b.tendon or '(no name)'}: {b.sentence}" for b in document.tendons or ()]


def _reducible(found: DiagnosisDocument) -> float:
    return (found.gap.rmse_retuned_n or 0.0) - found.gap.unavoidable_n


def _block(name: str, found: DiagnosisDocument) -> TendonBlock:
    return TendonBlock(tendon=name, **{k: getattr(found, k) for k in BLOCK if k in found.model_fields_set})


def _failure(name: str, error: SstlError) -> TendonBlock:
    verdict = Verdict(status="unknown", effects=[], confidence=None, ambiguity_group=[], why=error.what)
    return TendonBlock(tendon=name, sentence=f"not diagnosed: {error.what}", verdict=verdict)


def _left_to_the_user(document: DiagnosisDocument) -> DiagnosisDocument:
    """Take back a proposed movement that cannot tell what it is meant to: it moves one tendon only."""
    separates = document.next_experiment.separates if document.next_experiment else []
    ids = [i for text in separates for i in text.split(" + ")]
    if not any(i in catalogue() and catalogue()[i].channel == "neighbour" for i in ids):
        return document
    note = f"to tell {' from '.join(separates)}: hold this tendon while a neighbour moves, then move it while the neighbour holds"
    return document.model_copy(update={"next_experiment": None, "notes": [*(document.notes or []), note]})


def _set_aside(runs: Sequence[Run], found: dict[str, Diagnosis], failed: dict[str, SstlError]) -> dict[str, str]:
    aside = {k: v for d in found.values() if d.body.analysis for k, v in d.body.analysis.set_aside.items()}
    lost = {r.run_id: failed[r.tendon or ""].what for r in runs if r.system == "act" and (r.tendon or "") in failed}
    return {**aside, **lost}
