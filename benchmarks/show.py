"""The comparison as a table: on the terminal, and between two marks in a page."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

BEGINS, ENDS = "<!-- bench begins -->", "<!-- bench ends -->"
MET = {True: "met", False: "**missed**", None: ""}


def table(rows: list[dict[str, Any]]) -> str:
    """Return a Markdown table of the rows."""
    lines = ["| job | against | measured (spread) | goal | |", "|---|---|---|---|---|"]
    for row in rows:
        unit = row["unit"]
        sign = ">=" if row["at_least"] else "<="
        goal = "" if row["goal"] is None else f"{sign} {row['goal']:g}{_gap(unit)}"
        measured = f"{row['median']:g}{_gap(unit)} ({row['low']:g} to {row['high']:g})"
        lines.append(f"| {row['job']} | {row['against']} | {measured} | {goal} | {MET[row['met']]} |")
    return "\n".join(lines)


def put(page: Path, text: str) -> bool:
    """Replace what stands between the marks of a page; False where it has none."""
    old = page.read_text(encoding="utf-8")
    if old.count(BEGINS) != 1 or old.count(ENDS) != 1:
        return False
    head, rest = old.split(BEGINS)
    temporary = page.with_suffix(".tmp")
    temporary.write_text(f"{head}{BEGINS}\n{text.strip()}\n{ENDS}{rest.split(ENDS)[1]}", encoding="utf-8")
    os.replace(temporary, page)
    return True


def _gap(unit: str) -> str:
    return unit if unit == "x" else f" {unit}"
