"""Put a generated table into a page, between its two marks; the rest of the page is written by hand."""

from __future__ import annotations

import os
import subprocess
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

DOCS = Path(__file__).resolve().parents[1] / "docs"


def commit() -> str:
    """Return which commit the program is of, with ``-dirty`` where its files differ from it; for pages of measured numbers."""
    asked = ["git", "describe", "--always", "--dirty", "--exclude=*"]
    found = subprocess.run(asked, cwd=DOCS, capture_output=True, text=True, check=False)
    return found.stdout.strip() or "no known commit"


def commits(rows: Iterable[Mapping[str, Any]]) -> str:
    """Return by which commits rows were measured, as far as they say so."""
    return ", ".join(sorted({str(r["commit"]) for r in rows if "commit" in r})) or "no known commit"


def put(page: str, name: str, text: str) -> None:
    """Replace what stands between ``<!-- NAME begins -->`` and ``<!-- NAME ends -->`` in a page of docs/.

    Raises
    ------
    ValueError
        If the page has not exactly one such place.
    """
    path = DOCS / page
    head, _, tail = _split(page, name)
    temporary = path.with_suffix(".tmp")
    temporary.write_text(f"{head}<!-- {name} begins -->\n{text.strip()}\n<!-- {name} ends -->{tail}", encoding="utf-8")
    os.replace(temporary, path)


def inside(page: str, name: str) -> str:
    """Return what stands there now."""
    return _split(page, name)[1]


def _split(page: str, name: str) -> tuple[str, str, str]:
    begins, ends = f"<!-- {name} begins -->", f"<!-- {name} ends -->"
    old = (DOCS / page).read_text(encoding="utf-8")
    if old.count(begins) != 1 or old.count(ends) != 1:
        raise ValueError(f"{page} needs {begins} and {ends} once each")
    head, rest = old.split(begins)
    middle, tail = rest.split(ends)
    return head, middle, tail


def table(head: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """Return a Markdown table."""
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    return "\n".join([*lines, *("| " + " | ".join(str(c) for c in row) + " |" for row in rows)])
