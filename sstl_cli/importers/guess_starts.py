"""When recordings began, as lines above their tables say it: two zero-based clocks of one test need not have one zero."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping

from sstl_cli.importers.guess_stamps import between, is_time_of_day
from sstl_cli.importers.guess_words import QUANTITY_OF, unaccented, words

# Start: 2024-05-03 14:05:06; Time;2:05:06 PM; recorded 14:05:06
_LINE = re.compile(r"\W*([^\W\d][^:=;,\t\d]*?)\s*[:=;,\t][\s\"]*([^\s\"].*?)[\s\";,]*$")
_SPOKEN = re.compile(r"\W*([^\W\d]\D*?)\W+(\d.*?)[\s\";,]*$")
# how a line says that a recording began then, beside words for time itself
_BEGUN = words(
    "start started starts begin began begins beginn beginning anfang debut inicio inizio recorded recording acquired acquisition test run measured"
)
# of another time than that of the first sample
_OTHER = words(
    "end ended stop stopped finish finished saved export exported calibration calibrated cal due modified printed expires duration length zone"
)
_DATES = words("date datum fecha data day tag")


def starts_said(remarks: Iterable[str]) -> dict[str, str]:
    """Return the times that remarks tell of a recording's begin, by what stands in front of each; a date and a time in lines of their own are one.

    Examples
    --------
    >>> starts_said(["Date: 5/3/2024", "Time: 2:05:08 PM", "Gauge: M5-10"])
    {'time': '5/3/2024 2:05:08 PM'}
    >>> starts_said(["# Start: 2024-05-03T14:05:08.000", "# calibrated: 2024-01-02 10:00:00"])
    {'start': '2024-05-03T14:05:08.000'}
    """
    found: dict[str, str] = {}
    day = ""
    for line in remarks:
        said = [m for m in (_LINE.fullmatch(line), _SPOKEN.fullmatch(line)) if m]
        for key, text in ((unaccented(m[1]).lower(), m[2].strip()) for m in said):
            named = set(re.findall(r"[^\W\d_]+", key))
            if named & _OTHER or not (named & _BEGUN or any(QUANTITY_OF.get(w) == "time" for w in named)):
                continue
            if named & _DATES and not is_time_of_day(text):
                day = text
            elif is_time_of_day(text):
                found.setdefault(key, text)
                break
    return {key: f"{day} {text}" if day and is_time_of_day(f"{day} {text}") else text for key, text in found.items()}


def begun_apart(first: Mapping[str, str], second: Mapping[str, str]) -> tuple[float, str]:
    """Return how much later (s) the second of two recordings began than the first, and the two lines that say so; 0 and an empty text where none does."""
    for key in first:
        texts = [first[key], second.get(key, first[key])]
        apart = between(*texts)
        if apart:
            return apart, f"'{texts[0]}' and '{texts[1]}'"
    return 0.0, ""
