"""The tables of a diagnosis: places, candidates, their parameters, and what the verdict adds."""

from __future__ import annotations

from typing import Any

from sstl_cli.core.errors import printable
from sstl_cli.core.groups import of_samples
from sstl_cli.reporting.diagnosed import Diagnosed
from sstl_cli.reporting.documents import NAN
from sstl_cli.reporting.table import Cell, Table, cell, loose, probability, table
from sstl_cli.reporting.words import Catalogue, unit_of, why_null

# parameters of the line itself, which are fitted beside those of an effect
SHARED = {
    "load_mm_per_n": "how far the load gives way at the far end",
    "loop_load_mm_per_n": "how far what the sensing loop ends at gives way",
}


def all_of(document: Diagnosed, catalogue: Catalogue) -> list[Table]:
    """Return the tables that the document fills, in the order of the page."""
    verdict, unit = document.verdict, unit_of(document)
    made = [
        _candidates(document, catalogue),
        _parameters(document, catalogue),
        loose("What would have shown", _without_one(verdict.would_have_shown), "effect", unit),
        loose("Where the unexplained rest lies", _flat(verdict.leftover), "field", unit),
        loose("Runs without which the verdict differs", verdict.odd_runs, "run", unit),
        _tracking(document, unit),
        _where(document, unit),
    ]
    return [t for t in made if t is not None]


def anchor(name: str) -> str:
    """Return the id of an effect's place on the page."""
    return "effect-" + "".join(c if c.isalnum() else "-" for c in name)


def linked(name: str, catalogue: Catalogue) -> Cell:
    """Return a candidate's name; it leads to the equation where the catalogue has one."""
    return Cell(printable(name), href=f"#{anchor(name)}" if name in catalogue else "")


def _candidates(document: Diagnosed, catalogue: Catalogue) -> Table | None:
    found = document.candidates
    if not found:
        return None
    header: list[Any] = ["candidate", "probability", ("held-out RMSE", unit_of(document)), ("shrink", "%"), "identifiability"]
    more = [k for k in ("sensor", "d2", "change", "members", "why") if any(getattr(c, k) not in (None, "", []) for c in found)]
    names = {"d2": "D² to the winner", "samples": "errors are of samples"}
    more += ["samples"] if of_samples(found) else []
    lines = [
        [
            linked(c.id, catalogue),
            probability(c.probability),
            c.rmse_held_out_n,
            c.shrink_pct,
            (c.identifiability or "–").replace("_", " "),
            *(getattr(c, k) for k in more),
        ]
        for c in found
    ]
    return table("Candidates", [*header, *(names.get(k, k) for k in more)], lines)


def _parameters(document: Diagnosed, catalogue: Catalogue) -> Table | None:
    header = ["candidate", "parameter", "estimate", "95 % from", "95 % to", "unit", "meaning", "remark"]
    lines = []
    for c in document.candidates:
        for p in c.parameters:
            note = catalogue.get(p.effect or c.id)
            remarks = ["at the end of its range" if p.at_bound else "", why_null(p.ci95, p.ci95_why, p)]
            lines.append(
                [
                    linked(c.id, catalogue),
                    p.name or None,
                    p.estimate,
                    *(p.ci95 or (NAN, NAN)),
                    "" if p.unit == "1" else p.unit,
                    (note.meanings if note else {}).get(p.name) or SHARED.get(p.name, ""),
                    "; ".join(r for r in remarks if r),
                ]
            )
    return table("Parameters of the candidates, with 95 % intervals", header, lines) if lines else None


def _tracking(document: Diagnosed, unit: str) -> Table | None:
    found = document.downstream.tracking
    header = ["reference", ("tracking RMSE without the effect", unit), ("with it", unit)]
    lines = ([r.reference or None, probability(r.rmse_without_n), probability(r.rmse_with_n)] for r in found)
    return table("A controller designed without and with the effect", header, lines) if found else None


def _where(document: Diagnosed, unit: str) -> Table | None:
    header = ["system", "phase", "configuration", ("share", "%"), ("RMSE", unit)]
    found = document.where
    lines = ([r.system or None, r.phase or None, r.config_id or None, r.share_pct, r.rmse_n] for r in found)
    return table("Where the gap sits", header, lines) if found else None


def _without_one(found: Any) -> Any:
    """Return rows whose dimensionless sizes have no unit, instead of the unit 1."""
    if not isinstance(found, list):
        return found
    return [{**r, "unit": ""} if isinstance(r, dict) and r.get("unit") == "1" else r for r in found]


def _flat(found: Any) -> Any:
    """Return an object's fields as text, so that a place, a time and a run share one column."""
    if not isinstance(found, dict):
        return found
    return [{"field": k.replace("_", " "), "value": cell(v).text} for k, v in found.items()]
