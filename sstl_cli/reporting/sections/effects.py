"""Effects: equation and source of every effect that a diagnosis on the page speaks of."""

from __future__ import annotations

from typing import Any

from sstl_cli.reporting.diagnosis_tables import anchor
from sstl_cli.reporting.documents import ambiguity_group, mapping, rows, texts
from sstl_cli.reporting.inputs import Inputs
from sstl_cli.reporting.sections.diagnosis import tendons

TITLE, ORDER, NEEDS = "Effects and their equations", 65, ("diagnosis",)


def context(inputs: Inputs) -> dict[str, Any]:
    """Return the catalogue's entry of each candidate and named effect, in order of first mention."""
    named: list[str] = []
    for document in inputs.diagnosis:
        for _, part in tendons(document):
            verdict = mapping(part, "verdict")
            named += [*texts(verdict, "effects"), *ambiguity_group(verdict)]
            named += _parts(verdict.get("members"))
            for c in rows(part, "candidates"):
                named += [str(c.get("id")), *_parts(c.get("members")), *(str(p.get("effect")) for p in rows(c, "parameters"))]
    known = [e for e in dict.fromkeys(named) if e in inputs.catalogue]
    return {"effects": [{"id": e, "anchor": anchor(e), "note": inputs.catalogue[e]} for e in known]}


def _parts(members: Any) -> list[str]:
    """Return the effects of a class that this data cannot separate: a list, or lists by the name of the class."""
    found = [m for group in members.values() for m in group] if isinstance(members, dict) else members
    return [str(m) for m in found] if isinstance(found, list) else []
