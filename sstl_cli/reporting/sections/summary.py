"""Summaries: every other JSON document of the toolchain as a table of its fields."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from sstl_cli.reporting.inputs import Inputs
from sstl_cli.reporting.table import table

TITLE, ORDER, NEEDS = "Summaries", 70, ("document",)
MOST = 400


def context(inputs: Inputs) -> dict[str, object]:
    """Return one table a document."""
    return {"tables": [table(f"{name} ({d.get('schema')})", ["field", "value"], flat(d)) for name, d in inputs.document]}


def flat(document: Mapping[str, object]) -> list[list[Any]]:
    """Return the first MOST fields of a nested document as (path, value).

    Examples
    --------
    >>> flat({"a": {"b": 1.5}, "c": [True]})
    [['a.b', 1.5], ['c[0]', True]]
    """
    rows: list[list[Any]] = []
    for path, value in _walk(document, ""):
        if path in ("schema", "file"):
            continue
        if len(rows) == MOST:
            rows.append(["…", f"more than {MOST} fields; see the file"])
            break
        rows.append([path, value])
    return rows


def _walk(value: Any, path: str) -> Iterator[tuple[str, Any]]:
    if isinstance(value, dict):
        for key, inner in value.items():
            yield from _walk(inner, f"{path}.{key}" if path else str(key))
    elif isinstance(value, list):
        for place, inner in enumerate(value):
            yield from _walk(inner, f"{path}[{place}]")
    else:
        yield path, value
