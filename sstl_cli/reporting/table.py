"""Tables of the page: a caption, columns with units, rows of plain values."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import islice
from typing import Any

from sstl_cli.core.errors import printable

# a table of 200,000 rows makes a page of 85 MB, which no browser scrolls
MOST_ROWS = 2000


@dataclass(frozen=True)
class Cell:
    """One cell: the text shown, and the number behind it where there is one (for sorting and CSV)."""

    text: str
    value: str = ""
    href: str = ""

    @property
    def numeric(self) -> bool:
        return bool(self.value)


@dataclass(frozen=True)
class Table:
    """A table that sorts and copies: caption, header of (name, unit), rows of cells, and how many more there were."""

    caption: str
    header: list[tuple[str, str]]
    rows: list[list[Cell]]
    numeric: list[bool]
    more: int = 0


def table(caption: str, header: Sequence[Any], rows: Iterable[Sequence[Any]]) -> Table:
    """Return a table; numbers show four significant digits and keep their full value behind them.

    A heading is a name, or a pair of name and unit. Rows after the first ``MOST_ROWS`` are counted.

    Examples
    --------
    >>> table("t", ["run", ("rmse", "N")], [["a", 0.123456]]).rows[0][1]
    Cell(text='0.1235', value='0.123456', href='')
    """
    heads = [(printable(name), unit) for name, unit in ((h, "") if isinstance(h, str) else h for h in header)]
    left = iter(rows)
    cells = [[cell(v) for v in row] for row in islice(left, MOST_ROWS)]
    numeric = [any(r[i].numeric for r in cells) for i in range(len(heads))]
    return Table(caption, heads, cells, numeric, sum(1 for _ in left))


def cell(value: Any) -> Cell:
    """Return one value as a cell: a dash for null or NaN, yes or no for truth values."""
    if isinstance(value, Cell):
        return value
    if value is None or value != value:
        return Cell("–")
    if isinstance(value, bool):
        return Cell("yes" if value else "no")
    if isinstance(value, int):
        return Cell(str(value), str(value))
    if isinstance(value, float):
        return Cell(f"{value:.4g}", repr(value))
    if isinstance(value, dict):
        return Cell(printable(", ".join(f"{k} {cell(v).text}" for k, v in value.items())) or "–")
    if isinstance(value, (list, tuple)):
        return Cell(printable(", ".join(cell(v).text for v in value)) or "–")
    return Cell(printable(str(value)))


def probability(value: float) -> Cell:
    """Return a probability or an error: what is below a thousandth says so instead of showing an exponent."""
    return Cell("< 0.001", repr(value)) if 0 <= value < 0.001 else cell(value)


def loose(caption: str, found: Any, key: str = "name", unit: str = "N") -> Table | None:
    """Return a table of whatever a document holds: a list of objects, an object of objects, or of plain values.

    ``key`` heads the names of an object, ``unit`` is that of the fields ending in ``_n``; None where there is nothing.

    Examples
    --------
    >>> [[c.text for c in r] for r in loose("t", {"a": {"size": 0.5}, "b": {"size": None}}).rows]
    [['a', '0.5'], ['b', '–']]
    """  # noqa: RUF002
    if isinstance(found, dict):
        found = [{key: k, **(v if isinstance(v, dict) else {"value": v})} for k, v in found.items()]
    if not isinstance(found, list) or not found:
        return None
    lines = [f if isinstance(f, dict) else {key: f} for f in found]
    names = list(dict.fromkeys(k for line in lines for k in line))
    return table(caption, [_heading(n, unit) for n in names], ([line.get(n) for n in names] for line in lines))


def _heading(name: str, unit_n: str) -> tuple[str, str]:
    for end, unit in (("_n", unit_n), ("_pct", "%"), ("_s", "s"), ("_hz", "Hz"), ("_mm", "mm")):
        if name.endswith(end):
            return name.removesuffix(end).replace("_", " "), unit
    return name.replace("_", " "), ""
