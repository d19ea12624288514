"""Headers that instruments write in lines of their own, each of which begins with what it tells: ControlDesk, TwinCAT's scope and LabVIEW."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import pairwise

# an oscilloscope's lines: the unit of what is recorded over, and of each channel
HORIZONTAL_UNITS, VERTICAL_UNITS = "Horizontal Units", "Vertical Units"
LABVIEW_STARTS = ("X0", "Date", "Time")
Cut = Callable[[str], list[str]]
# ControlDesk writes this line before its readings; the clock, in s, comes first and has no name
READINGS, NAMES, UNITS = "trace_values", "trace_name", "unit"
# where it leaves the names out, the places of the traces in the model end in them, or in a port of the block that has them
PATHS = "path"
_PORT = re.compile(r"(?:Out|In)\d*")
# the lines of TwinCAT's scope, in pairs of a word and what it says of a channel; each channel has a clock of its own
SCOPE_NAMES, SCOPE_UNITS, SCOPE_LEAST = "Name", "Unit", 3
CLOCK_MS = "ms"
# LabVIEW's lines: the units of the channels, what they are recorded over, and the step of that; one column for it comes first, which may be empty
LABVIEW_UNITS, LABVIEW_OVER, LABVIEW_STEP, LABVIEW_COLUMNS = "Y_Unit_Label", "X_Dimension", "Delta_X", "X_Columns"


@dataclass(frozen=True)
class Stated:
    """Number of lines that a header takes, the names and units of the columns behind it, and the step (s) of their clock, NaN where it says none."""

    lines: int
    names: tuple[str, ...]
    units: tuple[str, ...]
    step_s: float = math.nan


def stated_by(sample: list[str], cut: Cut) -> Stated | None:
    """Return what the header of an instrument states, None where it is that of none of them."""
    return _control_desk(sample, cut) or _scope(sample, cut)


def _control_desk(sample: list[str], cut: Cut) -> Stated | None:
    rows = [cut(line) for line in sample]
    end = next((i for i, row in enumerate(rows) if row and row[0] == READINGS), None)
    if end is None:
        return None
    told = {row[0]: tuple(row[1:]) for row in rows[:end] if row}
    names = told.get(NAMES) or _ends(told.get(PATHS, ()))
    if not names:
        return None
    units = (*told.get(UNITS, ()), *[""] * len(names))[: len(names)]
    # with readings behind the word, the line is the first of them
    return Stated(end + (not any(map(_is_number, rows[end][1:]))), ("time", *names), ("s", *units))


def _ends(paths: tuple[str, ...]) -> tuple[str, ...]:
    """Return the last parts of paths; the whole ones where two end alike, as then something before the end tells them apart."""
    cut = [p.split("/") for p in paths]
    ends = tuple("/".join(parts[-2:] if _PORT.fullmatch(parts[-1]) else parts[-1:]) for parts in cut)
    return ends if len(set(ends)) == len(ends) else paths


def _scope(sample: list[str], cut: Cut) -> Stated | None:
    # the file's own lines stand in a block of their own in front
    starts = [0, *(i + 1 for i, line in enumerate(sample) if not line.strip())]
    found = ((start, _scope_at(sample[start:], cut)) for start in starts)
    blocks = [replace(block, lines=start + block.lines) for start, block in found if block is not None]
    # the lines of the file itself may look like those of a channel: the readings stand below the channels'
    return next((b for b in blocks if b.lines < len(sample) and any(map(_is_number, cut(sample[b.lines])))), None)


def _scope_at(sample: list[str], cut: Cut) -> Stated | None:
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
    units = [*(u.strip("[]() ") for u in told.get(SCOPE_UNITS, [])), *[""] * len(names)]
    lines = len(rows)
    while lines < len(sample) and not sample[lines].strip():
        lines += 1
    pairs = [("time", CLOCK_MS, name, unit) for name, unit in zip(names, units, strict=False)]
    return Stated(lines, tuple(v for p in pairs for v in (p[0], p[2])), tuple(v for p in pairs for v in (p[1], p[3])))


def _is_reading(cell: str) -> bool:
    return not cell or cell[0].isdigit() or cell[0] in "+-.,"


@dataclass(frozen=True)
class Measured:
    """What LabVIEW's header says of the columns behind it: their units, the step (s) of their clock (NaN: none), and where not all begin together, when they do."""

    units: tuple[str, ...] = ()
    step_s: float = math.nan
    starts: str = ""


def labview(header: list[str], cut: Cut) -> Measured:
    """Return units and sampling period from the lines of LabVIEW's header, no period where each channel has a clock of its own."""
    told = {row[0]: row[1:] for line in header if (row := cut(line))}
    over = told.get(LABVIEW_OVER, [])
    timed = bool(over) and set(over) - {""} == {"Time"}
    if told.get(LABVIEW_COLUMNS, [""])[:1] == ["Multi"]:
        # clock and readings take turns, and the cells of the header stand over the readings
        cells = ("", *told.get(LABVIEW_UNITS, []))
        return Measured(tuple("s" if timed and i % 2 == 0 else c for i, c in enumerate(cells)), starts=_starts(told))
    steps = {_number(v) for v in told.get(LABVIEW_STEP, []) if v} if timed else set()
    step = steps.pop() if len(steps) == 1 else math.nan
    return Measured(("s" if timed else "", *told.get(LABVIEW_UNITS, [])), step if step > 0.0 else math.nan, _starts(told))


def _starts(told: dict[str, list[str]]) -> str:
    """Return that channels of LabVIEW begin at different times, from which the times of each count; an empty text where they do not."""
    differ = {word: begins for word in LABVIEW_STARTS if len(begins := list(dict.fromkeys(filter(None, told.get(word, []))))) > 1}
    word = "Time" if "Time" in differ else next(iter(differ), "")
    return f"channels begin at {word} {' and '.join(differ[word][:2])}" if differ else ""


def oscilloscope(header: list[str], cut: Cut) -> tuple[str, ...]:
    """Return the units of the columns that an oscilloscope's settings state, none where they state none."""
    told = {row[0]: row[1:] for line in header if (row := cut(line))}
    return (*told.get(HORIZONTAL_UNITS, ["s"])[:1], *told[VERTICAL_UNITS]) if VERTICAL_UNITS in told else ()


def step_below(rows: list[list[str]]) -> float:
    """Return the step (s) that stands below the name of a column (``Increment``), NaN where none does."""
    for names, values in pairwise(rows):
        for name, value in zip(names, values, strict=False):
            if name.strip().lower() in ("increment", "tinc") and _number(value) > 0.0:
                return _number(value)
    return math.nan


def _is_number(cell: str) -> bool:
    return math.isfinite(_number(cell))


def _number(cell: str) -> float:
    try:
        return float(cell.replace(",", "."))
    except ValueError:
        return math.nan
