"""Diagnosis: where, which, how far and how sure first, then pictures, candidates, and what to record next."""

from __future__ import annotations

from typing import Any

from sstl_cli.core.errors import printable
from sstl_cli.core.provenance import by_another
from sstl_cli.reporting import diagnosis_tables, drawing, words
from sstl_cli.reporting.documents import ambiguity_group, mapping, rows, texts
from sstl_cli.reporting.figures import candidates, isolability, misfit, simulated, waterfall, where
from sstl_cli.reporting.inputs import Inputs

TITLE, ORDER, NEEDS = "Diagnosis", 10, ("diagnosis",)
LOOPS = 6


def context(inputs: Inputs) -> dict[str, Any]:
    """Return one block a diagnosis file, and one a tendon where a file judges several."""
    parts = [
        (file, name, part)
        for document in inputs.diagnosis
        for file in [document["file"] if len(inputs.diagnosis) > 1 else ""]
        for name, part in tendons(document)
    ]
    blocks = [_block(file, name, part, i, inputs) for i, (file, name, part) in enumerate(parts)]
    return {"blocks": blocks}


def tendons(document: dict[str, Any]) -> list[tuple[str, dict[str, Any]]]:
    """Return (name, document) of every tendon, the leading one first; the document itself where it has but one.

    The leading tendon's block is the top level too: it has the loops and the isolability, which the others lack.
    """
    found = rows(document, "tendons")
    if not found:
        return [("", document)]
    shared = {k: document[k] for k in ("unit", "schema", "package_version", "file") if k in document}
    leading = document.get("tendon")
    parts = [
        (str(t.get("tendon") or "without a name"), {**(document if t.get("tendon") == leading else shared), **t})
        for t in sorted(found, key=lambda t: t.get("tendon") != leading)
    ]
    return parts


def _unnamed(document: dict[str, Any]) -> dict[str, Any]:
    """Return a document that names no effect without the numbers and curves 'with the effect'."""
    if texts(mapping(document, "verdict"), "effects"):
        return document
    plain = {**document, "gap": {**mapping(document, "gap"), "rmse_with_effect_n": None}}
    for key, curve in (("loops", "with_effect_n"), ("residuals", "effect_n")):
        plain[key] = [{k: v for k, v in row.items() if k != curve} for row in rows(document, key)]
    return plain


def _block(file: str, tendon: str, document: dict[str, Any], place: int, inputs: Inputs) -> dict[str, Any]:
    document = _unnamed(document)
    verdict = mapping(document, "verdict")
    status = str(verdict.get("status", "–"))
    pictures = {}
    for name, module in (("waterfall", waterfall), ("where", where), ("candidates", candidates), ("isolability", isolability)):
        # below 'none' a list of candidates would read like a list of suspects
        found = None if name == "candidates" and status == "none" else module.default(Inputs(diagnosis=[document]), None)
        pictures[name] = drawing.picture(module, found, f"{name}-{place}") if found is not None else None
    unit = words.unit_of(document)
    loops = [simulated.data(loop, unit) for loop in rows(document, "loops")[:LOOPS]]
    left = [misfit.data(record, unit) for record in misfit.records(document)[:LOOPS]]
    heading = " · ".join(t for t in (f"Tendon {tendon}" if tendon else "", file) if t)
    return {
        "heading": printable(heading),
        "id": f"diagnosis-{place}",
        "status": status,
        "sentence": words.sentence(document, inputs.catalogue),
        "why": str(verdict.get("why") or ""),
        "facts": _facts(document, inputs),
        "remarks": [printable(r) for r in [*texts(document, "remarks"), *texts(document, "notes")]]
        + by_another(document.get("package_version"), "this diagnosis"),
        # many configurations need the whole width to stay readable
        "wide_map": len({r.get("config_id") for r in rows(document, "where")}) > 8,
        "pictures": pictures,
        "loops": [drawing.picture(simulated, d, f"simulated-{place}-{i}") for i, d in enumerate(loops) if d["curves"]],
        "left": [drawing.picture(misfit, d, f"misfit-{place}-{i}") for i, d in enumerate(left) if d["curves"]],
        "tables": diagnosis_tables.all_of(document if status != "none" else {**document, "candidates": []}, inputs.catalogue),
        "next": _next(mapping(document, "next_experiment")),
    }


def _facts(document: dict[str, Any], inputs: Inputs) -> list[dict[str, Any]]:
    """Return the four answers of the first screen; one that the document cannot give is left out."""
    verdict = mapping(document, "verdict")
    effects = texts(verdict, "effects")
    others = [e for e in ambiguity_group(verdict) if e not in effects]
    which = [diagnosis_tables.linked(e, inputs.catalogue) for e in effects]
    also = f"Not told apart from it: {words.listed((words.title(e, inputs.catalogue) for e in others), 'or')}." if others else ""
    named = words.listed((words.title(e, inputs.catalogue) for e in effects), "and")
    found = [
        ("Where", [words.where(document)], []),
        ("Which", [f"{named[:1].upper()}{named[1:]}." if named else "", also], which),
        ("How far", [words.how_far(document), words.shrinkage(document)], []),
        ("How sure", [words.how_sure(document, inputs.blind or [words.published()])] if verdict else [], []),
    ]
    return [{"name": name, "lines": [t for t in lines if t], "links": links} for name, lines, links in found if any(lines)]


def _next(document: dict[str, Any]) -> dict[str, str] | None:
    if not document:
        return None
    return {
        "separates": " from ".join(texts(document, "separates")),
        "trajectory": str(document.get("trajectory") or ""),
        "why": str(document.get("why") or ""),
    }
