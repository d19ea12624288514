"""Cells of a text log that cannot be read, and what to do about them."""

from __future__ import annotations

import re

from sstl_cli.importers.text_cells import GROUPED, MISSING, WITHOUT_MARKS, grouped_sign
from sstl_cli.importers.text_forms import WITHOUT_UNITS

OR_ELSEWHERE = "if this mark is the decimal one, it is another column that has marks between thousands"
# 2.03 lbf among numbers with another unit, or without
_UNITED = re.compile(r"[+-]?\d+(?:[.,]\d+)?\s*[^\W\d_]+")
AGAIN = "the header stands there again, as of a recorder that began anew"


def again(cells: list[str], names: tuple[str, ...]) -> str:
    """Return what to do about a row of names among the readings: that of the header, or one like it."""
    if cells == list(names):
        return f'{AGAIN}: write blocks = "runs" in [text] of the mapping, or split the file there'
    return "another header stands there: split the file there, as it needs a mapping of its own"


def blanks(cell: str) -> str:
    """Return a cell with plain blanks for those that do not break, as messages show it."""
    return re.sub(r"[\u00a0\u202f]", " ", cell)


def how_to_mend(cell: str) -> str:
    """Return what to do about a cell that is no number."""
    if GROUPED.fullmatch(cell.strip()):
        # 6,589 may be 6.589 where the marks between thousands are those of another column
        return WITHOUT_MARKS if grouped_sign(cell.strip()) or not re.search(r"[.,]", cell) else f"{WITHOUT_MARKS}; {OR_ELSEWHERE}"
    if _UNITED.fullmatch(cell.strip()):
        return WITHOUT_UNITS
    return "correct the value, or leave it empty for 'not measured'"


def readable(cell: str, decimal: str) -> bool:
    """Return whether a cell is a number with this decimal sign, or stands for none."""
    if cell in MISSING:
        return True
    if "_" in cell or (decimal == "," and "." in cell):
        return False
    try:
        float(cell.replace(decimal, "."))
    except ValueError:
        return False
    return True
