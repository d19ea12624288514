"""Headers that instruments write in lines of their own, each of which begins with what it tells: ControlDesk and TwinCAT's scope."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

Cut = Callable[[str], list[str]]
# ControlDesk writes this line before its readings; the clock, in s, comes first and has no name
READINGS, NAMES, UNITS = "trace_values", "trace_name", "unit"
# the lines of TwinCAT's scope, in pairs of a word and what it says of a channel; each channel has a clock of its own
SCOPE_NAMES, SCOPE_UNITS, SCOPE_LEAST = "Name", "Unit", 3
CLOCK_MS = "ms"


@dataclass(frozen=True)
class Stated:
    """Number of lines that a header takes, and the names and units of the columns behind it."""

    lines: int
    names: tuple[str, ...]
    units: tuple[str, ...]


def stated_by(sample: list[str], cut: Cut) -> Stated | None:
    """Return what the header of an instrument states, None where it is that of none of them."""
    return _control_desk(sample, cut) or _scope(sample, cut)


def _control_desk(sample: list[str], cut: Cut) -> Stated | None:
    rows = [cut(line) for line in sample]
    end = next((i for i, row in enumerate(rows) if row and row[0] == READINGS), None)
    if end is None:
        return None
    told = {row[0]: tuple(row[1:]) for row in rows[:end] if row}
    names = told.get(NAMES, ())
    if not names:
        return None
    units = (*told.get(UNITS, ()), *[""] * len(names))[: len(names)]
    return Stated(end + 1, ("time", *names), ("s", *units))


def _scope(sample: list[str], cut: Cut) -> Stated | None:
    rows: list[list[str]] = []
    for line in sample:
        row = cut(line)
        # a word in front of every channel, the same all along the line
        if not line.strip() or len(row) < 2 or len(set(row[::2]) - {""}) != 1 or _is_reading(row[0]):
            break
        rows.append(row)
    told = {row[0]: row[1::2] for row in rows}
    names = told.get(SCOPE_NAMES, [])
    if len(rows) < SCOPE_LEAST or not names or not all(names):
        return None
    units = [*told.get(SCOPE_UNITS, []), *[""] * len(names)]
    lines = len(rows)
    while lines < len(sample) and not sample[lines].strip():
        lines += 1
    pairs = [("time", CLOCK_MS, name, unit) for name, unit in zip(names, units, strict=False)]
    return Stated(lines, tuple(v for p in pairs for v in (p[0], p[2])), tuple(v for p in pairs for v in (p[1], p[3])))


def _is_reading(cell: str) -> bool:
    return not cell or cell[0].isdigit() or cell[0] in "+-.,"
