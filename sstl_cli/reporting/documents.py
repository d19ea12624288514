"""Read JSON documents that may lack keys: a missing value is null, a wrong type is a clear error.

A document of the toolchain is strict where it is written (``core.documents``); a page shows those of older versions as well.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Annotated, NamedTuple, TypeVar

from pydantic import BaseModel, BeforeValidator, ConfigDict, ValidationError

from sstl_cli.core.errors import SstlError

NAN = float("nan")


class Shown(BaseModel):
    """A part of a document as it is shown: frozen, every field with what stands for its absence."""

    model_config = ConfigDict(frozen=True)


D = TypeVar("D", bound=Shown)


class Rate(NamedTuple):
    """A proportion with its interval and the cases that it is of; NaN where the document does not say."""

    share: float = NAN
    low: float = NAN
    high: float = NAN
    n: float = NAN


def number(value: object) -> float:
    """Return a finite number, or NaN for everything else."""
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
        return NAN
    return float(value)


def _text(value: object) -> str:
    return "" if value is None else str(value)


def _listed(value: object) -> Sequence[object]:
    if value is not None and not isinstance(value, (list, tuple)):
        raise ValueError("a list")
    return value or ()


def _numbers(value: object) -> tuple[float, ...]:
    return tuple(number(v) for v in _listed(value))


def _interval(value: object) -> tuple[float, float] | None:
    if value is None:
        return None
    found = _numbers(value) if isinstance(value, (list, tuple)) else ()
    return (found[0], found[1]) if len(found) == 2 else (NAN, NAN)


def _rate(value: object) -> Rate:
    """Return a proportion from a number or from {k, n, low, high}."""
    if not isinstance(value, dict):
        plain = number(value)
        return Rate(plain, plain, plain)
    k, n = number(value.get("k")), number(value.get("n"))
    middle = k / n if n > 0 else number(value.get("share"))
    low, high = number(value.get("low")), number(value.get("high"))
    return Rate(middle, middle if math.isnan(low) else low, middle if math.isnan(high) else high, n)


Number = Annotated[float, BeforeValidator(number)]
Text = Annotated[str, BeforeValidator(_text)]
Texts = Annotated[tuple[str, ...], BeforeValidator(lambda value: tuple(map(str, _listed(value))))]
Flag = Annotated[bool, BeforeValidator(lambda value: value is True)]
Numbers = Annotated[tuple[float, ...], BeforeValidator(_numbers)]
Matrix = Annotated[tuple[tuple[float, ...], ...], BeforeValidator(lambda value: tuple(map(_numbers, _listed(value))))]
Interval = Annotated[tuple[float, float] | None, BeforeValidator(_interval)]
Share = Annotated[Rate, BeforeValidator(_rate)]
# a list of parts, or a part, that may be null: ``Annotated[tuple[Row, ...], ROWS]``, ``Annotated[Part, PART]``
ROWS, PART = BeforeValidator(_listed), BeforeValidator(lambda value: {} if value is None else value)


def read(model: type[D], document: Mapping[str, object]) -> D:
    """Return a document as it is shown.

    Raises
    ------
    SstlError
        E604 where a field is of another kind than the page can show.
    """
    try:
        return model.model_validate(document)
    except ValidationError as error:
        first = error.errors()[0]
        path = ".".join(str(p) for p in first["loc"])
        # beside what the readers above say only an object can be missing
        wanted = str(first["ctx"]["error"]) if first["type"] == "value_error" else "an object"
        raise SstlError(
            f"'{path}' is not {wanted}",
            where=str(document.get("schema", "JSON document")),
            fix="make the file again with this version of sstl",
            code="E604",
        ) from None


def square(values: Matrix, rows: int, columns: int, name: str) -> Matrix:
    """Return a matrix that has a row and a column for each label; SstlError E604 if it has another shape."""
    if len(values) != rows or any(len(row) != columns for row in values):
        raise SstlError(
            f"'{name}' does not have {rows} rows of {columns} columns",
            where="JSON document",
            fix="one row and column for each label",
            code="E604",
        )
    return values
