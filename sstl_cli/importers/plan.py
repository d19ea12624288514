"""A mapping met with the channels of a file: which are read, with which clock and conversion."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from sstl_cli.core.errors import SstlError, nearest
from sstl_cli.core.units import Linear, conversion, is_unit, unit_of
from sstl_cli.importers.base import Channel, Layout, detect
from sstl_cli.importers.finder import Finder, Recording, TimeBase, converted
from sstl_cli.importers.mapping import LABELS, REQUIRED, SIGNAL_DIMENSION, Reference, Source
from sstl_cli.importers.mapping import Mapping as MappingFile
from sstl_cli.importers.pattern import starts
from sstl_cli.importers.systems import system_of
from sstl_cli.importers.text_blocks import NAME, SIGN

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Signal:
    """One numeric column of the log: one channel, or the difference or norm of several, and its conversion."""

    target: str
    file: int
    channels: tuple[str, ...]
    convert: Linear
    clock: TimeBase
    norm: bool = False
    zeros: tuple[float, ...] = ()

    def recorded(self, columns: Mapping[str, object]) -> Array:
        """Return the recorded numbers, shape (n,), of channels of shape (n,), before the conversion."""
        values = [np.asarray(columns[c], np.float64) for c in self.channels]
        if self.zeros:
            values = [v - z for v, z in zip(values, self.zeros, strict=True)]
        if self.norm:
            with np.errstate(over="ignore"):
                return np.sqrt(sum((v * v for v in values), np.zeros(len(values[0]))))
        return values[0] if len(values) == 1 else values[0] - values[1]

    def values(self, columns: Mapping[str, object]) -> Array:
        """Return the numbers in the log's unit, shape (n,), of channels of shape (n,)."""
        return converted(self.recorded(columns), self.convert)


@dataclass(frozen=True)
class Plan:
    """Everything needed to read one recording into log columns."""

    files: tuple[Recording, ...]
    clock: TimeBase
    signals: tuple[Signal, ...]
    labels: dict[str, str]
    constants: dict[str, str | float]
    run_name: str
    content: tuple[Signal, Signal] | None = None
    notes: tuple[str, ...] = ()
    units: dict[str, str] = field(default_factory=dict)

    @property
    def clocks(self) -> list[TimeBase]:
        """Return every clock, the reference first."""
        return list(dict.fromkeys([self.clock, *(s.clock for s in self.signals)]))


def recordings(path: Path, mapping: MappingFile, wanted: str | None) -> list[Recording]:
    """Return the recordings in a file: one, or one for each prefix under which a run's columns stand."""
    chosen = detect(path, wanted or mapping.format)
    layout = Layout(**mapping.text.model_dump())
    channels = tuple(chosen.channels(path, layout))
    if not channels:
        raise SstlError(
            f"holds no channel with numbers ({chosen.TITLE})", where=str(path), fix="check that it is the right file", code="E333"
        )
    whole = Recording(path, chosen, channels, layout)
    prefixes = _prefixes([c.name for c in channels if not c.text], mapping)
    return [replace(whole, prefix=p) for p in prefixes] or [whole]


def _prefixes(names: list[str], mapping: MappingFile) -> list[str]:
    if mapping.runs is not None:
        return list(dict.fromkeys(found for found in starts(mapping.runs, names) if found))
    needed = [n for n in REQUIRED if n not in mapping.columns]
    if len(needed) < len(REQUIRED) or all(n in names for n in needed):
        return []
    known = set(names)
    ends = [n[: -len(needed[0])] for n in names if n.endswith(needed[0])]
    return [p for p in ends if p and all(p + n in known for n in needed)]


def plan_of(files: list[Recording], mapping: MappingFile, labels: dict[str, str | float], run_name: str) -> Plan:
    """Return what to read from the files of one recording.

    Parameters
    ----------
    files : list of Recording
        One file, or several that hold different channels of one recording.
    labels : dict
        Labels from file names and the manifest.
    run_name : str
        The run's name where no channel or label gives one.

    Raises
    ------
    SstlError
        If a channel is missing or misspelt (the nearest is named), or a unit does not fit.
    """
    notes: list[str] = []
    find = Finder(files)
    time = mapping.columns.get("time_s")
    first = mapping.columns.get("tension_in_n")
    clock = _clock_of(time, first, find)
    signals: list[Signal] = []
    units: dict[str, str] = {}
    for target, dimension in SIGNAL_DIMENSION.items():
        if target == "time_s":
            continue
        source = mapping.columns.get(target)
        if source is None and not find.has(target):
            if target in REQUIRED:
                raise find.missing(target)
            continue
        source = source or find.canonical(target)
        signals.append(_signal(target, source, dimension, find, clock, notes))
        if source.as_ is not None:
            units[target] = source.unit
    content = None
    if mapping.clocks.content is not None:
        pair = [_signal(f"content {i + 1}", s, None, find, clock, notes) for i, s in enumerate(mapping.clocks.content)]
        content = (pair[0], pair[1])
    from_columns: dict[str, str] = {}
    for label in LABELS:
        source = mapping.columns.get(label)
        if source is not None:
            from_columns[label] = find.channel(source, label)[1].name
        elif label not in labels and label not in mapping.constants and find.has(label):
            from_columns[label] = find.channel(Source(column=label), label)[1].name
        if label not in from_columns and mapping.text.blocks is not None and find.has(SIGN + label):
            # the block's own line is nearer than the name of its file
            from_columns[label] = SIGN + label
    if mapping.text.blocks == "runs" and "run_id" not in from_columns:
        from_columns["run_id"] = _run_of_block(mapping, labels, signals, clock, find)
    constants = _constants(mapping, labels, from_columns, find.where)
    return Plan(tuple(files), clock, tuple(signals), from_columns, constants, run_name, content, tuple(notes), units)


def _run_of_block(mapping: MappingFile, labels: dict[str, str | float], signals: list[Signal], clock: TimeBase, find: Finder) -> str:
    """Return the channel that tells the blocks of a text file apart; SstlError where one name shall hold for all of them, or they have several clocks."""
    if not find.has(NAME):
        what, fix = "is no text file, and blocks are those of one", "take blocks out of the mapping"
    elif "run_id" in labels or "run_id" in mapping.constants:
        what, fix = "run_id is one for all blocks of the file", "leave it out: each block is called after the file, with its number"
    elif any(s.clock != clock for s in signals):
        what, fix = "blocks hold channels with clocks of their own", "split the file into one for each block"
    else:
        return NAME
    raise SstlError(what, where=find.where, fix=fix, code="E331")


def _constants(mapping: MappingFile, labels: dict[str, str | float], from_columns: Mapping[str, str], where: str) -> dict[str, str | float]:
    """Return the labels that are the same for the whole recording, checked; what a column says goes before them."""
    constants = {**labels, **{k: fill(v, labels) for k, v in mapping.constants.items()}}
    constants = {k: v for k, v in constants.items() if k in LABELS and k not in from_columns}
    if "system" not in constants and "system" not in from_columns:
        raise SstlError(
            "nothing says whether the recording is 'act' (single pass) or 'sstl' (double pass)",
            where=where,
            fix='give [constants] system = "act", or --map system=act',
            code="E334",
        )
    if "system" in constants:
        constants["system"] = system_of(constants["system"], where)
    if "lead_mm" in constants:
        constants["lead_mm"] = lead_of(constants["lead_mm"], where)
    return constants


def fill(value: str | float, names: dict[str, str | float]) -> str | float:
    """Return a constant with ``{name}`` replaced by what a file name or manifest gave."""
    if not isinstance(value, str):
        return value

    def named(found: re.Match[str]) -> str:
        if found[1] not in names:
            raise SstlError(
                f"'{value}' uses {{{found[1]}}}, which no file name or manifest gives",
                where="[constants]",
                fix=nearest(found[1], names) if names else "give file_name with a named group",
                code="E335",
            )
        return str(names[found[1]])

    return re.sub(r"\{(\w+)\}", named, value)


def lead_of(value: str | float, where: str) -> float:
    """Return the lead of the screw (mm); a log with decimal commas has one here too, as text among the labels.

    Raises
    ------
    SstlError
        E335 if it is no number.
    """
    try:
        return float(value.replace(",", ".") if isinstance(value, str) else value)
    except ValueError:
        raise SstlError(f"lead_mm is {value!r}", where=where, fix="give a number in mm", code="E335") from None


def _clock_of(time: Source | None, first: Source | None, find: Finder) -> TimeBase:
    if time is not None and time.rate_hz is not None:
        file = find.find(
            _reference(first) if first else "tension_in_n", "tension_in_n", first.file if first else None, bool(first and first.pattern)
        )[0]
        return TimeBase(file, None, Linear(1.0), time.rate_hz)
    if time is None and not find.has("time_s"):
        # a format with a clock of its own for each channel (robot logs, waveforms)
        if first is not None and first.time is not None:
            return _own_clock(first, find, None if first.several else find.channel(first, "tension_in_n"))
        try:
            file, channel = find.find(
                _reference(first) if first else "tension_in_n", "tension_in_n", first.file if first else None, bool(first and first.pattern)
            )
        except SstlError:
            raise find.missing("time_s") from None
        if channel.time:
            return TimeBase(file, channel.time, Linear(1.0))
        raise find.missing("time_s")
    source = time or Source(column="time_s")
    file, channel = find.channel(source, "time_s")
    unit = source.unit or (channel.unit if is_unit(channel.unit) and unit_of(channel.unit)[0] == "time" else "s")
    _require_seconds(channel, unit, find)
    made = conversion(unit, "time", gain=source.gain, offset=source.offset, sign=source.sign, where="time_s")
    return _with_fraction(TimeBase(file, channel.name, _scaled(made, source.scale)), source, find)


def _require_seconds(channel: Channel, unit: str, find: Finder) -> None:
    """Raise SstlError where times written as text shall be counted in another unit than the seconds they are read in."""
    if channel.stamps and unit_of(unit) != unit_of("s"):
        what = f"time_s: '{channel.name}' holds times as text, which are read in s, and its unit is given as {unit}"
        raise SstlError(what, where=find.where, fix='write unit = "s"', code="E302")


def _with_fraction(clock: TimeBase, source: Source, find: Finder) -> TimeBase:
    """Return a clock with the channel that tells its parts of a second, where its source names one."""
    if source.fraction is None:
        return clock
    where = re.escape(find.files[clock.file].path.name) + "$"
    _, channel = find.find(source.fraction, "fraction", where if len(find.files) > 1 else None)
    return replace(clock, fraction=channel.name, fraction_s=conversion(source.fraction_unit, "time", where="fraction").factor)


def _scaled(made: Linear, scale: float) -> Linear:
    return made if scale == 1.0 else replace(made, factor=made.factor * scale)


def _reference(source: Source) -> Reference:
    found = source.several[0] if source.several else source.column if source.column is not None else source.pattern
    assert found is not None
    return found


def _own_clock(source: Source, find: Finder, found: tuple[int, Channel] | None) -> TimeBase:
    assert source.time is not None
    file = source.file if source.file else (re.escape(find.files[found[0]].path.name) + "$" if found else None)
    at, channel = find.find(source.time, "time", file)
    _require_seconds(channel, source.time_unit, find)
    made = conversion(source.time_unit, "time", offset=source.time_offset, where="time")
    return _with_fraction(TimeBase(at, channel.name, _scaled(made, source.time_scale)), source, find)


def _signal(target: str, source: Source, dimension: str | None, find: Finder, clock: TimeBase, notes: list[str]) -> Signal:
    if source.several:
        found = [find.find(r, target, source.file) for r in source.several]
        if len({at for at, _ in found}) > 1:
            raise SstlError(
                f"{target}: a difference or norm needs channels of one file",
                where=find.where,
                fix='say which file = "..." in the mapping',
                code="E331",
            )
    else:
        found = [find.channel(source, target)]
    file, channel = found[0]
    if source.time is not None:
        clock = _own_clock(source, find, found[0])
    elif clock.rate_hz is None and channel.time and channel.time not in (clock.channel, find.time_beside(clock)):
        clock = TimeBase(file, channel.time, Linear(1.0))
    elif file != clock.file:
        name = channel.time or (clock.channel or "")
        if name not in {c.name for c in find.files[file].channels}:
            raise find.without_time(target, file)
        # a file of the same channels has its own copy of the clock
        clock = replace(clock, file=file) if name == clock.channel else TimeBase(file, name, clock.convert)
    convert = _scaled(_convert(target, source, channel, dimension, notes), source.scale)
    names = tuple(c.name for _, c in found)
    return Signal(target, file, names, convert, clock, source.norm is not None, source.zeros or ())


def _convert(target: str, source: Source, channel: Channel, dimension: str | None, notes: list[str]) -> Linear:
    if dimension is None:
        return Linear(1.0)
    if source.as_ is not None:
        # an output that is no tension keeps its numbers; the provenance says what it is
        return Linear(source.sign * (source.gain if source.gain is not None else 1.0), source.offset)
    base = {"force": "N", "length": "mm"}[dimension]
    unit = source.unit
    if not unit and channel.name.split("/")[-1].split(".")[-1] not in SIGNAL_DIMENSION:
        unit = channel.unit if is_unit(channel.unit) else ""
        notes.append(f"{target}: unit of '{channel.name}' taken as {unit or base}, the mapping gives none")
    return conversion(
        unit or base,
        dimension,
        gain=source.gain,
        radius_mm=source.radius_mm,
        area_mm2=source.area,
        offset=source.offset,
        sign=source.sign,
        where=target,
    )
