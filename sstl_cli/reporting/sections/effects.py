"""Effects: equation and source of every effect that a diagnosis on the page speaks of."""

from __future__ import annotations

from sstl_cli.reporting.diagnosed import parts
from sstl_cli.reporting.diagnosis_tables import anchor
from sstl_cli.reporting.inputs import Inputs

TITLE, ORDER, NEEDS = "Effects and their equations", 65, ("diagnosis",)


def context(inputs: Inputs) -> dict[str, object]:
    """Return the catalogue's entry of each candidate and named effect, in order of first mention."""
    named: list[str] = []
    for document in inputs.diagnosis:
        for _, part in document.by_tendon():
            named += [*part.verdict.effects, *part.verdict.group(), *parts(part.verdict.members)]
            for c in part.candidates:
                named += [c.id, *parts(c.members), *(p.effect for p in c.parameters)]
    known = [e for e in dict.fromkeys(named) if e in inputs.catalogue]
    return {"effects": [{"id": e, "anchor": anchor(e), "note": inputs.catalogue[e]} for e in known]}
