"""How a diagnosis looks on a terminal below its sentence: candidates, what to record next, stages of a controller."""

from __future__ import annotations

from typing import Any

from sstl_cli.cli.render import Screen, cell, small

SHOWN = 6
PARAMETERS = 3
SMALLEST = 4


def answer(screen: Screen, document: dict[str, Any]) -> None:
    """Print the sentence, then the gap in numbers, where it lies, and what a change would be worth or would have shown."""
    from sstl_cli.diagnosis.sentence import lines
    from sstl_cli.steps.diagnose_tendons import lines as tendons

    screen.say(document["sentence"])
    unit = document.get("unit") or "N"
    # units and small numbers are the screen's to spell
    plain = {**document, "verdict": {**document["verdict"], "would_have_shown": None}, "downstream": None, "notes": []}
    for line in [*lines(plain), *_shown(document["verdict"], unit), *_tracked(document, unit), *_notes(document), *tendons(document)]:
        screen.say(line)
    for remark in document.get("remarks") or []:
        screen.say(f"Physics ({remark['rule']}): {remark['sentence']}. Mend: {remark['mend']}")


def _shown(verdict: dict[str, Any], unit: str) -> list[str]:
    """Return the effects of which the least would have been seen, the smallest gap first."""
    found = sorted(verdict.get("would_have_shown") or [], key=lambda s: float(s["gap_n"]))[:SMALLEST]
    return [f"  would have shown: {s['effect']} from {_brief(s['size'], s['unit'])} on, a gap of {_brief(s['gap_n'], unit)}" for s in found]


def _tracked(document: dict[str, Any], unit: str) -> list[str]:
    """Return what knowing the effect is worth to a controller."""
    return [
        f"  a controller that knows it tracks the {t['reference']} reference to {_brief(small(t['rmse_with_n']), unit)} "
        f"instead of {_brief(small(t['rmse_without_n']), unit)}"
        for t in (document.get("downstream") or {}).get("tracking", [])
    ]


def _notes(document: dict[str, Any]) -> list[str]:
    return [f"  note: {text}" for text in document.get("notes", [])]


def _brief(value: object, unit: str) -> str:
    """Return a number to two digits with its unit; what is dimensionless has none."""
    shown = f"{value:.2g}" if isinstance(value, float) else cell(value)
    return shown if unit == "1" or value is None else f"{shown} {unit}"


def diagnosis(screen: Screen, document: dict[str, Any]) -> None:
    """Print the sentence, what bears on it, what physics says of the recording, and the tables."""
    answer(screen, document)
    tables(screen, document)


def tables(screen: Screen, document: dict[str, Any]) -> None:
    """Print the candidates (none where nothing is missing) and the recording that would tell the first two apart."""
    unit = document.get("unit") or "N"
    if document["verdict"]["status"] != "none":
        rows = [
            (c["id"], small(c["probability"]), c["rmse_held_out_n"], c["shrink_pct"], _parameters(c["parameters"]))
            for c in document["candidates"][:SHOWN]
        ]
        screen.table("candidates", ("effect", "p", f"RMSE {unit}", "shrink %", "parameters"), rows)
        if len(document["candidates"]) > SHOWN:
            screen.line(f"and {len(document['candidates']) - SHOWN} more; --json has all")
    following = document["next_experiment"]
    if following and document["verdict"]["status"] != "none":
        apart = " from ".join(following["separates"])
        screen.say(f"record next: {following['trajectory']}, to tell {apart}; {following['why']}")


def plan(screen: Screen, document: dict[str, Any]) -> None:
    """Say what a movement could tell, then how small a gap of each effect would show."""
    screen.say(document["sentence"])
    rows = [
        (
            r["effect"], f"{r['parameter']} {_brief(r['least_size'], r['unit'])}", f"{r['gap_n']:.2g}", "yes" if r["shows"] else "no",
            "-" if r["told_size"] is None else f"{r['told_size']:.2g}", r["rival"] or "-",
        )
        for r in document["effects"]
    ]  # fmt: skip
    header = ("effect", "would show from", "gap N", "in range", "told from", "its rival")
    screen.table("what this movement could tell (D^2 of 24)", header, rows, most=40)
    for run_id, reason in document["set_aside"].items():
        screen.note(f"set aside: run {run_id}: {reason}")


def stages(screen: Screen, document: dict[str, Any]) -> None:
    """Say which stage of the controller makes most of the error, then the shares of every stream."""
    names = list(document["streams"][0]["share_pct"])
    worst = max(document["streams"], key=lambda s: s["rmse_n"])
    stage = max(names, key=lambda n: worst["share_pct"][n])
    screen.say(
        f"Most of the largest tracking error ({worst['run_id']}, {worst['rmse_n']:.2g} N) comes from the {stage}: "
        f"{worst['share_pct'][stage]:.0f} %."
    )
    rows = [(s["run_id"], small(s["rmse_n"]), *(round(s["share_pct"][n], 1) + 0.0 for n in names)) for s in document["streams"]]
    against = "A share below 0 cancels a part of the others." if any(v < 0 for r in rows for v in r[2:]) else ""
    screen.table("share of the squared tracking error by stage / %", ("stream", "RMSE N", *names), rows, against, most=20)


def _parameters(found: list[dict[str, Any]]) -> str:
    """Return the first parameters as text; a dimensionless one has no unit."""
    shown = [f"{p['name']} {p['estimate']:.3g}" + ("" if p["unit"] == "1" else f" {p['unit']}") for p in found[:PARAMETERS]]
    return ", ".join(shown) + (", ..." if len(found) > PARAMETERS else "")
