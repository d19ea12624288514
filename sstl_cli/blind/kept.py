"""The rows of a diagnosis as they are kept with its result: whoever has other weights can judge the case by them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, fields
from math import isfinite
from typing import Any

from sstl_cli.diagnosis.features import CandidateRow, LogRow, Rows
from sstl_cli.diagnosis.residuals import Leftover, Misfit


def to_document(rows: Rows) -> dict[str, Any]:
    """Return rows as a result keeps them: of what base and best model leave, the worst test alone.

    Examples
    --------
    >>> from sstl_cli.diagnosis.features import OUTPUT
    >>> c = CandidateRow(("slack",), OUTPUT, 1, 40.0, 35.0, 35.0, 1.0, 2.0, 1.0, 0, float("inf"), 0.9)
    >>> left = Leftover(100, 1.0, 0.0, 3.0, 0.0, (Misfit("mean", 2.0, 0.0, ""),))
    >>> rows = Rows(LogRow(100, 1, 2, 1.5, 9.0, 8.0, 1.0, 2.0, 1.0, 0.0, 3.0, 0.0, 0.0, 0.1, 1.0, 1.0), (c,), left, left)
    >>> to_document(rows)["candidates"][0]["unstable"]
    'inf'
    >>> from_document(to_document(rows)) == rows
    True
    """
    document = asdict(rows)
    for name in ("base", "best"):
        document[name]["tests"] = [asdict(getattr(rows, name).worst())]
    plain: dict[str, Any] = _plain(document)
    return plain


def from_document(document: Mapping[str, Any]) -> Rows:
    """Return the rows that a result keeps."""
    base, best = (
        Leftover(**{**_numbers(Leftover, document[n]), "tests": tuple(Misfit(**_numbers(Misfit, t)) for t in document[n]["tests"])})
        for n in ("base", "best")
    )
    candidates = tuple(CandidateRow(**{**_numbers(CandidateRow, c), "ids": tuple(c["ids"])}) for c in document["candidates"])
    return Rows(LogRow(**_numbers(LogRow, document["log"])), candidates, base, best, dict(document["barred"]), document["scatters"])


def _plain(value: Any) -> Any:
    """Return a value that JSON holds: what is not finite as text."""
    if isinstance(value, Mapping):
        return {k: _plain(v) for k, v in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(v) for v in value]
    if isinstance(value, float) and not isfinite(value):
        return str(value)
    return value


def _numbers(kind: Any, part: Mapping[str, Any]) -> dict[str, Any]:
    """Return the fields of a row, numbers that are not finite read back."""
    real = {f.name for f in fields(kind) if f.type in ("float", "float | None")}
    return {k: float(v) if k in real and isinstance(v, str) else v for k, v in part.items()}
