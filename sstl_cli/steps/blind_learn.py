"""Learn the verdict's weights from libraries, and say how they do on simulators that they have not seen."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from sstl_cli import __version__
from sstl_cli.blind import learning
from sstl_cli.blind.judge import share
from sstl_cli.blind.learning import EXCLUDED, WITHOUT, Example
from sstl_cli.blind.library import Facts, facts_of, read_library
from sstl_cli.blind.strength import STRENGTHS, band
from sstl_cli.core.documents.blind import BlindLearnDocument, LearnedRow
from sstl_cli.core.errors import SstlError
from sstl_cli.core.provenance import inputs_of
from sstl_cli.core.rng import stream
from sstl_cli.diagnosis.adjusted import NONE, UNKNOWN
from sstl_cli.diagnosis.verdict import Verdict, decided
from sstl_cli.diagnosis.weights import Weights

FEWEST = 50
SAID_NAMES = ("identified", "ambiguous")


def run(paths: Sequence[Path], out: str, advance: Callable[[float], None] = lambda _: None) -> tuple[dict[str, object], BlindLearnDocument]:
    """Return the document of the weights (``sstl.weights/1``) and how they do where they were not learned.

    Raises
    ------
    SstlError
        If a file is no library, or all of them together hold too few cases or one simulator only.
    """
    facts = {p: facts_of(p) for p in paths}
    changes = [p for p in paths if facts[p].accepted]
    taught, drawn, provenance = _lesson({p: facts[p] for p in paths if p not in changes})
    advance(1)
    others = learning.left_out(taught)
    judged, all_judged = learning.judged_by(taught, others), learning.judged_by(drawn, others)
    weights = replace(learning.calibrated(judged, learning.learn(taught, provenance), all_judged), without=others)
    rows, also_rows = report(judged, all_judged, weights), None
    advance(2)
    if changes:
        # what has changed is asked of the same evidence, but beside what a rig is known to leave
        also, also_drawn, provenance = _lesson({p: facts[p] for p in changes})
        apart = learning.left_out(also, others)
        also_judged, also_all = learning.judged_by(also, apart), learning.judged_by(also_drawn, apart)
        known = learning.calibrated(also_judged, learning.learn(also, provenance, weights), also_all, judged)
        weights, also_rows = replace(weights, known=known), report(also_judged, also_all, known)
    advance(2)
    document = BlindLearnDocument(
        schema="sstl.blind.learn/1", commit=weights.commit, cover=weights.cover, left_out=rows, out=out, provenance=dict(weights.provenance)
    )
    return learning.to_document(weights), document if also_rows is None else document.model_copy(update={"accepted": also_rows})


def _lesson(facts: Mapping[Path, Facts]) -> tuple[list[Example], list[Example], dict[str, object]]:
    """Return the examples of libraries of one kind to learn from, all as they were drawn, and where they come from."""
    found = [e for p in facts for e in read_library(p)]
    simulators = sorted({e.simulator for e in found})
    if len(simulators) < 2 or len(found) < FEWEST:
        raise SstlError(
            f"{len(found)} cases of {len(simulators)} simulators are too few to learn from",
            where=", ".join(p.name for p in facts),
            fix=f"give at least {FEWEST} cases of two simulators (sstl blind library --simulator mixed)",
            code="E955",
        )
    taught = told(found)
    return (
        taught,
        [e for e in found if e.kind != WITHOUT],
        {
            "package_version": __version__,
            "cases": sum(int(f.cases) for f in facts.values()),
            "examples": len(taught),
            "without_answer": sum(e.kind == WITHOUT for e in taught),
            "simulators": simulators,
            "seeds": sorted(s for f in facts.values() for s in f.seeds),
            "inputs": inputs_of(list(facts)),
        },
    )


def told(found: Sequence[Example]) -> list[Example]:
    """Return the examples with others instead of those drawn without their effect: as many of which that could be told.

    Of an effect that is no candidate and that another explains as well nobody could say that it is missing. The others were searched
    again without their effect; where no library has such, the effect is taken out of the evidence.
    """
    kept = [e for e in found if e.kind not in (EXCLUDED, WITHOUT) and learning.answerable(e)]
    possible = [e for e in found if e.kind == WITHOUT] or [c for e in kept if (c := learning.without_answer(e)) is not None]
    order = stream(0, "without").permutation(len(possible))
    return kept + [possible[i] for i in order[: sum(e.kind == EXCLUDED for e in found)]]


def report(judged: learning.Judged, drawn: learning.Judged, weights: Weights) -> list[LearnedRow]:
    """Return how the weights of the other simulators do on each simulator, and on all, by the thresholds of these."""
    said = [[(e, decided(e.rows, p, weights)) for e, p in part] for part in (judged, drawn)]
    rows = [
        _row(s, *([pair for pair in part if pair[0].simulator == s] for part in said)) for s in sorted({e.simulator for e, _ in judged})
    ]
    return [*rows, _row("all", *said)]


def _row(name: str, said: Sequence[tuple[Example, Verdict]], drawn: Sequence[tuple[Example, Verdict]]) -> LearnedRow:
    single = [(e, v) for e, v in said if len(e.answer) == 1 and e.answer != UNKNOWN]
    known = [(e, v) for e, v in said if e.answer not in (NONE, UNKNOWN)]
    named = [(e, v) for e, v in known if v.status in SAID_NAMES]
    return LearnedRow(
        simulator=name,
        cases=len(said),
        kinds=dict(sorted(Counter(e.kind for e, _ in said).items())),
        exact={f"{s:g}": share(_exact(e, v) for e, v in single if band(e.strength) == s) for s in STRENGTHS},
        both_of_a_pair=share(_exact(e, v) for e, v in known if len(e.answer) > 1),
        covered=share(learning.is_right(e, v) for e, v in named),
        false_alarm=share(v.status != "none" for e, v in said if e.answer == NONE),
        wrong_commits=share(learning.is_wrong(e, v) for e, v in said),
        unknown_recall=share(v.status == "unknown" for e, v in said if e.answer == UNKNOWN),
        right=share(learning.is_right(e, v) for e, v in said),
        wrong_as_drawn=share(learning.is_wrong(e, v) for e, v in drawn),
    )


def _exact(e: Example, v: Verdict) -> bool:
    return v.status == "identified" and set(v.effects) == set(e.answer)
