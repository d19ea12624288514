"""Times that are written as text: how far they are apart, which tells the sampling period of a recording."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import date, datetime

import numpy as np
from numpy.typing import NDArray

from sstl_cli.core.units import is_unit, unit_of
from sstl_cli.importers.guess_words import UNIT_WORDS
from sstl_cli.importers.stamp_words import in_numbers

Array = NDArray[np.float64]
# of stamps, in usual steps: a longer one is a gap
GAP = 2.5
DAY_S, HOUR_S = 86_400.0, 3_600.0
# a number with its unit in one cell, as a table of times is written
_SPOKEN = re.compile(r"([+-]?\d+(?:[.,]\d+)?)\s*([^\W\d_]+)\.?")
# minutes and seconds as spreadsheets show them; a time of day would have no fraction there
MINUTES = re.compile(r"(\d{1,3}):(\d\d[.,]\d+)")
# a time of day, or one since the start; a date may stand in front of it; 14 h is none of the morning
CLOCK = re.compile(
    r"(?:(\d{1,4})([./-])(\d{1,2})\2(\d{1,4})(?:[T ]|, ?)\s*)?(?!(?:1[3-9]|2\d)\S*\s*a)(\d{1,3}):(\d\d):(\d\d(?:[.,:]\d+)?)(?:\s*([ap])\.?m\.?)?",
    re.IGNORECASE,
)
_OF_DAY = re.compile(r"\d:\d\d|\dT\d")
_DATE = re.compile(r"\s*\d+[./-]\d+[./-]\d")
# which of a date's three numbers are year, month and day
_YEAR_FIRST, _DAY_FIRST, _MONTH_FIRST = (0, 1, 2), (2, 1, 0), (2, 0, 1)


@dataclass(frozen=True)
class Stated:
    """A sampling period (s) that no channel of numbers tells, what does, how many steps are gaps (and the longest, s), what else it may mean, and whether it is the clock by definition."""

    step_s: float
    by: str = ""
    gaps: int = 0
    longest_s: float = 0.0
    doubt: str = ""
    sure: bool = False


def stamp_steps(texts: Sequence[str]) -> Stated | None:
    """Return the usual step of stamps written as dates with a time of day, as the latter alone, or as numbers with a unit of time; None where they are none.

    Examples
    --------
    >>> stamp_steps(["2024-03-05T14:02:11.000Z", "2024-03-05T14:02:11.020Z", "2024-03-05T14:02:11.040Z"]).step_s
    0.02
    """
    readings = [steps for seconds in _seconds(texts) if (steps := _steps(seconds)) is not None]
    if not readings:
        return None
    steps = min(readings, key=lambda s: float(s.sum()))
    usual = float(np.median(steps))
    gaps = steps[steps > GAP * usual]
    # stamps in whole ms say 12, 13, 12: the mean tells the step, over what is no gap
    step = float(f"{np.mean(steps[steps <= GAP * usual]):.9g}")
    either = any(not np.array_equal(steps, other) for other in readings)
    doubt = " over midnight, and which number is the day does not show" if either else ""
    return Stated(step, "", len(gaps), float(max(gaps, default=0.0)), doubt)


def dated(text: str) -> bool:
    """Return whether a stamp begins with a date."""
    return _DATE.match(text) is not None


def is_time_of_day(text: str) -> bool:
    """Return whether a text is a time of day, with or without its date, in a form that is known."""
    return _OF_DAY.search(in_numbers(text)) is not None and bool(_seconds([text]))


def between(first: str, second: str) -> float:
    """Return how much later (s) the second of two times is; of the readings of their dates the nearest, 0 where they cannot be compared.

    Examples
    --------
    >>> between("5/3/2024 2:05:06 PM", "5/3/2024 2:05:08 PM"), between("00:00:01", "23:59:59")
    (2.0, -2.0)
    """
    apart = min((float(s[1] - s[0]) for s in _seconds([first, second])), key=abs, default=0.0)
    # times alone are those of one night
    alone = not (dated(in_numbers(first)) or "T" in first)
    return apart - math.copysign(DAY_S, apart) if alone and abs(apart) > DAY_S / 2 else apart


def is_time(unit: str) -> bool:
    """Return whether a unit is one of time, however loggers write it."""
    known = UNIT_WORDS.get(unit.lower(), unit)
    return is_unit(known) and unit_of(known)[0] == "time"


def _steps(seconds: Array) -> Array | None:
    """Return the steps of stamps (s), None where they run back or mostly stand still."""
    steps = np.diff(seconds)
    # a time of day begins anew at midnight
    steps = np.where(steps < -DAY_S / 2, steps + DAY_S, steps)
    return steps if len(steps) and steps.min() >= 0.0 and np.median(steps) > 0.0 else None


def _seconds(texts: Sequence[str]) -> list[Array]:
    """Return stamps in s by each way to read them, an empty list where one is none."""
    texts = [t if CLOCK.fullmatch(t) else in_numbers(t) for t in map(str.strip, texts)]
    numbers = [_SPOKEN.fullmatch(t) for t in texts]
    spoken = [_number(m[1]) * unit_of(UNIT_WORDS.get(m[2].lower(), m[2]))[1] for m in numbers if m and is_time(m[2])]
    if len(spoken) == len(texts):
        return [np.array(spoken)]
    if all(minutes := [MINUTES.fullmatch(t) for t in texts]):
        shown = np.array([60.0 * int(m[1]) + _number(m[2]) for m in minutes if m])
        # they begin anew at the hour
        return [shown + HOUR_S * np.cumsum(np.diff(shown, prepend=shown[:1]) < -HOUR_S / 2)]
    clocks = [m for m in map(CLOCK.fullmatch, texts) if m]
    if len(clocks) == len(texts) and len({bool(m[1]) for m in clocks}) == 1:
        times = np.array([of_day(m) for m in clocks])
        return [days * DAY_S + times for days in _days(clocks)]
    try:
        # with a zone of time, or without colons; a time of day alone is that of any day
        stamps = [datetime.fromisoformat(t if "-" in t or "T" in t else f"2000-01-01T{t}") for t in texts]
        return [np.array([(t - stamps[0]).total_seconds() for t in stamps])]
    except (ValueError, TypeError):
        # TypeError: with a zone of time beside one without
        return []


def _number(text: str) -> float:
    return float(re.sub("[,:]", ".", text))


def of_day(clock: re.Match[str]) -> float:
    """Return the seconds that hours, minutes and seconds are."""
    hours, half = int(clock[5]), (clock[8] or "").lower()
    return 3600.0 * (hours % 12 + 12 * (half == "p") if half else hours) + 60.0 * int(clock[6]) + _number(clock[7])


def _days(clocks: list[re.Match[str]]) -> list[Array]:
    """Return the days of stamps by each order of year, month and day in which all of them are dates."""
    dates = [(m[1], m[3], m[4]) for m in clocks]
    if len(set(dates)) == 1:
        # within a day the order does not matter
        return [np.zeros(len(dates))]
    orders = date_orders(dates[0], clocks[0][2])
    out = []
    for year, month, day in orders:
        try:
            out.append(np.array([float(date(int(d[year]), int(d[month]), int(d[day])).toordinal()) for d in dates]))
        except ValueError:
            # no such date: it is not written in this order
            continue
    return [days - days[0] for days in out]


def date_orders(parts: Sequence[str], mark: str) -> list[tuple[int, int, int]]:
    """Return which of the three numbers of a date, with a mark between them, may be year, month and day."""
    first, _, last = parts
    if len(first) == 4:
        return [_YEAR_FIRST]
    if mark == ".":
        return [_DAY_FIRST]
    return [_DAY_FIRST, _MONTH_FIRST, *([] if len(last) == 4 else [_YEAR_FIRST])]
