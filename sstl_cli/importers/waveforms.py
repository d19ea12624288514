"""Waveforms as LabVIEW writes them into text: the start (t0) and the step (dt, delta t) of each channel in lines above the samples."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from sstl_cli.importers.instruments import Stated
from sstl_cli.importers.rates_said import LONGEST
from sstl_cli.importers.text_cells import is_number

Cut = Callable[[str], list[str]]
_START = re.compile(r"[\W_]*t_?0[\W_]*", re.IGNORECASE)
_STEP = re.compile(r"[\W_]*(?:d_?t|delta[ _]?t|Δt)[\W_]*", re.IGNORECASE)
# "# dt = 0.002" is one cell of a table cut at commas
_SPOKEN = re.compile(r"[\s#%/]*([A-Za-zΔ_ ]*[A-Za-z0])\s*[=:]\s*(\S.*)")
# the first cell above the numbers of the channels
WAVEFORM = "waveform"
# what is to be done about channels on clocks of their own
OWN = "give each channel a column of its time, or a file of its own"


@dataclass(frozen=True)
class Waveform:
    """The step (s) of a table without a clock (NaN: channels have clocks of their own), and what is to be asked, an empty text where nothing is."""

    step_s: float
    doubt: str = ""


def waveform(above: Sequence[str], cut: Cut) -> Waveform | None:
    r"""Return what the lines above a table tell of its steps, None where they tell none.

    Examples
    --------
    >>> waveform(["t0\t03.05.2024 14:05\t03.05.2024 14:05", "delta t\t0,01\t0,01"], lambda line: line.split("\t"))
    Waveform(step_s=0.01, doubt='')
    >>> waveform(["dt\t0.01\t0.02"], lambda line: line.split("\t")).doubt
    'steps of 0.01 and 0.02 s in one table: give each channel a column of its time, or a file of its own'
    """
    rows = [_row(line, cut) for line in above]
    steps = next((row[1:] for row in rows if _STEP.fullmatch(row[0])), [])
    starts = next((row[1:] for row in rows if _START.fullmatch(row[0])), [])
    numbers = sorted({_number(c) for c in steps if is_number(c)})
    if not numbers or numbers[0] <= 0.0:
        return None
    if len(numbers) > 1:
        return Waveform(math.nan, f"steps of {' and '.join(f'{n:g}' for n in numbers)} s in one table: {OWN}")
    begins = list(dict.fromkeys(filter(None, starts)))
    if len(begins) > 1:
        return Waveform(math.nan, f"channels begin at {' and '.join(begins[:2])}: {OWN}")
    return Waveform(numbers[0], "" if begins else "in s, as no unit stands there?")


def waveform_names(sample: list[str], cut: Cut) -> Stated | None:
    """Return the names in LabVIEW's first line where none stand directly above the samples, None where it is no such header."""
    rows = [cut(line) for line in sample]
    if not rows or rows[0][0].strip().lower() != WAVEFORM or not any(row[:1] and _STEP.fullmatch(row[0]) for row in rows if any(row)):
        return None
    names = rows[0][1:]
    at = next((i for i, row in enumerate(rows) if len(row) == len(names) and all(map(is_number, row))), 0)
    filled = next((row for row in reversed(rows[:at]) if any(row)), [""])
    return Stated(at, tuple(names), ("",) * len(names)) if at and _STEP.fullmatch(filled[0]) else None


def _row(line: str, cut: Cut) -> list[str]:
    spoken = _SPOKEN.fullmatch(line) if len(line) <= LONGEST else None
    if spoken and (_STEP.fullmatch(spoken[1]) or _START.fullmatch(spoken[1])):
        return [spoken[1], spoken[2].strip()]
    return cut(line.lstrip("#%/ ")) or [""]


def _number(cell: str) -> float:
    try:
        return float(cell.replace(",", "."))
    except ValueError:
        return math.nan
