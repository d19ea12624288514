"""Which channel is the clock of a recording, and in which unit; what cannot be known is asked."""

from __future__ import annotations

import json
import math
import re
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sstl_cli.core.units import unit_of
from sstl_cli.importers.guess_epochs import epoch, hundred_ns, of_days
from sstl_cli.importers.guess_fractions import Parts, in_parts
from sstl_cli.importers.guess_names import Said
from sstl_cli.importers.guess_stamps import GAP, Stated, is_time
from sstl_cli.importers.guess_words import NO_CLOCK, UNIT_CELLS, words

Array = NDArray[np.float64]
# behind a line that an import asks for, with the question
MARK = "  # (?) "
DAY_WORDS = words("d day days tag tage jour jours dia dias giorno giorni excel")
# of a clock in days, which steps can be none of a logger in s, though they are long in days (10 min)
LONG_DAYS = 4.99e-4
# of a clock in steps of 100 ns, steps that rounding leaves to a hundredth
FINE_S = 1e-3
LIKELY_STEP_S = (2e-5, 0.5)
# without a stated unit: the steps of usual loggers, whose rate is a whole number; with 60 in it, it may be one a minute
LOGGER_STEP_S = (4.99e-4, 0.1001)
MINUTE = 60
# steps from here on are as round in ms (25 kHz and less): shorter than this in ms (s), or faster than this (mm/s), no tendon is tested
MS_STEP, SHORTEST_S, FASTEST_MM_S = 0.0399, 0.05, 1e3
# of a rate, how far it may be from a whole number
ROUNDED = 1e-3
# of a rate, how far two clocks of one recording lie apart: a computer's clock against a card's, and never another rate
SAME_RATE = 0.02
# from 1 in the morning, a time of day written as a number (140321.05) may be a number of seconds
DAYTIME = (10_000.0, 240_000.0)
FORWARD = 0.98
# of the samples that share a tick of a rounded clock, how far their number may differ
ROUNDED_SHARE, EVEN_SHARE = 0.2, 0.01
# of the stamps of samples that share one with another, how many are no chance
SHARED = 0.1
# of the steps of a channel that is not named as time, how many may be none
SWITCHED = 0.9
# behind unix time they can be nothing else
EPOCH_WORDS = words("epoch unix unixtime posix ts")


@dataclass(frozen=True)
class TimeGuess:
    """The line of a mapping for ``time_s``, the channel it names (None: none), the reasons, and the channel of the parts of a second."""

    line: str
    channel: str | None
    reasons: tuple[str, ...]
    fraction: str = ""


def guess_time(names: list[Said], data: dict[str, Array], texts: list[str], stated: Stated | None = None) -> TimeGuess:
    """Return the clock: by name and by running forward; a channel that counts samples is no clock.

    Parameters
    ----------
    names : list of Said
        The numeric channels in the order of the file.
    data : dict
        First samples of each channel, shape (n,).
    texts : list of str
        What stands in the channels that are named as a clock and hold text.
    stated : Stated, optional
        The sampling period that one of these tells, or the header.
    """
    # a clock may run for fewer rows than the others
    data = {n: trimmed(v) for n, v in data.items()}
    # a counter that begins anew is a clock all the same
    wraps = {s.name: w for s in names if s.name in data and (w := wrapped(data[s.name])) is not None}
    data = {**data, **{name: values for name, (values, _) in wraps.items()}}
    forward = [s for s in names if s.name in data and runs_forward(data[s.name])]
    counters = [s for s in forward if s.quantity == "index" or (s.quantity != "time" and counts(data[s.name]))]
    clocks = [s for s in forward if s not in counters and (s.quantity == "time" or not (s.quantity or s.side))]
    named = [s for s in clocks if s.quantity == "time" or s.dimension == "time"]
    if any(not s.side for s in named):
        # beside a clock of the whole, what holds its value over most samples is a reading (a temperature)
        named = [s for s in named if not (s.side and repeats(data[s.name]) > 0.5)]
    reasons = [f"'{s.name}' counts samples and is no time" for s in counters]
    anew = "begins anew: an import begins another run there; unwrap it in the file to keep one"
    reasons += [f"'{s.name}' counts to {wraps[s.name][1]} and {anew}" for s in clocks if s.name in wraps]
    if named:
        best = min(named, key=lambda s: _worse(s, data[s.name]))
        told = _ms_or_s(data[best.name], names, data, stated)
        if (parts := in_parts(best, names, data)) is not None:
            return _of_parts(best, parts, reasons)
        if (finer := _rounded(best, names, data)) is not None:
            return _by_rate(finer, reasons)
        if len(named) > 1:
            others = ", ".join(f"'{s.name}'" for s in named if s is not best)
            reasons.append(f"time_s: '{best.name}' of several clocks ({others} too)")
        return _of(best, data[best.name], reasons, told, stated)
    for one in (s for s in forward if not s.quantity and epoch(data[s.name]) == "s"):
        if (parts := in_parts(one, names, data, named=False)) is not None:
            return _of_parts(one, parts, reasons, f"are '{one.name}' and '{parts.name}' the seconds and their fraction?")
    # a signal that is switched runs forward where it is switched once
    steady = [s for s in clocks if even(data[s.name]) and repeats(data[s.name]) <= SWITCHED]
    if steady:
        told = _ms_or_s(data[steady[0].name], names, data, stated)
        return _of(steady[0], data[steady[0].name], reasons, told, stated, sure=_named_epoch(steady[0], data[steady[0].name]))
    hint = f" ({texts[0]}, no time in a form that is known: write 2024-05-03 14:05:06.120, or the seconds)" if texts else ""
    if stated is not None:
        return _by_rate(stated, reasons)
    if back := next((s for s in names if s.name in data and s.quantity == "time" and runs_forward(-data[s.name])), None):
        reasons.append(f"'{back.name}' runs backward: the newest sample stands first")
        ask = f"'{back.name}' runs backward, the newest sample first: sort the rows by it, as no rate turns them round"
        return TimeGuess(f"time_s = {{ rate_hz = 0 }}{MARK}{ask}", None, tuple(reasons))
    # one that runs forward may be called in a language that is not known here
    likely = ", ".join(repr(s.name) for s in forward if s not in counters)
    what = f"no name says time, and {likely} runs forward: is it the clock, or" if likely else f"no clock found{hint}:"
    reasons.append(f"no channel with numbers {'is named as time' if likely else 'runs forward like time'}{hint}: give the sampling rate")
    # a number that is not in the file would be taken once the mark is deleted
    return TimeGuess(f"time_s = {{ rate_hz = 0 }}{MARK}{what} which rate?", None, tuple(reasons))


def _worse(clock: Said, values: Array) -> tuple[bool, ...]:
    """Return what ranks clocks: the one that tells samples apart; then numbers before times in text; then the sender's own stamp."""
    return _goes_back(values), repeats(values) > 0.5, clock.stamped, "header" not in clock.words, repeats(values) > 0


def _by_rate(stated: Stated, reasons: list[str]) -> TimeGuess:
    """Return the rate that stamps or the header tell, to be asked; none where the stamps themselves have gaps."""
    if math.isnan(stated.step_s):
        return TimeGuess(f"time_s = {{ rate_hz = 0 }}{MARK}{stated.by}{stated.doubt}", None, tuple(reasons))
    reasons.append(f"{stated.by}, a sample every {stated.step_s:g} s; an import takes numbers, or the rate")
    if stated.gaps:
        gaps = f"{stated.gaps} gap{'s' if stated.gaps > 1 else ''} of up to {stated.longest_s:g} s"
        ask = f"{stated.by}, every {stated.step_s:g} s but for {gaps}, which a rate would close: write them as numbers of seconds"
        return TimeGuess(f"time_s = {{ rate_hz = 0 }}{MARK}{ask}", None, tuple(reasons))
    line = f"time_s = {{ rate_hz = {1.0 / stated.step_s:g} }}"
    if stated.sure:
        return TimeGuess(line, None, tuple(reasons))
    ask = f"{stated.by}{stated.doubt}: does a sample come every {stated.step_s:g} s throughout?"
    return TimeGuess(f"{line}{MARK}{ask}", None, tuple(reasons))


def _of(best: Said, values: Array, reasons: list[str], told: str, stated: Stated | None, sure: bool = True) -> TimeGuess:
    unit, scale, question, why = ("s", 1.0, "", "times written as text, read in s") if best.stamped else _unit(best, values, told)
    question = question or _against(values, unit_of(unit)[1] * scale, stated)
    if not sure:
        question = question or "is this the time, and in this unit?"
    steps = np.diff(values)
    repeated = float(np.mean(steps == 0))
    name = json.dumps(best.name, ensure_ascii=False)
    extra = f", scale = {scale:g}" if scale != 1.0 else ""
    question = "; ".join(filter(None, (question, best.doubt)))
    mark = MARK + question if question else ""
    reasons.append(f"time_s: '{best.name}' runs forward in {100 * np.mean(steps >= 0):.1f} % of the steps; {why}")
    if _goes_back(values):
        mark = mark or MARK + "it runs back at times: is it one part of a clock, such as its nanoseconds?"
    if best.stamped and repeated > SHARED:
        mark = mark or MARK + f"{100 * repeated:.0f} % of the samples share the stamp of another: is there a finer clock, or a rate?"
    if repeated > 0.9:
        mark = mark or MARK + "it repeats in most steps: is there a finer clock, or a rate?"
    if repeated:
        reasons.append(f"time repeats in {100 * repeated:.0f} % of the steps: the last of a tick is kept")
    return TimeGuess(f'time_s = {{ column = {name}, unit = "{unit}"{extra} }}{mark}', best.name, tuple(reasons))


def _of_parts(best: Said, parts: Parts, reasons: list[str], ask: str = "") -> TimeGuess:
    """Return a clock of whole seconds and of what another channel tells of a second."""
    first, second = (json.dumps(n, ensure_ascii=False) for n in (best.name, parts.name))
    reasons.append(
        f"time_s: '{best.name}' holds whole seconds and '{parts.name}' their parts in {parts.unit}; the sum runs forward in every step"
    )
    line = f'time_s = {{ column = {first}, unit = "s", fraction = {second}, fraction_unit = "{parts.unit}" }}{MARK + ask if ask else ""}'
    return TimeGuess(line, best.name, tuple(reasons), parts.name)


def _against(values: Array, size: float, stated: Stated | None) -> str:
    """Return the question of a clock that runs at another rate than the file states, an empty text where it does not."""
    steps = np.diff(values)
    steps = steps[steps > 0]
    # one that is in doubt contradicts no clock
    if stated is None or stated.doubt or not len(steps):
        return ""
    # pauses are no steps
    period = size * float(np.mean(steps[steps <= GAP * np.median(steps)]))
    off = abs(period / stated.step_s - 1.0) > SAME_RATE
    return f"{stated.by}, a sample every {stated.step_s:g} s, and its own steps are {period:.4g} s: which is right?" if off else ""


def _unit(best: Said, values: Array, told: str) -> tuple[str, float, str, str]:
    """Return unit, scale, question (empty: none) and reason."""
    finite = values[np.isfinite(values)]
    steps = np.diff(finite)
    step = float(np.median(steps[steps > 0])) if (steps > 0).any() else 0.0
    stated = best.unit if best.dimension == "time" else ""
    if best.strange:
        return "s", 1.0, f"its unit is {best.strange}: give unit and scale", f"a unit of its own, {best.strange}"
    if (since := _since(best, finite, step, stated)) is not None:
        return since
    if odd := _odd(best):
        return stated or "s", 1.0, f"what is {odd} in its name? give unit and scale", f"its name says {odd}"
    if stated:
        period = step * unit_of(stated)[1]
        if period and not LIKELY_STEP_S[0] <= period <= LIKELY_STEP_S[1]:
            return stated, 1.0, f"is {1 / period:.4g} Hz the rate? the name says {stated}", f"unit {stated} by its name"
        return stated, 1.0, "", f"unit {stated} by its name"
    if _time_of_day(finite):
        return "s", 1.0, "s, or a time of day written as a number (then rate_hz)?", "may be hours, minutes and seconds in one number"
    if _logged(steps, step) and told == "ms":
        return "ms", 1.0, "", f"unit ms by the rate that the file states, step {step:g}"
    if _logged(steps, step) and told != "s":
        return "s", 1.0, f"no unit is stated: s ({1 / step:.4g} Hz), or ms ({1 / step:.4g} kHz)?", f"step {step:g}"
    if _logged(steps, step):
        return "s", 1.0, "", f"unit s from its usual step of {step:g}"
    unit = "us" if step >= 500 else "ms" if step >= 1 else "s"
    samples = " or does it count samples (then rate_hz)?" if counts(values) else ""
    return unit, 1.0, f"no unit is stated: {unit} fits steps of {step:g};{samples or ' right?'}", f"step {step:g}"


def _ms_or_s(values: Array, names: list[Said], data: dict[str, Array], stated: Stated | None) -> str:
    """Return ``s`` or ``ms`` for a clock of no stated unit with steps that loggers have in s, an empty text where it may be either."""
    finite = values[np.isfinite(values)]
    steps = np.diff(finite)
    step = float(np.median(steps[steps > 0])) if (steps > 0).any() else 0.0
    if step < MS_STEP:
        return "s"
    for unit, size in (("s", 1.0), ("ms", 1e-3)):
        if stated is not None and abs(step * size / stated.step_s - 1.0) < 10 * ROUNDED:
            return unit
    lasts_s = 1e-3 * float(finite[-1] - finite[0])
    lengths = [s for s in names if s.quantity == "position" and s.dimension == "length" and s.name in data]
    moved_mm = max((float(np.nanmax(v) - np.nanmin(v)) * unit_of(s.unit)[1] for s in lengths if len(v := data[s.name])), default=0.0)
    return "s" if lasts_s < SHORTEST_S or moved_mm > FASTEST_MM_S * lasts_s else ""


def _since(best: Said, values: Array, step: float, stated: str) -> tuple[str, float, str, str] | None:
    """Return unit, scale, question and reason of a clock whose zero lies long before the recording, or that counts days; None where it does not."""
    if unit := epoch(values):
        differs = stated and unit_of(stated) != unit_of(unit)
        return unit, 1.0, f"the name says {stated}, the values are unix time in {unit}" if differs else "", f"unix time in {unit}"
    if hundred_ns(values):
        # doubles of this size lie 13 us apart
        ask = "so large a number is read to 13 us only: write seconds since the start" if step * 1e-7 < FINE_S else ""
        ask = f"the name says {stated}, the values are steps of 100 ns" if stated else ask
        return "us", 0.1, ask, "steps of 100 ns since the year 1 or 1601, as .NET and Windows count them"
    days = _in_days(best, values, step, stated)
    return None if days is None else ("h", 24.0, days, "days, as spreadsheets and MATLAB count them")


def _in_days(best: Said, values: Array, step: float, stated: str) -> str | None:
    """Return the question of a clock in days (empty: none), None where it is no such clock."""
    # d20240503.time: a letter of the name is no unit
    named = bool(DAY_WORDS.intersection(w for w in best.words if len(w) > 1)) or (_odd(best) in DAY_WORDS and not best.dimension)
    period = 86_400.0 * step
    likely = LIKELY_STEP_S[0] <= period <= LIKELY_STEP_S[1]
    if stated or not period:
        return None
    if named or (of_days(values) and np.ptp(values) < 2):
        # seconds of a day from 10 in the morning on are such numbers, too
        return "" if likely else f"in days, {1 / period:.4g} Hz: right?" if named or step < LONG_DAYS else None
    # the time of day alone, as spreadsheets hold it
    fraction = likely and step < LIKELY_STEP_S[0] and values[0] >= 0.0 and values[-1] <= 1.0
    return (
        f"no unit is stated: days fit steps of {step:.3g} ({1 / period:.4g} Hz), as spreadsheets hold a time of day; right?"
        if fraction
        else None
    )


def _named_epoch(one: Said, values: Array) -> bool:
    """Return whether a channel is unix time by its name and its values, or by these alone ticks of .NET."""
    return hundred_ns(values) or (bool(EPOCH_WORDS.intersection(one.words)) and bool(epoch(values)))


def _rounded(best: Said, names: list[Said], data: dict[str, Array]) -> Stated | None:
    """Return the step of the samples of a clock whose ticks each hold as many that differ, None where they do not."""
    clock = data[best.name]
    starts = np.flatnonzero(np.diff(clock) != 0) + 1
    counts = np.diff(starts)
    if repeats(clock) <= 0.5 or len(counts) < 3 or np.ptp(counts) > max(1.0, ROUNDED_SHARE * float(np.median(counts))):
        return None
    same = np.diff(clock) == 0
    # rows that are written several times a tick hold the same readings
    tensions = [data[s.name] for s in names if s.tension and s.name in data and len(data[s.name]) == len(clock)]
    if not any(np.mean(np.diff(v)[same] != 0) > 0.5 for v in tensions):
        return None
    size = unit_of(best.unit)[1] if best.dimension == "time" else 86_400.0 if of_days(clock) and np.ptp(clock) < 2 else 1.0
    # ends of ticks are rounded as well: only where they do not hold the same number throughout does their mean tell more
    usual, mean = float(np.median(counts)), float(np.mean(counts))
    tick = float(np.median(np.diff(clock[starts])))
    step = float(f"{size * tick / (usual if abs(mean / usual - 1.0) < EVEN_SHARE else mean):.6g}")
    return (
        Stated(step, f"'{best.name}' is rounded, {np.median(counts):g} samples that differ share each of its ticks") if step > 0.0 else None
    )


def _odd(best: Said) -> str:
    """Return what a clock's name says beside time and its unit: a bracket that is no unit of time, a factor, another word (empty: nothing)."""
    # data[2], or [2] of a matrix called after its file, is the second column, and X(1).Data a field of the first X
    name = re.sub(r"(?:^|(?<=\w))(?:\[\d+\]$|\(\d+\)(?=\.))", "", best.name)
    brackets = re.findall(r"[\[({<]([^\[\](){}<>]*)[\])}>]", name)
    unknown = next((b for b in brackets if b.strip() and not _unit_of_time(b, best)), "")
    factor = re.search(r"(?:[*×/]|(?<![A-Za-z])x)\s*\d+(?![\w/])", best.name)
    word = next((w for w in best.words if w in NO_CLOCK), "")
    return unknown or (factor[0] if factor else word)


def _unit_of_time(bracket: str, best: Said) -> bool:
    known = UNIT_CELLS.get(bracket.strip().strip(".").lower(), bracket.strip())
    return is_time(known) and (best.dimension in ("", "time"))


def _logged(steps: Array, step: float) -> bool:
    """Return whether the steps of a clock of no stated unit are those of a usual logger if they are in s."""
    if not LOGGER_STEP_S[0] <= step <= LOGGER_STEP_S[1]:
        return False
    # the mean tells more places than a step that was rounded; pauses are no steps
    rate = 1.0 / float(np.mean(steps[(steps > 0) & (steps < 2 * step)]))
    near = ROUNDED * rate
    return abs(rate - round(rate)) <= near and abs(rate - MINUTE * round(rate / MINUTE)) > near


def _time_of_day(values: Array) -> bool:
    """Return whether numbers may be hours, minutes and seconds written together."""
    low, high = DAYTIME
    minutes, seconds = values // 100 % 100, values % 100
    return bool(low <= values[0] and values[-1] < high and seconds.max() < MINUTE and minutes.max() < MINUTE)


def trimmed(values: Array) -> Array:
    """Return readings without the empty cells at the end of a column that is shorter than others."""
    good = np.flatnonzero(np.isfinite(values))
    return values[: good[-1] + 1] if len(good) else values[:0]


def runs_forward(values: Array) -> bool:
    """Return whether values go forward in nearly all steps, as time does."""
    if len(values) < 3 or not np.isfinite(values).all():
        return False
    return bool(np.mean(np.diff(values) >= 0) >= FORWARD and values[-1] > values[0])


def wrapped(values: Array) -> tuple[Array, str] | None:
    """Return a counter of 16 or 32 bits as it runs on where it begins anew, and how far it counts; None where it does not.

    Examples
    --------
    >>> wrapped(np.array([65534.0, 65535.0, 0.0, 1.0]))
    (array([65534., 65535., 65536., 65537.]), '2^16')
    """
    steps = np.diff(values)
    back = steps < 0
    if not back.any() or not np.isfinite(values).all() or values.min() < 0 or not np.all(values == np.round(values)):
        return None
    usual = float(np.max(np.abs(steps[~back]), initial=0.0))
    for bits in (16, 32):
        # as far back as it goes on over the end of its range
        if values.max() < 2.0**bits and np.all(np.abs(steps[back] + 2.0**bits) <= 2.0 * usual):
            return values + 2.0**bits * np.concatenate(([0.0], np.cumsum(back))), f"2^{bits}"
    return None


def counts(values: Array) -> bool:
    """Return whether values go up by one each sample."""
    return bool(np.mean(np.diff(values) == 1.0) > FORWARD)


def _goes_back(values: Array) -> bool:
    return bool((np.diff(values) < 0).any())


def repeats(values: Array) -> float:
    """Return the share of the steps in which values stay as they are."""
    return float(np.mean(np.diff(values) == 0))


def even(values: Array) -> bool:
    """Return whether most of the steps forward are alike, as those of a clock."""
    steps = np.diff(values)
    steps = steps[steps > 0]
    middle = float(np.median(steps)) if len(steps) else 0.0
    return middle > 0 and float(np.median(np.abs(steps - middle))) < 0.2 * middle
