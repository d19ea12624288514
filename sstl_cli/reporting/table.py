"""Tables of the page: a caption, columns with units, rows of plain values."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from sstl_cli.core.errors import printable


@dataclass(frozen=True)
class Cell:
    """One cell: the text shown, and the number behind it where there is one (for sorting and CSV)."""

    text: str
    value: str = ""

    @property
    def numeric(self) -> bool:
        return bool(self.value)


@dataclass(frozen=True)
class Table:
    """A table that sorts and copies: caption, header of (name, unit), rows of cells."""

    caption: str
    header: list[tuple[str, str]]
    rows: list[list[Cell]]
    numeric: list[bool]


def table(caption: str, header: Sequence[Any], rows: Iterable[Sequence[Any]]) -> Table:
    """Return a table; numbers show four significant digits and keep their full value behind them.

    A heading is a name, or a pair of name and unit.

    Examples
    --------
    >>> table("t", ["run", ("rmse", "N")], [["a", 0.123456]]).rows[0][1]
    Cell(text='0.1235', value='0.123456')
    """
    heads = [(h, "") if isinstance(h, str) else h for h in header]
    cells = [[cell(v) for v in row] for row in rows]
    numeric = [any(r[i].numeric for r in cells) for i in range(len(heads))]
    return Table(caption, heads, cells, numeric)


def cell(value: Any) -> Cell:
    """Return one value as a cell: a dash for null or NaN, yes or no for truth values."""
    if value is None or value != value:
        return Cell("–")
    if isinstance(value, bool):
        return Cell("yes" if value else "no")
    if isinstance(value, int):
        return Cell(str(value), str(value))
    if isinstance(value, float):
        return Cell(f"{value:.4g}", repr(value))
    return Cell(printable(str(value)))
