"""Diagnosis: where, which, how far and how sure first, then pictures, candidates, and what to record next."""

from __future__ import annotations

from sstl_cli.core.errors import printable
from sstl_cli.core.provenance import by_another
from sstl_cli.reporting import diagnosis_tables, drawing, words
from sstl_cli.reporting.diagnosed import Diagnosed, Next
from sstl_cli.reporting.documents import NAN
from sstl_cli.reporting.figures import candidates, isolability, misfit, simulated, waterfall, where
from sstl_cli.reporting.inputs import Inputs

TITLE, ORDER, NEEDS = "Diagnosis", 10, ("diagnosis",)
LOOPS = 6


def context(inputs: Inputs) -> dict[str, object]:
    """Return one block a diagnosis file, and one a tendon where a file judges several."""
    parts = [
        (file, name, part)
        for document in inputs.diagnosis
        for file in [document.file if len(inputs.diagnosis) > 1 else ""]
        for name, part in document.by_tendon()
    ]
    blocks = [_block(file, name, part, i, inputs) for i, (file, name, part) in enumerate(parts)]
    return {"blocks": blocks}


def _unnamed(document: Diagnosed) -> Diagnosed:
    """Return a document that names no effect without the numbers and curves 'with the effect'."""
    if document.verdict.effects:
        return document
    return document.model_copy(
        update={
            "gap": document.gap.model_copy(update={"rmse_with_effect_n": NAN}),
            "loops": tuple(r.model_copy(update={"with_effect_n": ()}) for r in document.loops),
            "residuals": tuple(r.model_copy(update={"effect_n": ()}) for r in document.residuals),
        }
    )


def _block(file: str, tendon: str, document: Diagnosed, place: int, inputs: Inputs) -> dict[str, object]:
    document = _unnamed(document)
    verdict = document.verdict
    status = verdict.status or "–"
    pictures = {}
    for name, module in (("waterfall", waterfall), ("where", where), ("candidates", candidates), ("isolability", isolability)):
        # below 'none' a list of candidates would read like a list of suspects
        found = None if name == "candidates" and status == "none" else module.default(Inputs(diagnosis=[document]), None)
        pictures[name] = drawing.picture(module, found, f"{name}-{place}") if found is not None else None
    unit = words.unit_of(document)
    loops = [simulated.data(loop, unit) for loop in document.loops[:LOOPS]]
    left = [misfit.data(record, unit) for record in misfit.records(document)[:LOOPS]]
    heading = " · ".join(t for t in (f"Tendon {tendon}" if tendon else "", file) if t)
    return {
        "heading": printable(heading),
        "id": f"diagnosis-{place}",
        "status": status,
        "sentence": words.sentence(document, inputs.catalogue),
        "why": verdict.why,
        "facts": _facts(document, inputs),
        "remarks": [printable(r) for r in [*document.remarks, *document.notes]] + by_another(document.package_version, "this diagnosis"),
        # many configurations need the whole width to stay readable
        "wide_map": len({p.config_id for p in document.where}) > 8,
        "pictures": pictures,
        "loops": [drawing.picture(simulated, d, f"simulated-{place}-{i}") for i, d in enumerate(loops) if d.curves],
        "left": [drawing.picture(misfit, d, f"misfit-{place}-{i}") for i, d in enumerate(left) if d.curves],
        "tables": diagnosis_tables.all_of(
            document if status != "none" else document.model_copy(update={"candidates": ()}), inputs.catalogue
        ),
        "next": _next(document.next_experiment),
    }


def _facts(document: Diagnosed, inputs: Inputs) -> list[dict[str, object]]:
    """Return the four answers of the first screen; one that the document cannot give is left out."""
    effects = document.verdict.effects
    others = [e for e in document.verdict.group() if e not in effects]
    which = [diagnosis_tables.linked(e, inputs.catalogue) for e in effects]
    also = f"Not told apart from it: {words.listed((words.title(e, inputs.catalogue) for e in others), 'or')}." if others else ""
    named = words.listed((words.title(e, inputs.catalogue) for e in effects), "and")
    found = [
        ("Where", [words.where(document)], []),
        ("Which", [f"{named[:1].upper()}{named[1:]}." if named else "", also], which),
        ("How far", [words.how_far(document), words.shrinkage(document)], []),
        ("How sure", [words.how_sure(document, inputs.blind or [words.published()])] if document.verdict.model_fields_set else [], []),
    ]
    return [{"name": name, "lines": [t for t in lines if t], "links": links} for name, lines, links in found if any(lines)]


def _next(found: Next) -> dict[str, str] | None:
    if not found.model_fields_set:
        return None
    return {"separates": " from ".join(found.separates), "trajectory": found.trajectory, "why": found.why}
