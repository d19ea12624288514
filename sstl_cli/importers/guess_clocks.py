"""Several clocks in one file: equal ones are one clock; of others each tension gets the one in front of it, or is asked."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from sstl_cli.core.units import unit_of
from sstl_cli.importers.bags import TIME
from sstl_cli.importers.guess_epochs import is_epoch
from sstl_cli.importers.guess_names import Said, time_unit
from sstl_cli.importers.guess_time import MARK, SAME_RATE, TimeGuess, counts, even, repeats, runs_forward, trimmed
from sstl_cli.importers.guess_words import QUANTITY_OF

Array = NDArray[np.float64]
# columns called by a unit of time and nothing else; s may be a way
_WHOLE = {"ms": "ms", "us": "us", "µs": "us", "μs": "us"}
# of a step, how far equal clocks may lie apart where they are written with other places
SAME_STEP = 0.01
# of a topic of a robot's log, beside when its messages came: when they were sent
STAMP = ".header.stamp"
# of two clocks of which one states no unit: either may have the larger one
_UNITS = np.array([1.0, 60.0, 1e3, 3600.0, 6e4, 86_400.0, 1e6, 3.6e6, 6e7, 8.64e7, 1e9, 3.6e9, 8.64e10])
FACTORS = np.concatenate([_UNITS, 1.0 / _UNITS])


@dataclass(frozen=True)
class Clocks:
    """The clock of a file, and of channels that have another one: that one by the channel's name."""

    time: TimeGuess
    own: Mapping[str, TimeGuess] = field(default_factory=dict)


def clock_if_forward(one: Said, values: Array | None) -> Said:
    """Return ``t_in``, ``tick_ms``, or what is named as time and force, as a clock where it runs forward, and as what it may also be where it does not."""
    # a device's own clock may be called by its unit alone, or by what it counts
    unit = time_unit(one.name) or _WHOLE.get(one.name.strip().lower(), "")
    if values is None or one.strange or not runs_forward(values := trimmed(values)):
        return one
    if unit and one.dimension in ("", "count") and one.quantity in ("other", "index", "force", "") and even(values):
        # cpu_ms and adc_ms: whatever they are of, ticks that run on evenly in a unit of time are a clock
        return replace(one, quantity="time", unit=unit)
    if one.words in (("tick",), ("ticks",)) and even(values) and not counts(values):
        return replace(one, quantity="time")
    if one.quantity not in ("", "force") or one.unit:
        return one
    short = one.words[:1] in (("t",), ("ts",)) or re.fullmatch(r"(?:.*[./])?t_?(?:in|out)", one.name, re.IGNORECASE)
    # "Time - Load Cell Motor" is the clock of that load cell
    named = one.quantity == "force" and any(QUANTITY_OF.get(w) == "time" and len(w) > 1 for w in one.words)
    if named or (short and one.side) or (unit and even(values) and short):
        return replace(one, quantity="time", unit=unit)
    return one


def own_time(clock: TimeGuess) -> str:
    """Return the keys of a source that name a clock of its own, an empty text where it is no channel."""
    if clock.channel is None:
        return ""
    unit, scale = re.search(r'unit = "(\w+)"', clock.line), re.search(r"scale = ([^ ,}]+)", clock.line)
    tail = f", time_scale = {scale[1]}" if scale else ""
    if clock.fraction:
        tail += "".join(f", {m[0]}" for m in re.finditer(r'fraction(?:_unit)? = "[^"]*"', clock.line))
    return f'time = {json.dumps(clock.channel, ensure_ascii=False)}, time_unit = "{unit[1] if unit else "s"}"{tail}'


def with_own_clocks(
    names: Sequence[Said], data: dict[str, Array], time: TimeGuess, used: Sequence[str], ordered: bool, one: Callable[[Said], TimeGuess]
) -> Clocks:
    """Return the clock of a file and those of single channels, where it has clocks that differ.

    Parameters
    ----------
    names : sequence of Said
        The numeric channels in the order of the file.
    data : dict
        First samples of each channel, shape (n,).
    time : TimeGuess
        The clock of the file by its name.
    used : sequence of str
        Channels of the input and the output tension, the input's first.
    ordered : bool
        Whether the file is a table whose columns stand as they were written.
    one : callable
        What a channel is as the only clock of the file.
    """
    clocks = [s for s in names if _is_clock(s, data)]
    chosen = next((s for s in names if s.name == time.channel), None)
    if chosen is None:
        return Clocks(time)
    clocks = clocks if chosen in clocks else [chosen, *clocks]
    # beside a clock of the whole, what is of a side and holds its value over most samples is a temperature
    clocks = [s for s in clocks if chosen.side or not s.side or repeats(data[s.name]) <= 0.5]
    others = [s for s in clocks if s is not chosen]
    # a coarse copy of the clock, such as minutes with two places, is no other one
    fine = all((np.diff(trimmed(data[s.name])) > 0).all() for s in clocks)
    # elapsed and unix time tell the same row, wherever they stand, unless each is of a side by its name
    meet = len({is_epoch(data[s.name]) for s in clocks}) == 1
    theirs = (_of_sides(names, clocks) or (_in_front(names, clocks) if ordered and meet else {})) if others and fine else {}
    if theirs:
        base = theirs.get(used[0], chosen) if used else chosen
        time = time if base is chosen else one(base)
        mapped = {s.name for s in names if s.name in used or s.quantity in ("position", "force")}
        own = {n: s for n, s in theirs.items() if n in mapped and s is not base and not _equal(base, s, data)}
        told = {n: _asked(one(s), base, s, data) for n, s in own.items()}
        if told:
            shown = ", ".join(f"'{n}' with '{s.name}'" for n, s in own.items())
            return Clocks(replace(time, reasons=(*time.reasons, f"clocks that differ, each of its own channels: {shown}")), told)
        # what has no clock of its own is asked below where the clocks are not one
        others = [] if used and set(used) <= set(theirs) else others
    apart = next((s for s in others if _apart(chosen, s, data, meet) and _fits(s, used, data)), None)
    apart = apart or next((s for s in names if _runs_beside(s, chosen, data) and s not in clocks), None)
    if apart is None:
        return Clocks(time)
    ask = f"'{apart.name}' is another clock: whose? for a channel of its own clock add {own_time(one(apart)) or 'time'} to its line"
    body, _, question = time.line.partition(MARK)
    return Clocks(replace(time, line=body + MARK + "; ".join(filter(None, (question, ask)))))


def clocks_of_channels(own: Mapping[str, str], used: Sequence[str], data: Mapping[str, Array]) -> Clocks:
    """Return the clocks of a file that has one for each channel: the sender's stamps where a message holds them, as what is received may have waited.

    Parameters
    ----------
    own : mapping of str to str
        The clock of each channel, in s.
    used : sequence of str
        Channels of the input and the output tension, the input's first.
    data : mapping
        First samples of each channel, shape (n,).
    """
    first = used[0]
    stamps = {n: stamp for n, clock in own.items() if (stamp := _sent(clock)) in data}
    sent = {n: stamp for n, stamp in stamps.items() if runs_forward(trimmed(data[stamp]))}
    base = sent.get(first, own[first])
    time = _in_seconds(base)
    if first in sent:
        why = f"time_s: '{base}', when '{first}' was sent ('{own[first]}' is when it came)"
        ask = _asked_of_senders([(sent[n], own[n]) for n in used if n in sent], data)
        theirs = {n: _in_seconds(stamp) for n, stamp in sent.items() if stamp != base}
        return Clocks(replace(time, line=time.line + ask, reasons=(why,)), theirs)
    time = replace(time, reasons=(f"time_s: '{base}', the clock of '{first}'",))
    if first in stamps and np.ptp(data[stamps[first]]) > 0.0:
        ask = f"when it came; '{stamps[first]}', when it was sent, goes back at times: sort the messages by it and take it instead?"
        time = replace(time, line=f"{time.line}{MARK}{ask}")
    return Clocks(time)


def _asked_of_senders(clocks: Sequence[tuple[str, str]], data: Mapping[str, Array]) -> str:
    """Return the question that is left where one side comes later after it was sent than another, by more than a step of theirs."""
    late = {sent: _middle(data[came]) - _middle(data[sent]) for sent, came in clocks if came in data}
    step = max((float(np.median(np.diff(data[sent]))) for sent in late), default=0.0)
    if len(late) < 2 or max(late.values()) - min(late.values()) <= step:
        return ""
    said = ", ".join(f"'{sent}' comes {by:.3g} s" for sent, by in late.items())
    return f"{MARK}{said} after it was sent: are the senders on one clock? If not, take what ends in {TIME}"


def _middle(values: Array) -> float:
    return float(np.median(values))


def _sent(received: str) -> str:
    """Return what the sender's stamps beside a clock of a topic are called, an empty text for a clock of another kind."""
    return received.removesuffix(TIME) + STAMP if received.endswith(TIME) else ""


def _in_seconds(clock: str) -> TimeGuess:
    return TimeGuess(f'time_s = {{ column = {json.dumps(clock, ensure_ascii=False)}, unit = "s" }}', clock, ())


def _is_clock(one: Said, data: dict[str, Array]) -> bool:
    if one.name not in data or not (one.quantity == "time" or (one.dimension == "time" and not (one.quantity or one.side))):
        return False
    values = trimmed(data[one.name])
    return runs_forward(values) and not (np.diff(values) < 0).any()


def _runs_beside(one: Said, chosen: Said, data: dict[str, Array]) -> bool:
    """Return whether a channel that no word calls a clock runs forward evenly as one does, and not as the clock itself does in some unit."""
    told = one.strange or (one.unit and one.dimension != "time") or (one.quantity and not time_unit(one.name))
    if one.name not in data or one is chosen or told:
        return False
    x, y = trimmed(data[chosen.name]), trimmed(data[one.name])
    if not runs_forward(y) or (np.diff(y) <= 0).any() or not even(y) or counts(y):
        return False
    if len(x) != len(y):
        return True
    line = y[0] + (y[-1] - y[0]) * (x - x[0]) / (x[-1] - x[0])
    if np.max(np.abs(y - line)) > float(np.max(np.diff(y))):
        return True
    tick = float(np.median(np.diff(x)))
    rates = np.abs(FACTORS * (y[-1] - y[0]) / (x[-1] - x[0]) - 1.0)
    factor = FACTORS[int(np.argmin(rates))]
    # elapsed and unix time tell the same row
    return bool(rates.min() > SAME_STEP or (is_epoch(x) == is_epoch(y) and abs(x[0] - factor * y[0]) > tick))


def _of_sides(names: Sequence[Said], clocks: list[Said]) -> dict[str, Said]:
    """Return the clock of each channel of a side where each side has one by its name, else nothing."""
    sides = {s.side: s for s in clocks if s.side}
    if len(sides) != 2 or len(clocks) != 2:
        return {}
    return {s.name: sides[s.side] for s in names if s.side and s not in clocks}


def _asked(clock: TimeGuess, base: Said, own: Said, data: dict[str, Array]) -> TimeGuess:
    """Return the own clock of a channel with a question where it runs as fast as that of the file but from another zero: rows may go together all the same."""
    x, y = _seconds(base, data), _seconds(own, data)
    if len(x) != len(y) or abs((x[-1] - x[0]) - (y[-1] - y[0])) > SAME_RATE * (x[-1] - x[0]):
        if is_epoch(data[base.name]) == is_epoch(data[own.name]):
            return clock
        ask = 'the clocks never meet: in [clocks] write align = "start" if both began together, or "apply" to find it by the motion'
        return replace(clock, line=clock.line + ("; " if MARK in clock.line else MARK) + ask)
    if float(np.median(np.abs(x - y))) <= float(np.median(np.diff(x))):
        return clock
    ask = f"'{base.name}' runs as fast from another zero: if both of a row are of one moment, take time and what belongs to it out of this line"
    return replace(clock, line=clock.line + ("; " if MARK in clock.line else MARK) + ask)


def _in_front(names: Sequence[Said], clocks: list[Said]) -> dict[str, Said]:
    """Return the clock of each channel where a table begins with one and each stands in front of its channels, else nothing."""
    # numbers of rows may stand in front of all
    names = names[next((i for i, s in enumerate(names) if s.quantity != "index"), 0) :]
    places = [i for i, s in enumerate(names) if s in clocks]
    if places[0] != 0 or places[-1] == len(names) - 1 or any(b == a + 1 for a, b in pairwise(places)):
        return {}
    out: dict[str, Said] = {}
    last = names[0]
    for one in names:
        last = one if one in clocks else last
        if one not in clocks:
            out[one.name] = last
    return out


def _seconds(one: Said, data: dict[str, Array]) -> Array:
    return trimmed(data[one.name]) * (unit_of(one.unit)[1] if one.dimension == "time" else 1.0)


def _equal(a: Said, b: Said, data: dict[str, Array]) -> bool:
    """Return whether two clocks tell the same time in every row."""
    x, y = _seconds(a, data), _seconds(b, data)
    return len(x) == len(y) and bool(np.max(np.abs(x - y)) <= SAME_STEP * float(np.median(np.diff(x))))


def _apart(a: Said, b: Said, data: dict[str, Array], meet: bool) -> bool:
    """Return whether two clocks cannot be of the same rows: another length or rate, or another zero where their names are alike."""
    x, y = _seconds(a, data), _seconds(b, data)
    if len(x) != len(y):
        return True
    if meet and _alike(a.name) == _alike(b.name):
        return not _equal(a, b, data)
    factors = np.ones(1) if a.dimension == "time" and b.dimension == "time" else FACTORS
    spans, ticks = [float(v[-1] - v[0]) for v in (x, y)], [float(np.max(np.diff(v))) for v in (x, y)]
    near = np.abs(spans[0] - factors * spans[1]) <= SAME_RATE * spans[0] + ticks[0] + factors * ticks[1]
    return not near.any()


def _alike(name: str) -> str:
    """Return a name without what numbers it: Time 1, Time 2, Time.2, Time A."""
    return re.sub(r"[\W_]+|\d+|(?<![A-Za-z])[AB](?![A-Za-z])", "", name).lower()


def _fits(clock: Said, used: Sequence[str], data: dict[str, Array]) -> bool:
    """Return whether a tension has as many samples as a clock."""
    return any(len(trimmed(data[n])) == len(trimmed(data[clock.name])) for n in used if n in data)
