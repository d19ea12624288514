"""Effects: equation and source of every effect that a diagnosis on the page speaks of."""

from __future__ import annotations

from typing import Any

from sstl_cli.reporting.diagnosis_tables import anchor
from sstl_cli.reporting.documents import mapping, rows, texts
from sstl_cli.reporting.inputs import Inputs
from sstl_cli.reporting.sections.diagnosis import tendons

TITLE, ORDER, NEEDS = "Effects and their equations", 65, ("diagnosis",)


def context(inputs: Inputs) -> dict[str, Any]:
    """Return the catalogue's entry of each candidate and named effect, in order of first mention."""
    named: list[str] = []
    for document in inputs.diagnosis:
        for _, part in tendons(document):
            verdict = mapping(part, "verdict")
            named += [*texts(verdict, "effects"), *texts(verdict, "ambiguity_group")]
            named += [str(i) for c in rows(part, "candidates") for i in (c.get("id"), *(p.get("effect") for p in rows(c, "parameters")))]
    known = [e for e in dict.fromkeys(named) if e in inputs.catalogue]
    return {"effects": [{"id": e, "anchor": anchor(e), "note": inputs.catalogue[e]} for e in known]}
