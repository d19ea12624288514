"""Diagnosis: the sentence first, then the gap, where it sits, the candidates, and what to record next."""

from __future__ import annotations

from typing import Any

from sstl_cli.reporting import drawing
from sstl_cli.reporting.documents import interval, mapping, number, rows, texts
from sstl_cli.reporting.figures import candidates, isolability, simulated, waterfall, where
from sstl_cli.reporting.inputs import Inputs
from sstl_cli.reporting.table import table

TITLE, ORDER, NEEDS = "Diagnosis", 10, ("diagnosis",)
LOOPS = 6


def context(inputs: Inputs) -> dict[str, Any]:
    """Return one block a diagnosis file."""
    return {"blocks": [_block(document, i) for i, document in enumerate(inputs.diagnosis)]}


def sentence(document: dict[str, Any]) -> str:
    """Return the verdict as one sentence.

    Examples
    --------
    >>> sentence({"verdict": {"status": "identified", "effects": ["pulley_friction"], "confidence": 0.97}})
    'The simulator misses pulley friction (confidence 97 %).'
    """
    verdict = mapping(document, "verdict")
    effects = _list(texts(verdict, "effects"), "and")
    group = _list(texts(verdict, "ambiguity_group"), "or")
    status = str(verdict.get("status", ""))
    text = {
        "identified": f"The simulator misses {effects or 'an effect'}",
        "ambiguous": f"The simulator misses {group or effects or 'an effect'}, and this data cannot tell which",
        "unknown": "The simulator misses something that no candidate, alone or combined, explains",
        "none": "The simulator already explains the log down to its noise floor",
    }.get(status, f"The verdict is '{status}'" if status else "The document holds no verdict")
    sure = number(verdict.get("confidence"))
    return text + (f" (confidence {100 * sure:.0f} %)." if sure == sure else ".")


def _block(document: dict[str, Any], place: int) -> dict[str, Any]:
    gap = mapping(document, "gap")
    pictures = {}
    for name, module in (
        ("waterfall", waterfall),
        ("where", where),
        ("candidates", candidates),
        ("isolability", isolability),
    ):
        found = module.default(Inputs(diagnosis=[document]), None)
        pictures[name] = drawing.picture(module, found, f"{name}-{place}") if found is not None else None
    loops = [simulated.data(loop) for loop in rows(document, "loops")[:LOOPS]]
    low, high = interval(gap.get("shrink_ci95_pct"))
    return {
        "file": document["file"],
        "status": str(mapping(document, "verdict").get("status", "–")),
        "sentence": sentence(document),
        "why": str(mapping(document, "verdict").get("why") or ""),
        # many configurations need the whole width to stay readable
        "wide_map": len({r.get("config_id") for r in rows(document, "where")}) > 8,
        "pictures": pictures,
        "loops": [drawing.picture(simulated, d, f"simulated-{place}-{i}") for i, d in enumerate(loops) if d["curves"]],
        "shrink": number(gap.get("shrink_pct")),
        "low": low,
        "high": high,
        "held_out": gap.get("held_out"),
        "explained": number(gap.get("explained_of_reducible_pct")),
        "where": _where(document),
        "candidates": _candidates(document),
        "parameters": _parameters(document),
        "next": _next(mapping(document, "next_experiment")),
    }


def _where(document: dict[str, Any]) -> Any:
    header = ["system", "phase", "configuration", ("share", "%"), ("RMSE", "N")]
    found = rows(document, "where")
    return (
        table(
            "Where the gap sits",
            header,
            (
                [
                    r.get("system"),
                    r.get("phase"),
                    r.get("config_id"),
                    number(r.get("share_pct")),
                    number(r.get("rmse_n")),
                ]
                for r in found
            ),
        )
        if found
        else None
    )


def _candidates(document: dict[str, Any]) -> Any:
    header = ["candidate", ("probability", "1"), ("held-out RMSE", "N"), ("shrink", "%"), "identifiability"]
    found = rows(document, "candidates")
    return (
        table(
            "Candidates",
            header,
            (
                [
                    r.get("id"),
                    number(r.get("probability")),
                    number(r.get("rmse_held_out_n")),
                    number(r.get("shrink_pct")),
                    str(r.get("identifiability") or "–").replace("_", " "),
                ]
                for r in found
            ),
        )
        if found
        else None
    )


def _parameters(document: dict[str, Any]) -> Any:
    header = ["candidate", "parameter", "unit", "estimate", "95 % from", "95 % to", "at bound"]
    found = [
        [
            c.get("id"),
            p.get("name"),
            p.get("unit"),
            number(p.get("estimate")),
            *interval(p.get("ci95")),
            p.get("at_bound"),
        ]
        for c in rows(document, "candidates")
        for p in rows(c, "parameters")
    ]
    return table("Parameters of the candidates, with 95 % intervals", header, found) if found else None


def _next(document: dict[str, Any]) -> dict[str, str] | None:
    if not document:
        return None
    return {
        "separates": _list(texts(document, "separates"), "from"),
        "trajectory": str(document.get("trajectory") or ""),
        "why": str(document.get("why") or ""),
    }


def _list(names: list[str], word: str) -> str:
    plain = [n.replace("_", " ") for n in names]
    return (
        f" {word} ".join(plain) if len(plain) < 3 or word == "from" else f"{', '.join(plain[:-1])} {word} {plain[-1]}"
    )
