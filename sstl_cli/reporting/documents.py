"""Read JSON documents that may lack keys: a missing value is null, a wrong type is a clear error."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from sstl_cli.core.errors import SstlError
from sstl_cli.core.groups import spelled_out


def number(value: Any) -> float:
    """Return a finite number, or NaN for everything else."""
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
        return float("nan")
    return float(value)


def mapping(document: Any, key: str) -> dict[str, Any]:
    """Return the object under ``key`` (empty if absent); SstlError E604 if it is something else."""
    return _typed(document, key, dict, "an object") or {}


def rows(document: Any, key: str) -> list[dict[str, Any]]:
    """Return the list of objects under ``key`` (empty if absent); SstlError E604 if it is not one."""
    found = _typed(document, key, list, "a list of objects") or []
    if not all(isinstance(r, dict) for r in found):
        raise SstlError(f"'{key}' is not a list of objects", where=str(document.get("schema", "JSON document")), code="E604")
    return found


def texts(document: Any, key: str) -> list[str]:
    """Return the list under ``key`` as texts (empty if absent); SstlError E604 if it is not a list."""
    return [str(v) for v in _typed(document, key, list, "a list") or []]


def numbers(document: Any, key: str) -> list[float]:
    """Return the list under ``key`` as numbers, NaN for nulls (empty if absent); SstlError E604 if not a list."""
    return [number(v) for v in _typed(document, key, list, "a list") or []]


def matrix(document: Any, key: str, rows_: int, columns: int) -> list[list[float]]:
    """Return a matrix of the given shape; SstlError E604 if the document's has another."""
    found = _typed(document, key, list, "a matrix") or []
    if len(found) != rows_ or any(not isinstance(r, list) or len(r) != columns for r in found):
        raise SstlError(
            f"'{key}' does not have {rows_} rows of {columns} columns",
            where=str(document.get("schema", "JSON document")),
            fix="one row and column for each label",
            code="E604",
        )
    return [[number(v) for v in row] for row in found]


def interval(value: Any) -> tuple[float, float]:
    """Return (low, high), NaN where the value is not a pair."""
    if isinstance(value, (list, tuple)) and len(value) == 2:
        return number(value[0]), number(value[1])
    return float("nan"), float("nan")


def share(value: Any) -> tuple[float, float, float, float]:
    """Return a proportion as (share, low, high, n), from a number or from {k, n, low, high}."""
    if not isinstance(value, dict):
        plain = number(value)
        return plain, plain, plain, float("nan")
    k, n = number(value.get("k")), number(value.get("n"))
    middle = k / n if n > 0 else number(value.get("share"))
    low, high = number(value.get("low")), number(value.get("high"))
    return middle, middle if math.isnan(low) else low, middle if math.isnan(high) else high, n


def _typed(document: Any, key: str, kind: type, name: str) -> Any:
    value = document.get(key) if isinstance(document, dict) else None
    if value is not None and not isinstance(value, kind):
        where = str(document.get("schema", "JSON document"))
        raise SstlError(f"'{key}' is not {name}", where=where, fix="make the file again with this version of sstl", code="E604")
    return value


def ambiguity_group(verdict: Mapping[str, Any]) -> tuple[str, ...]:
    """Return the effects of an ambiguity group, classes replaced by their members; what is no text is left out."""
    members = mapping(verdict, "members")
    return spelled_out({"ambiguity_group": texts(verdict, "ambiguity_group"), "members": {k: texts(members, k) for k in members}})
