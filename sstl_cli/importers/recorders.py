"""Headers of chart recorders and their like, which tell of all channels in lines of their own: AcqKnowledge, LabChart, Yokogawa; and tables of channels."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Sequence

from sstl_cli.core.units import unit_of
from sstl_cli.importers.guess_words import UNIT_CELLS, words
from sstl_cli.importers.instruments import Stated
from sstl_cli.importers.text_cells import is_missing, is_number

Cut = Callable[[str], list[str]]
# AcqKnowledge: "5 msec/sample", "3 channels", then name and unit of each in lines of their own
_STEP = re.compile(r"\s*(\d+(?:[.,]\d+)?(?:[eE][-+]?\d+)?) (min|sec|msec|usec)/sample")
_CHANNELS = re.compile(r"\s*(\d+) channels?\b")
_TIMES = {"min": "min", "sec": "s", "msec": "ms", "usec": "us"}
# in the first cell of a line, in small letters and without marks: what the line tells of each channel
TOLD_NAMES = words("tracename channeltitle channelname chname")
TOLD_UNITS = words("vunit unitname unit units yunit")
TOLD_RANGES, TOLD_STEPS, TOLD_RATES = words("range"), words("hresolution interval"), words("samplerate")
# of a table of channels (Graphtec, Hioki): what it lists, and which of its columns or lines names the signals
_LISTED, _SIGNALS = words("ch channel kanal tracename"), ("signal name", "signalname", "name", "label", "comment", "bezeichnung")


def recorder(sample: list[str], cut: Cut) -> Stated | None:
    """Return what the header of a chart recorder states, None where it is that of none of them."""
    return _acqknowledge(sample, cut) or _by_words(sample, cut)


def _acqknowledge(sample: list[str], cut: Cut) -> Stated | None:
    at = next((i for i, line in enumerate(sample[:5]) if _STEP.match(line)), None)
    if at is None or at + 1 >= len(sample) or not (counted := _CHANNELS.match(sample[at + 1])):
        return None
    many, step = int(counted[1]), _STEP.match(sample[at])
    pairs = [line.strip() for line in sample[at + 2 : at + 2 + 2 * many]]
    lines = at + 2 + 2 * many
    while lines < len(sample) and not sample[lines].strip():
        lines += 1
    titles = [c for c in cut(sample[lines]) if c] if lines < len(sample) else []
    lines += 1
    row = [c for c in cut(sample[lines]) if c] if lines < len(sample) else []
    # how many samples each channel has
    lines += len(row) == many < len(titles) or (len(row) == many and len(set(row)) == 1 and row[0].isdigit())
    if step is None or len(titles) not in (many, many + 1) or lines >= len(sample):
        return None
    size_s = _number(step[1]) * unit_of(_TIMES[step[2]])[1]
    timed = len(titles) > many
    clock = ("time",) if timed else ()
    unit = (_TIMES.get(titles[0].lower(), ""),) if timed else ()
    return Stated(lines, (*clock, *pairs[::2]), (*unit, *pairs[1::2]), size_s)


def _by_words(sample: list[str], cut: Cut) -> Stated | None:
    rows = [cut(line.lstrip().removeprefix("//")) for line in sample]
    told = {_word(row[0]): list(row[1:]) for row in rows if len(row) > 1 and not is_number(row[0]) and row[0]}
    names = next((told[w] for w in told if w in TOLD_NAMES), [])
    while names and not names[-1]:
        names = names[:-1]
    last = max((i for i, row in enumerate(rows) if row and _word(row[0]) in TOLD_NAMES), default=0)
    begin = next((i for i, row in enumerate(rows) if i > last and _is_reading(row)), None)
    if not names or begin is None:
        return None
    row = _without_last(rows[begin], len(names))
    if len(row) not in (len(names), len(names) + 1) or _names_of_its_own(rows[begin - 1], len(rows[begin])):
        return None
    units = next((told[w] for w in told if w in TOLD_UNITS), [])
    ranges = next((told[w] for w in told if w in TOLD_RANGES), [])
    units = units or [r.split()[-1] if r.split() else "" for r in ranges]
    front = len(row) - len(names)
    steps = {_number(c) for w in told if w in TOLD_STEPS for c in told[w][:1]} | {
        1.0 / r for w in told if w in TOLD_RATES for c in told[w][:1] if (r := _number(c)) > 0.0
    }
    steps = {s for s in steps if s > 0.0}
    step = min(steps) if steps and max(steps) < 1.001 * min(steps) else math.nan
    units = [UNIT_CELLS.get(u.lower(), u) for u in (*units, *[""] * len(names))][: len(names)]
    empty = is_missing(row[0])
    clock = "col1" if empty else "time"
    return Stated(begin, (*[clock] * front, *names), (*["" if empty else "s"] * front, *units), step)


def _without_last(row: list[str], named: int) -> list[str]:
    """Return a row without the empty cells that a separator at its end leaves, where that in front leaves one as well or none stands there."""
    least = named + is_missing(row[0])
    while len(row) > least and is_missing(row[-1]):
        row = row[:-1]
    return row


def _names_of_its_own(row: list[str], width: int) -> bool:
    """Return whether the row above the readings names the columns, and does not tell something else of each channel."""
    tells = row[0].endswith(("=", ":")) or _word(row[0]) in TOLD_NAMES | TOLD_UNITS | TOLD_RANGES | TOLD_STEPS | TOLD_RATES
    return len(row) == width and all(row) and not any(map(is_number, row)) and not tells


def _is_reading(row: list[str]) -> bool:
    """Return whether a row holds numbers alone, or none in its first cell."""
    return len(row) > 1 and all(is_number(c) or is_missing(c) for c in row) and any(map(is_number, row[1:]))


def signal_names(above: Sequence[str], names: Sequence[str], cut: Cut) -> dict[str, str]:
    """Return what a table of channels above the data calls the signals, by the names of their columns.

    Parameters
    ----------
    above : sequence of str
        The lines above the data.
    names : sequence of str
        Names of the columns, of which a unit in brackets is none of the channel.
    """
    plain = {re.sub(r"\s*[\[(].*", "", n): n for n in names}
    rows = [cut(line.lstrip().removeprefix("//")) for line in above]
    out: dict[str, str] = {}
    for i, row in enumerate(rows):
        if len(row) < 2 or row[0].lower() not in _LISTED:
            continue
        if at := next((k for k, c in enumerate(row) if k and c.lower() in _SIGNALS), 0):
            out |= {plain[r[0]]: r[at] for r in rows[i + 1 :] if len(r) > at and r[0] in plain and r[at] and r[0] != names[0]}
        elif (labels := next((r for r in rows[i + 1 :] if r and r[0].lower() in _SIGNALS), None)) and set(filter(None, row[1:])) <= set(
            plain
        ):
            out |= {plain[c]: label for c, label in zip(row[1:], labels[1:], strict=False) if c and label}
    return {n: label for n, label in out.items() if label != n and not is_number(label)}


def _word(cell: str) -> str:
    return re.sub(r"[^a-z]", "", cell.lower())


def _number(cell: str) -> float:
    found = re.match(r"\s*[-+]?\d+(?:[.,]\d+)?(?:[eE][-+]?\d+)?", cell)
    return float(found[0].replace(",", ".")) if found else math.nan
