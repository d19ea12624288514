"""The tables of a diagnosis: places, candidates, their parameters, and what the verdict adds."""

from __future__ import annotations

from typing import Any

from sstl_cli.core.errors import printable
from sstl_cli.reporting.documents import interval, mapping, number, rows
from sstl_cli.reporting.table import Cell, Table, cell, loose, probability, table
from sstl_cli.reporting.words import Catalogue, unit_of, why_null

# parameters of the line itself, which are fitted beside those of an effect
SHARED = {"load_mm_per_n": "how far the load gives way at the far end"}


def all_of(document: dict[str, Any], catalogue: Catalogue) -> list[Table]:
    """Return the tables that the document fills, in the order of the page."""
    verdict, unit = mapping(document, "verdict"), unit_of(document)
    made = [
        _candidates(document, catalogue),
        _parameters(document, catalogue),
        loose("What would have shown", _without_one(verdict.get("would_have_shown")), "effect", unit),
        loose("Where the unexplained rest lies", _flat(verdict.get("leftover")), "field", unit),
        loose("Runs without which the verdict differs", verdict.get("odd_runs"), "run", unit),
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


def _candidates(document: dict[str, Any], catalogue: Catalogue) -> Table | None:
    found = rows(document, "candidates")
    if not found:
        return None
    header: list[Any] = ["candidate", "probability", ("held-out RMSE", unit_of(document)), ("shrink", "%"), "identifiability"]
    more = [k for k in ("sensor", "d2", "change", "members", "why") if any(c.get(k) not in (None, "", []) for c in found)]
    names = {"d2": "D² to the winner"}
    lines = [
        [
            linked(str(c.get("id", "?")), catalogue),
            probability(number(c.get("probability"))),
            number(c.get("rmse_held_out_n")),
            number(c.get("shrink_pct")),
            str(c.get("identifiability") or "–").replace("_", " "),
            *(c.get(k) for k in more),
        ]
        for c in found
    ]
    return table("Candidates", [*header, *(names.get(k, k) for k in more)], lines)


def _parameters(document: dict[str, Any], catalogue: Catalogue) -> Table | None:
    header = ["candidate", "parameter", "estimate", "95 % from", "95 % to", "unit", "meaning", "remark"]
    lines = []
    for c in rows(document, "candidates"):
        for p in rows(c, "parameters"):
            note = catalogue.get(str(p.get("effect") or c.get("id")))
            remarks = ["at the end of its range" if p.get("at_bound") is True else "", why_null(p, "ci95")]
            lines.append(
                [
                    linked(str(c.get("id", "?")), catalogue),
                    p.get("name"),
                    number(p.get("estimate")),
                    *interval(p.get("ci95")),
                    "" if p.get("unit") in ("1", None) else p.get("unit"),
                    (note.meanings if note else {}).get(str(p.get("name"))) or SHARED.get(str(p.get("name")), ""),
                    "; ".join(r for r in remarks if r),
                ]
            )
    return table("Parameters of the candidates, with 95 % intervals", header, lines) if lines else None


def _tracking(document: dict[str, Any], unit: str) -> Table | None:
    found = rows(mapping(document, "downstream"), "tracking")
    header = ["reference", ("tracking RMSE without the effect", unit), ("with it", unit)]
    lines = ([r.get("reference"), *(probability(number(r.get(k))) for k in ("rmse_without_n", "rmse_with_n"))] for r in found)
    return table("A controller designed without and with the effect", header, lines) if found else None


def _where(document: dict[str, Any], unit: str) -> Table | None:
    header = ["system", "phase", "configuration", ("share", "%"), ("RMSE", unit)]
    keys = ("system", "phase", "config_id")
    found = rows(document, "where")
    lines = ([*(r.get(k) for k in keys), number(r.get("share_pct")), number(r.get("rmse_n"))] for r in found)
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
