"""Columns of a text log whose mark may stand between thousands: 5.123 is 5123 where a German program wrote it."""

from __future__ import annotations

import re
from dataclasses import replace
from itertools import islice
from pathlib import Path

import numpy as np

from sstl_cli.core.units import unit_of
from sstl_cli.importers.guess_names import Said
from sstl_cli.importers.guess_time import LIKELY_STEP_S
from sstl_cli.importers.text import first_rows
from sstl_cli.importers.text_cells import grouped_sign, is_missing
from sstl_cli.importers.text_forms import is_united

# as many as a first look takes
ROWS = 20_000
# no leading zero, and three digits behind the one mark; smaller numbers have none
_GROUPED = re.compile(r"[+-]?[1-9]\d{0,2}([.,])\d{3}")
_SMALL = re.compile(r"[+-]?\d{1,3}")
_MARKED = re.compile(r"[+-]?\d+([.,])\d+")
_DECIMAL = re.compile(r".*:\d\d[.,]\d+.*|[+-]?(?:0\d*[.,]\d+|\d{4,}[.,]\d*|\d*[.,](?:\d{0,2}|\d{4,}))(?:[eE][+-]?\d+)?")
# of so many cells with a mark on, their three digits are no chance
LEAST = 3
# more than a steel tendon of 1 mm holds
MANY_N = 3_000.0
# in these, thousands of them are usual
SMALL_UNITS = ("mN", "uN", "gf", "g", "cN")
AS_THOUSANDS = "then write numbers without marks between thousands"


def with_marks(path: Path, names: list[Said]) -> list[Said]:
    """Return what the names of a text log's columns say, with a question where the mark in a column may stand between thousands.

    It may where another column holds the other mark as a decimal one, where other numbers of the column are whole, where no cell
    of the file shows that it is a decimal one, and in units of which a tendon has thousands.
    """
    columns = _columns(path)
    shapes = {n: _shape(cells, 1 if any(map(_SMALL.fullmatch, cells)) else LEAST) for n, cells in columns.items()}
    plain = {m[1]: c for n, cells in columns.items() if not shapes[n] for c in cells if (m := _MARKED.fullmatch(c))}
    # 0,125, 12,5, 1234,5 and 14:05:06,120 hold a decimal mark
    decimal = any(_DECIMAL.fullmatch(c) for cells in columns.values() for c in cells)
    decimal = decimal or any(_ticks(s, columns[s.name]) for s in names if shapes.get(s.name) and s.dimension == "time")
    out = []
    for one in names:
        cell = shapes.get(one.name, "")
        other = plain.get("," if "." in cell else ".", "") if cell else ""
        whole = next(filter(_SMALL.fullmatch, columns[one.name]), "") if cell else ""
        small = one.unit in SMALL_UNITS or one.dimension == "count"
        if other:
            one = asking(one, f"it holds {cell!r} beside {other!r} in the same file: is it {_without(cell)}? {AS_THOUSANDS}")
        elif whole:
            one = asking(one, f"it holds {cell!r} beside {whole!r}: is it {_without(cell)}? {AS_THOUSANDS}")
        elif cell and (small or (not decimal and _can_be(one, columns[one.name]))):
            one = asking(one, f"every mark has three digits behind it: is {cell!r} {_without(cell)}? {AS_THOUSANDS}")
        out.append(one)
    return out


def grouped_cell(path: Path, name: str) -> str:
    """Return the first cell of a column of text that is a number with a mark between its thousands and a decimal one, an empty text where none is."""
    cell = next((c for c in _columns(path).get(name, []) if grouped_sign(c)), "")
    return re.sub(r"[\u00a0\u202f\u2009]", " ", cell)


def two_units(path: Path, name: str) -> tuple[str, str] | None:
    """Return the first two cells of a column with another unit behind their numbers, None where there are none."""
    first: dict[str, str] = {}
    for cell in _columns(path).get(name, []):
        if is_united(cell):
            first.setdefault(re.sub(r"^[^A-Za-z%°]*", "", cell), cell)
    cells = list(first.values())
    return (cells[0], cells[1]) if len(cells) > 1 else None


def thousands(path: Path) -> tuple[str, str]:
    """Return a column, and a cell of it, whose mark stands between thousands: smaller numbers of it have none. Two empty texts where there is none."""
    for name, cells in _columns(path).items():
        if (cell := _shape(cells)) and any(_SMALL.fullmatch(c) for c in cells):
            return name, cell
    return "", ""


def asking(one: Said, question: str) -> Said:
    """Return what a name says with another question behind those that its file raises."""
    return replace(one, doubt="; ".join(filter(None, (one.doubt, question))))


def _columns(path: Path) -> dict[str, list[str]]:
    """Return the first cells of each column that are not missing."""
    names, rows = first_rows(path)
    table = [row for row in islice(rows, ROWS) if len(row) == len(names)]
    return {n: [row[i] for row in table if not is_missing(row[i])] for i, n in enumerate(names)}


def _shape(cells: list[str], least: int = LEAST) -> str:
    """Return the first cell with a mark where all of a column may be numbers with marks between thousands, else an empty text."""
    marked = [(c, m[1]) for c in cells if (m := _GROUPED.fullmatch(c))]
    whole = all(_GROUPED.fullmatch(c) or _SMALL.fullmatch(c) for c in cells)
    return marked[0][0] if whole and len(marked) >= least and len({m for _, m in marked}) == 1 else ""


def _can_be(one: Said, cells: list[str]) -> bool:
    """Return whether the readings of a force can be those of a tendon with the marks between thousands."""
    most = max(abs(float(_without(c))) for c in cells)
    return one.dimension == "force" and most * unit_of(one.unit)[1] <= MANY_N


def _ticks(clock: Said, cells: list[str]) -> bool:
    """Return whether a clock has the step of a logger with its marks as decimal ones, and a step that none has with marks between thousands."""
    read, size = [float(c.replace(",", ".")) for c in cells], unit_of(clock.unit)[1]
    step = size * float(np.median(np.diff(read))) if len(read) > 1 else 0.0
    return LIKELY_STEP_S[0] <= step <= LIKELY_STEP_S[1] < 1000.0 * step


def _without(cell: str) -> str:
    return re.sub(r"[.,]", "", cell)
