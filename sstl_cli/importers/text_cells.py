"""Cells of a line of text: how a line is cut, which of them are numbers, and which stand for none."""

from __future__ import annotations

import contextlib
import csv
import re

SPACES = "space"
# as typesetters write it
MINUS = "\u2212"
_NUMBER = re.compile(r"[+-]?(\d+([.,]\d*)?|[.,]\d+)([eE][+-]?\d+)?$")
WITHOUT_MARKS = "write numbers without marks between thousands"
# 1.234,56, 1 234,56, 1'234.56 or 1,234.56; the apostrophe may be a typographic one, also as Windows writes it
GROUPED = re.compile(r"[+-]?\d{1,3}(?:([.,'\u2019\u0092\s\u00a0\u202f])\d{3})(?:\1\d{3})*(?:[.,]\d*)?")
MISSING = ("", "NA", "N/A", "#N/A", "NaN", "nan", "NAN", "-nan", "-NaN", "null", "NULL", "None", "1.#QNAN", "-1.#IND", "nan(ind)")
_MISSING = {m.lower() for m in MISSING} | {"inf", "-inf", "+inf"}


def cut(line: str, delimiter: str) -> list[str]:
    """Return the cells of a line, without the blanks and quotes around them."""
    cells = line.split() if delimiter == SPACES else line.split(delimiter)
    if '"' in line and delimiter != SPACES:
        with contextlib.suppress(csv.Error):
            # a delimiter between quotes is text
            return [c.strip() for c in next(csv.reader([line], delimiter=delimiter, skipinitialspace=True), [""])]
    return [c.strip().strip('"').strip() for c in cells]


def is_number(cell: str) -> bool:
    """Return whether a cell is a number, with either decimal sign."""
    return bool(_NUMBER.match(cell.strip()))


def grouped_sign(cell: str) -> str:
    """Return the decimal sign of a number that has another mark between its thousands, '' where it is no such number."""
    found = GROUPED.fullmatch(cell)
    # 1.234 alone is a number; the last mark of 1.234,5 is another one
    sign = re.findall(r"\D", cell)[-1] if found else ""
    return sign if found and sign != found[1] else ""


def marks_known(cell: str) -> tuple[str, str]:
    """Return the mark between the thousands of a number and its decimal sign (empty: none) where it shows which is which, two empty texts where it does not.

    Examples
    --------
    >>> marks_known("1.234,5"), marks_known("1'234"), marks_known("1,234,567"), marks_known("1,234")
    (('.', ','), ("'", ''), (',', ''), ('', ''))
    """
    found = GROUPED.fullmatch(cell)
    if found is None or (found[1] in ".," and not grouped_sign(cell) and cell.count(found[1]) == 1):
        # 1,234 may be 1234 or 1.234
        return "", ""
    return found[1], grouped_sign(cell)


def is_missing(cell: str) -> bool:
    """Return whether a cell says that there is no number."""
    return cell.strip().lower() in _MISSING
