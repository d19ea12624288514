"""A first look at one file: its channels, its first samples, its clock and its likely tensions."""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from sstl_cli.core.errors import SstlError, printable
from sstl_cli.importers.base import Channel, Format, Layout, Notes, detect, guarded
from sstl_cli.importers.guess_beside import Beside, remarks_of, told_beside
from sstl_cli.importers.guess_blocks import Stacked, stacked
from sstl_cli.importers.guess_clocks import Clocks, clock_if_forward, clocks_of_channels, with_own_clocks
from sstl_cli.importers.guess_config import chosen_config, config_columns, labelling
from sstl_cli.importers.guess_corrections import corrections_said, corrects, joined, with_corrections
from sstl_cli.importers.guess_fractions import Parts, sums
from sstl_cli.importers.guess_groups import with_groups
from sstl_cli.importers.guess_labels import (
    LabelColumn,
    holds_systems,
    label_columns,
    label_names,
    may_label,
    rows_of_first,
    runs_in,
    with_systems,
)
from sstl_cli.importers.guess_marks import asking, grouped_cell, thousands, two_units, with_marks
from sstl_cli.importers.guess_names import Said, contradicted, said
from sstl_cli.importers.guess_rates import named_rate, rate_held
from sstl_cli.importers.guess_roles import Roles, guess_roles, measured
from sstl_cli.importers.guess_runs import Groups, named_in_runs, runs_by_group
from sstl_cli.importers.guess_stamps import Stated, dated, stamp_steps
from sstl_cli.importers.guess_time import TimeGuess, guess_time, trimmed
from sstl_cli.importers.guess_unit_columns import with_unit_columns, with_unit_said
from sstl_cli.importers.guess_words import words
from sstl_cli.importers.rates_said import rate_said
from sstl_cli.importers.text import grouped_in
from sstl_cli.importers.text_cells import WITHOUT_MARKS
from sstl_cli.importers.text_header import unit_in
from sstl_cli.importers.text_layout import layout_of
from sstl_cli.importers.text_mend import OR_ELSEWHERE
from sstl_cli.importers.waveforms import OWN

Array = NDArray[np.float64]
MAX_ROWS = 20_000
MAX_COLUMNS = 64
# of a cell in a question
SHOWN = 40
# formats whose columns stand as they were written
TABLES = ("text", "parquet")
# names of the columns of a long table: which channel a reading is of, and the reading
KEYS = words("field variable channel signal metric sensor parameter series tag kanal canal canale name")
VALUES = words("value val wert valeur valor valore reading")
# a long table has the reading and the number of its channel, and no more that moves
_LONG = 3


@dataclass(frozen=True)
class Look:
    """What one file seems to hold."""

    path: Path
    format: Format
    names: tuple[Said, ...]
    data: dict[str, Array]
    time: TimeGuess
    roles: Roles
    tensions: tuple[Said, ...] = ()
    labels: tuple[LabelColumn, ...] = ()
    runs: str = ""
    own: Mapping[str, TimeGuess] = field(default_factory=dict)
    groups: Groups | None = None
    beside: Beside = field(default_factory=Beside)
    blocks: Stacked | None = None

    @property
    def channels(self) -> tuple[str, ...]:
        """Names of the channels, in the order of the file."""
        return tuple(s.name for s in self.names)

    @property
    def used(self) -> set[str]:
        """Names of the clock and the tensions."""
        return {n for n in (self.time.channel, self.time.fraction, *(s.name for s in (*self.roles.first, *self.roles.second))) if n}


def look_at(path: Path, wanted: str | None, as_: Format | None = None) -> Look:
    """Return what a file seems to hold, of a format that is given or found; SstlError where it cannot be read or has no two numeric channels."""
    chosen, blocks = (as_, None) if as_ is not None else _format(path, wanted)
    found = chosen.channels(path, Layout())
    prefix, runs, groups = _runs(chosen, path, found, as_ is not None)
    all_runs = partial(named_in_runs, runs, [c.name for c in found])
    found, doubts = _with_units(chosen, path, [c for c in found if c.name.startswith(prefix)])
    doubts = {n.removeprefix(prefix): ask for n, ask in doubts.items()} | dict(groups.doubts if groups is not None else {})
    channels = [c for c in found if not c.text][:MAX_COLUMNS]
    try:
        first_values, wrong = _first_values(chosen, path, channels)
    except SstlError as error:
        raise _of_thousands(chosen, path, error) from None
    data = {n.removeprefix(prefix): v for n, v in first_values.items()}
    lengths = Counter(map(len, data.values()))
    labels, first = _labels(chosen, path, prefix, found, max(lengths, key=lambda n: lengths[n], default=0), all_runs)
    told = {x.column for x in labels}
    channels = [c for c in channels if c.name.removeprefix(prefix) not in told]
    data = {n: v for n, v in data.items() if n not in told}
    _refuse_two_units(chosen, path, found)
    if len(data) < 2:
        raise _too_few(chosen, path, found)
    _refuse_grouped(chosen, path, found)
    left_out = _left_out(channels, wrong)
    channels = with_groups([replace(c, name=c.name.removeprefix(prefix)) for c in channels], data)
    names = [asking(s, doubts.get(s.name, "")) for s in (_said(c, chosen) for c in channels)]
    names = with_corrections(with_marks(path, names) if chosen.ID == "text" else names, data)
    # a clock may begin anew with each run that the labels tell apart
    first = min(first or blocks.rows_of_first, blocks.rows_of_first) if blocks is not None else first
    one = {n: v[:first] for n, v in data.items()}
    names = [clock_if_forward(s, one.get(s.name)) for s in names]
    texts = [c.name for c in found if c.text and said(c.name).quantity == "time"]
    own = {c.name: c.time.removeprefix(prefix) for c in channels if c.time and c.time.removeprefix(prefix) != c.name}
    stated = _stamps(chosen, path, texts) or _rate(chosen, path, found)
    unread = [f"'{n}' holds {printable(held[0][:SHOWN])!r}" for n in texts if (held := _first_texts(chosen, path, n)[0])]
    time = guess_time(names, one, unread, stated)
    moving = [s for s in names if s.name in data and s.name not in (time.channel, time.fraction) and moves(data[s.name])]
    _refuse_long(chosen, path, found, {s: data[s.name] for s in moving})
    roles = guess_roles(moving, data)
    clocks = Clocks(time)
    if not own:
        chosen_ones = [s.name for s in (*roles.first, *roles.second)]
        whole, parts = sums(names, one)
        clocks = with_own_clocks(names, whole, time, chosen_ones, chosen.ID in TABLES, lambda s: _alone(s, names, one, parts))
        time = clocks.time
    if roles.first and roles.first[0].name in own:
        # formats with a clock for each channel tell the time themselves, in s
        clocks = clocks_of_channels(own, [x.name for x in (*roles.first, *roles.second)], data)
        time = clocks.time
    time = replace(time, reasons=(*_told_first(runs, channels, blocks), *time.reasons, *left_out))
    beside = told_beside(chosen, path, found, told, chosen.ID in TABLES, lambda name: _first_texts(chosen, path, name)[0])
    tensions = tuple(measured(moving))
    return Look(path, chosen, tuple(names), data, time, roles, tensions, labels, runs, clocks.own, groups, beside, blocks)


def _format(path: Path, wanted: str | None) -> tuple[Format, Stacked | None]:
    """Return the format of a file, that of its blocks where a text log holds several, and these."""
    known = detect(path, wanted)
    blocks = stacked(path) if known.ID == "text" else None
    return blocks or known, blocks


def _runs(chosen: Format, path: Path, found: list[Channel], given: bool) -> tuple[str, str, Groups | None]:
    """Return what stands in front of the channels of the first run, the pattern of all, and their groups, empty where a file holds one run."""
    prefix, runs = runs_in([c.name for c in found], path.stem if chosen.ID not in TABLES and not given else "")
    groups = runs_by_group(found, chosen.ID in TABLES) if not runs and not given else None
    return (groups.prefix, groups.pattern, groups) if groups is not None else (prefix, runs, None)


def _told_first(runs: str, channels: Sequence[Channel], blocks: Stacked | None) -> list[str]:
    """Return the reasons that stand before those of the clock: what labels say, and that runs stand side by side or below each other."""
    labelled = [f"'{c.name}' is '{c.label}'" for c in channels if c.label]
    out = [f"by its labels {', '.join(labelled)}"] if labelled else []
    out += [blocks.reason] if blocks is not None else []
    return [*out, f"every '{runs}' holds the same channels: runs of their own"] if runs else out


def _with_units(chosen: Format, path: Path, found: list[Channel]) -> tuple[list[Channel], dict[str, str]]:
    """Return the channels with what columns of units beside them, and a line above, say in a table, and the questions that those raise."""
    single = [c.name for c in found if c.rows == 1 and not c.text and corrects(said(c.name))]
    lines = [*remarks_of(chosen, path), *(f"{re.split('[./@]', n)[-1]}: {t}" for n in single for t in _first_texts(chosen, path, n)[0])]
    doubts: dict[str, str] = {}
    if chosen.ID in TABLES:
        found, doubts = with_unit_columns(found, lambda name: _first_texts(chosen, path, name)[0])
    found, more = with_unit_said(found, lines)
    doubts = joined(doubts, more, corrections_said(found, lines))
    starts = layout_of(path, Layout()).starts if chosen.ID == "text" else ""
    clocks = [c.name for c in found if starts and said(c.name, c.unit).quantity == "time"]
    return found, doubts | dict.fromkeys(clocks, f"{starts}, this counts from the start of one: {OWN}")


def _refuse_grouped(chosen: Format, path: Path, found: list[Channel]) -> None:
    """Raise SstlError for a column of text that is named as a tension and holds numbers with marks between thousands."""
    for channel in found if chosen.ID == "text" else ():
        if channel.text and said(channel.name, channel.unit).tension and (cell := grouped_cell(path, channel.name)):
            what = f"column '{printable(channel.name)}' holds {cell!r}, not a number"
            raise SstlError(what, where=str(path), fix=WITHOUT_MARKS, code="E328")


def _alone(clock: Said, names: list[Said], data: dict[str, Array], parts: Mapping[str, Parts]) -> TimeGuess:
    """Return what a channel is as the only clock of the file, with its parts of a second."""
    beside = [s for s in names if clock.name in parts and s.name == parts[clock.name].name]
    return guess_time([clock, *beside], {s.name: trimmed(data[s.name]) for s in (clock, *beside)}, [])


def _refuse_two_units(chosen: Format, path: Path, found: list[Channel]) -> None:
    """Raise SstlError for a column of text that is named as a tension and holds numbers with a unit that changes."""
    for channel in found if chosen.ID == "text" else ():
        if channel.text and said(channel.name, channel.unit).tension and (two := two_units(path, channel.name)):
            what = f"column '{printable(channel.name)}' holds {two[0]!r} and {two[1]!r}: the unit behind its numbers changes"
            raise SstlError(what, where=str(path), fix="write all of it in one unit", code="E328")


def _of_thousands(chosen: Format, path: Path, error: SstlError) -> SstlError:
    """Return the error of a cell, or, where the marks between thousands are those of another column, one that names it."""
    if chosen.ID == "text" and error.code == "E328" and OR_ELSEWHERE in error.fix:
        name, cell = thousands(path)
        if name and f"'{name}'" not in error.what:
            what = f"column '{printable(name)}' holds {cell!r} beside numbers without a mark, which stands between thousands there"
            return SstlError(what, where=str(path), fix=WITHOUT_MARKS, code="E328")
    return error


def _refuse_long(chosen: Format, path: Path, found: list[Channel], moving: Mapping[Said, Array]) -> None:
    """Raise SstlError for a table of one row per reading: a column of text says which channel it is of."""
    if any(s.tension and s.words[-1:] and s.words[-1] not in VALUES for s in moving):
        return
    # VarName, tag_name
    keys = [c.name for c in found if c.text and said(c.name).words[-1:] and said(c.name).words[-1] in KEYS]
    held = [s.name for s in moving if s.words[-1:] and s.words[-1] in VALUES]
    if not keys or len(held) != 1:
        # whatever they are called: words that take turns, beside one reading and what numbers its channel
        keys = [c.name for c in found if c.text and _take_turns(_first_texts(chosen, path, c.name)[0])] if len(moving) < _LONG else []
        held = [s.name for s, values in moving.items() if len(np.unique(values)) > MAX_COLUMNS or len(moving) == 1]
    if keys and len(held) == 1:
        what = f"has one row per field ('{keys[0]}' says which, '{held[0]}' holds it)"
        fix = f"pivot it first, so that each '{keys[0]}' is a column of its own, and each time one row"
        raise SstlError(what, where=str(path), fix=fix, code="E333")


def _take_turns(texts: list[str]) -> bool:
    """Return whether a few words follow each other from row to row, as the names of channels do; labels of runs stand in blocks."""
    few = set(texts)
    changes = sum(a != b for a, b in pairwise(texts))
    return 1 < len(few) <= MAX_COLUMNS and all(re.search(r"[^\W\d_]", t) for t in few) and 2 * changes > len(texts) > len(few) ** 2


def _said(channel: Channel, chosen: Format) -> Said:
    """Return what the name of a channel says, or its label where it has one."""
    bare = said(re.sub(r"\s*[\[(].*", "", channel.name))
    # a table of channels says what CH1 is; of a name that says it itself it may tell anything
    called = (
        channel.label if channel.label and (chosen.ID != "text" or not (bare.side or bare.quantity in ("force", "time"))) else channel.name
    )
    if channel.stamps:
        return replace(said(called), name=channel.name, quantity="time", unit="s", strange="", stamped=True)
    apart = "" if chosen.ID == "text" and channel.unit == unit_in(called) else channel.unit
    one = replace(said(called, apart), name=channel.name)
    if apart and (other := contradicted(one, said(called))):
        return asking(one, f"its name says {other}, the file {one.unit} apart from it: which is it?")
    return one


def _labels(
    chosen: Format, path: Path, prefix: str, found: list[Channel], rows: int, all_runs: Callable[[str], list[str]]
) -> tuple[tuple[LabelColumn, ...], int | None]:
    """Return the columns that give labels for as many rows, and how many the first run has by them (None: all)."""
    units = {c.name.removeprefix(prefix): c.unit for c in found}
    alone = {c.name.removeprefix(prefix) for c in found if c.rows == 1}
    paths = chosen.ID not in TABLES
    names, configs = label_names(units, alone), config_columns(units, alone, paths)
    read = {n: _first_texts(chosen, path, prefix + n) for n in dict.fromkeys([*names.values(), *configs])}
    # a configuration that reads single pass is a system
    ways = [n for n in configs if may_label("system", read[n][0])]
    configs = [n for n in configs if n not in ways]
    if ways:
        names.setdefault("system", ways[0])
    for channel in found if "system" not in names else ():
        # whatever it is called (mode, test): what it holds says it
        name = channel.name.removeprefix(prefix)
        if channel.text and name not in read and holds_systems((texts := _first_texts(chosen, path, channel.name))[0]):
            names, read = {**names, "system": name}, {**read, name: texts}
            break
    if not names and not configs:
        return (), None
    # a single one holds for all; of another length it labels something else
    fitting = {n: texts for n, (texts, _) in read.items() if min(len(texts), MAX_ROWS) in (1, rows)}
    longest = max(map(len, fitting.values()), default=1)
    values = {n: texts * longest if len(texts) == 1 else texts for n, texts in fitting.items() if len(texts) in (1, longest)}
    held = labelling({n: values[n] for n in configs if n in values and may_label("config_id", values[n])}, paths)
    config, doubt = chosen_config(held, paths) if held else ("", "")
    names = {t: n for t, n in names.items() if n in values} | ({"config_id": config} if held else {})
    labels = label_columns(names, values, all(whole for _, whole in read.values()), units, {"config_id": doubt})
    # the names of one column in the groups of all runs
    labels = tuple(
        with_systems(c, [t for n in all_runs(c.column) for t in _first_texts(chosen, path, n)[0]]) if c.target == "system" else c
        for c in labels
    )
    return labels, rows_of_first(labels, values)


def _first_texts(chosen: Format, path: Path, name: str) -> tuple[list[str], bool]:
    """Return the first values of a channel as text, and whether they are all of them."""
    texts: list[str] = []
    with guarded(path, chosen.TITLE):
        for block in chosen.read(path, [], [name], Layout(), Notes()):
            if len(texts) >= MAX_ROWS:
                return texts, False
            texts += [str(v) for v in block.columns[name]]
    return texts, True


def _too_few(chosen: Format, path: Path, found: list[Channel]) -> SstlError:
    """Return that a file holds too few channels of numbers: which were seen, from which line on, and what stands in a cell that looks like one."""
    seen = ", ".join(repr(printable(c.name[:24])) + (" (text)" if c.text else "") for c in found[:6]) or "none"
    what = f"holds fewer than two numeric channels (columns {seen}{', ...' if found[6:] else ''}"
    if chosen.ID != "text":
        return SstlError(f"{what})", where=str(path), fix="check the file", code="E333")
    what = f"{what}; the table seems to begin at line {layout_of(path, Layout()).first_line})"
    fix = "check the file; if the table begins elsewhere, give a mapping with [text] skip_rows and header"
    if grouped := grouped_in(path):
        fix = f"{WITHOUT_MARKS} (it holds {grouped!r})"
    return SstlError(what, where=str(path), fix=fix, code="E333")


def moves(values: Array) -> bool:
    """Return whether the readings of a channel differ."""
    finite = values[np.isfinite(values)]
    return len(finite) > 2 and float(np.ptp(finite)) > 0


def _first_values(chosen: Format, path: Path, channels: list[Channel]) -> tuple[dict[str, Array], dict[str, SstlError]]:
    """Return the first values of the channels, and why those of others cannot be read; one of text or of another length does not spoil the others."""
    names = [c.name for c in channels]
    try:
        return {n: v for n, v in _read(chosen, path, names).items() if len(v) > 2}, {}
    except SstlError as error:
        if error.code not in ("E328", "E314", "E339"):
            raise
    out = {}
    wrong: dict[str, SstlError] = {}
    for name in names:
        try:
            values = _read(chosen, path, [name])[name]
        except SstlError as error:
            if error.code not in ("E328", "E314") or error.fix.startswith(WITHOUT_MARKS):
                raise
            wrong[name] = error
            continue
        if len(values) > 2:
            out[name] = values
    if len(out) < 2 and (line := next((e for e in wrong.values() if e.code == "E328"), None)):
        # numbers end there for all channels, as where a logger began anew and wrote its header again
        raise line
    return out, wrong


def _left_out(channels: list[Channel], wrong: dict[str, SstlError]) -> list[str]:
    """Return a reason for each column of numbers that a cell spoils; SstlError for that of a tension, which is not left out."""
    spoilt = [(c, wrong[c.name]) for c in channels if c.name in wrong and wrong[c.name].code == "E328"]
    for channel, error in spoilt:
        if said(channel.name, channel.unit).tension:
            raise error
    return [f"'{c.name}' is left out: {e.line()}" for c, e in spoilt]


def _stamps(chosen: Format, path: Path, texts: list[str]) -> Stated | None:
    """Return the sampling period that a channel of times in text tells, or the header of the file, None where neither does."""
    with guarded(path, chosen.TITLE):
        for name in texts:
            for block in chosen.read(path, [], [name], Layout(), Notes()):
                stamps = [str(v) for v in block.columns[name][:MAX_ROWS]]
                if (found := stamp_steps(stamps)) is not None:
                    return replace(found, by=f"'{name}' holds {'dates' if dated(stamps[0]) else 'times'} as text")
                break
    layout = layout_of(path, Layout()) if chosen.ID == "text" else None
    if layout is not None and layout.waveform is not None:
        doubt = layout.waveform.doubt
        return Stated(layout.waveform.step_s, "the header states it", doubt=f", {doubt}" if doubt else "", sure=not doubt)
    return Stated(layout.step_s, "the header states it") if layout is not None and math.isfinite(layout.step_s) else None


def _rate(chosen: Format, path: Path, found: list[Channel]) -> Stated | None:
    """Return the sampling period of a rate that the file holds as a number, None where it holds none."""
    named = [c.name for c in found if not c.text and named_rate(c.name)]
    # each alone: it may be as long as the readings, or one number
    held = rate_held({n: _read(chosen, path, [n])[n] for n in named})
    step = rate_said(remarks_of(chosen, path)) if held is None and chosen.ID != "text" else math.nan
    return Stated(step, "the file states it") if math.isfinite(step) else held


def _read(chosen: Format, path: Path, names: list[str]) -> dict[str, Array]:
    held: dict[str, list[Array]] = {n: [] for n in names}
    rows = 0
    with guarded(path, chosen.TITLE):
        for block in chosen.read(path, names, [], Layout(), Notes()):
            for name in names:
                held[name].append(np.asarray(block.columns[name], np.float64))
            rows += len(block)
            if rows >= MAX_ROWS:
                break
    return {n: np.concatenate(v)[:MAX_ROWS] if v else np.empty(0) for n, v in held.items()}
