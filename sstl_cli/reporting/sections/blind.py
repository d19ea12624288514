"""Blind check: targets, confusion matrix, reliability diagram, strength curves, baselines."""

from __future__ import annotations

from collections.abc import Sequence

from sstl_cli.reporting import drawing
from sstl_cli.reporting.documents import Rate
from sstl_cli.reporting.figures import baselines, confusion, distance, reliability, shrink, strength
from sstl_cli.reporting.figures.strength import SCORES
from sstl_cli.reporting.inputs import Inputs
from sstl_cli.reporting.scored import Scored, Target
from sstl_cli.reporting.table import Table, table

TITLE, ORDER, NEEDS = "Blind check", 60, ("blind",)


def context(inputs: Inputs) -> dict[str, object]:
    """Return one block a blind result."""
    return {"blocks": [_block(document, i) for i, document in enumerate(inputs.blind)]}


def _block(document: Scored, place: int) -> dict[str, object]:
    one = Inputs(blind=[document])
    pictures = [
        (heading, drawing.picture(module, found, f"{module.__name__.rpartition('.')[2]}-{place}"))
        for heading, module in (
            ("Scores by strength", strength),
            ("Beside an ideal observer", distance),
            ("Reliability", reliability),
            ("Beside the baselines", baselines),
            ("Shrinkage: predicted and realised", shrink),
        )
        if (found := module.default(one, None)) is not None
    ]
    matrix = confusion.default(one, None)
    targets = document.targets
    return {
        "file": document.file,
        "cases": document.cases,
        "pictures": pictures,
        "confusion": drawing.picture(confusion, matrix, f"confusion-{place}") if matrix else None,
        "met": sum(t.met is True for t in targets),
        "of": len(targets),
        "tables": [t for t in (_targets(targets), _strengths(document), _effects(document), _baselines(document)) if t is not None],
    }


def _targets(found: Sequence[Target]) -> Table | None:
    return table("Targets", ["score", "value", "target", "met"], ([t.name, t.value, t.target, t.met] for t in found)) if found else None


def _strengths(document: Scored) -> Table | None:
    header = [("strength", "1"), "score", ("share", "1"), ("95 % from", "1"), ("95 % to", "1"), ("cases", "1")]
    lines = []
    for row in document.by_strength:
        for score, (name, *_) in SCORES.items():
            middle, low, high, n = row.of(score)
            if middle == middle:
                lines.append([row.strength, name, middle, low, high, int(n) if n == n else None])
    return table("Scores by strength", header, lines) if lines else None


def _effects(document: Scored) -> Table | None:
    found = document.by_effect
    if not found:
        return None
    strengths = list(found[0].isolation)
    header = ["effect", *((f"isolated at {s}", "1") for s in strengths), "misses, and the likely reason"]
    lines = [[r.effect, *(r.isolation.get(s, Rate()).share for s in strengths), r.reason] for r in found]
    return table("Isolation by effect", header, lines)


def _baselines(document: Scored) -> Table | None:
    found = document.baselines
    return (
        table(
            "Baselines on the same cases",
            ["name", *(name for name, *_ in SCORES.values())],
            ([r.name, *(r.of(s).share for s in SCORES)] for r in found),
        )
        if found
        else None
    )
