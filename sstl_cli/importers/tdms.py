"""LabVIEW TDMS: channels as ``group/channel``, with the waveform's own time as ``group/channel@time``."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any, Literal

import numpy as np

from sstl_cli.core.errors import SstlError
from sstl_cli.core.units import is_unit
from sstl_cli.importers.base import (
    Block,
    Channel,
    Layout,
    Notes,
    Values,
    check_declared,
    guarded,
    require_few,
    same_length,
    slices,
    text_array,
)
from sstl_cli.importers.guess_words import UNIT_CELLS

ID = "tdms"
TITLE = "a LabVIEW TDMS file"
EXTENSIONS = (".tdms",)
RANK = 35
MAX_SEGMENTS = 200_000
TIME = "@time"
MAX_PROPERTY = 200
_NEVER_SET = np.datetime64("1904-01-02")


def sniff(head: bytes, path: Path) -> bool:
    """Return whether the file begins with the TDMS lead-in."""
    return head.startswith(b"TDSm")


def channels(path: Path, layout: Layout) -> list[Channel]:
    """Return every channel; one with waveform properties brings its own time channel."""
    with guarded(path, TITLE), _open(path) as file:
        out: list[Channel] = []
        for name, channel in _channels(file, path):
            rows = len(channel)
            unit = str(channel.properties.get("unit_string", channel.properties.get("NI_UnitDescription", "")))
            # "Pounds": other spellings than the unit's own
            unit = unit if is_unit(unit) else UNIT_CELLS.get(unit.lower(), "")
            timed = _increment(channel) is not None
            own = _array_kind(channel)
            out.append(Channel(name, rows, unit or ("s" if own == "time" else ""), name + TIME if timed else "", text=own == "text"))
            if timed:
                out.append(Channel(name + TIME, rows, "s"))
        out += [Channel(name, 1, text=isinstance(value, str)) for name, value in _of_groups(file)]
        require_few(path, len(out))
        return out


def read(path: Path, numbers: list[str], labels: list[str], layout: Layout, notes: Notes) -> Iterator[Block]:
    """Yield blocks of the named channels."""
    wanted = list(dict.fromkeys([*numbers, *labels]))
    with guarded(path, TITLE), _open(path) as file:
        begin = _begin(file, path)
        columns: dict[str, Callable[[int, int], Values]] = {}
        lengths: dict[str, int] = {}
        origin: list[Any] = []
        for name, channel in _channels(file, path):
            if name in wanted:
                columns[name] = _cutter(channel, name in numbers, path, name, origin)
                lengths[name] = len(channel)
            if name + TIME in wanted:
                columns[name + TIME] = _clock(channel, begin)
                lengths[name + TIME] = len(channel)
        for name, value in _of_groups(file):
            if name in wanted:
                columns[name], lengths[name] = _constant(value, name in numbers, path, name), 1
        rows = same_length(path, lengths)
        columns = {n: c if lengths[n] > 1 or rows == 1 else partial(_first_of, c) for n, c in columns.items()}
        yield from slices(rows, columns, path.stat().st_size)


def remarks(path: Path) -> list[str]:
    """Return the properties of the file and its groups in words, and the start of its waveforms, as ``name: text``."""
    with guarded(path, TITLE), _open(path) as file:
        held = [file.properties, *(group.properties for group in file.groups())]
        begin = _begin(file, path)
        start = [] if begin is None else [f"start: {begin}"]
        return start + [
            f"{name}: {value}" for properties in held for name, value in properties.items() if isinstance(value, (str, int, float))
        ]


def _of_groups(file: Any) -> Iterator[tuple[str, str | float]]:
    """Yield the properties of groups that hold one value, as channels of one (``run01/@bend_deg``)."""
    for group in file.groups():
        for key, value in group.properties.items():
            if isinstance(value, (str, int, float)) and len(str(value)) <= MAX_PROPERTY:
                yield f"{group.name}/@{key}", value if isinstance(value, str) else float(value)


def _constant(value: str | float, number: bool, path: Path, name: str) -> Callable[[int, int], Values]:
    """Return a cutter for a property."""
    if number and isinstance(value, str):
        raise SstlError(f"'{name}' holds text, not numbers", where=str(path), fix="map another channel", code="E328")
    return lambda a, b: np.array([value], np.float64) if number else text_array(np.array([value]))


def _first_of(cut: Callable[[int, int], Values], a: int, b: int) -> Values:
    """Return the only value of a channel, whichever rows are asked for."""
    return cut(0, 1)


@contextmanager
def _open(path: Path) -> Iterator[Any]:
    from nptdms import TdmsFile
    from nptdms.log import log_manager

    _check_lead_ins(path)
    # the library tells its log about every odd byte; what matters is raised
    log_manager.set_level(logging.CRITICAL)
    # opened by handle, as an index file beside it could belong to another recording
    with open(path, "rb") as handle:
        yield TdmsFile(handle, read_metadata_only=True, keep_open=True)


def _check_lead_ins(path: Path) -> None:
    """Walk the segments by their lead-ins: each must go forward and stay in the file."""
    size = path.stat().st_size
    with open(path, "rb") as file:
        at = count = 0
        while at < size:
            file.seek(at)
            lead = file.read(28)
            if len(lead) < 28:
                raise SstlError("ends inside a segment", where=str(path), fix="record or copy it again", code="E310")
            if lead[:4] != b"TDSm":
                raise SstlError(f"has no segment at byte {at}", where=str(path), fix="record or copy it again", code="E310")
            order: Literal["big", "little"] = "big" if int.from_bytes(lead[4:8], "little") & 64 else "little"
            length = int.from_bytes(lead[12:20], order)
            raw = int.from_bytes(lead[20:28], order)
            if length == 0xFFFFFFFFFFFFFFFF:
                raise SstlError(
                    "was not closed by the recorder (open last segment)", where=str(path), fix="let the recorder finish", code="E310"
                )
            if raw > length or at + 28 + length > size:
                raise SstlError(
                    f"declares a segment of {length:.3g} bytes, {size - at - 28} are left",
                    where=str(path),
                    fix="truncated or damaged: record or copy it again",
                    code="E310",
                )
            at += 28 + length
            count += 1
            if count > MAX_SEGMENTS:
                raise SstlError(f"has more than {MAX_SEGMENTS} segments", where=str(path), fix="defragment it", code="E312")


def _channels(file: Any, path: Path) -> Iterator[tuple[str, Any]]:
    size = path.stat().st_size
    for group in file.groups():
        for channel in group.channels():
            if channel.data_type is None or not len(channel):
                continue
            check_declared(path, len(channel) * 8, f"channel '{channel.name}'", size)
            yield f"{group.name}/{channel.name}", channel


def _array_kind(channel: Any) -> str:
    kind = getattr(channel.data_type, "__name__", "")
    return "text" if kind == "String" else "time" if kind == "TimeStamp" else "number"


def _increment(channel: Any) -> float | None:
    step = channel.properties.get("wf_increment")
    return float(step) if isinstance(step, (int, float)) and 0 < float(step) < 1e9 else None


def _start(channel: Any) -> np.datetime64 | None:
    start = channel.properties.get("wf_start_time")
    # one that was never set stands for year 1 or 1904, as LabVIEW counts from there
    return start if isinstance(start, np.datetime64) and start > _NEVER_SET else None


def _begin(file: Any, path: Path) -> np.datetime64 | None:
    """Return the earliest start of the waveforms in a file, from which the clocks of all count."""
    starts = [start for _, channel in _channels(file, path) if _increment(channel) is not None and (start := _start(channel)) is not None]
    return min(starts, default=None)


def _clock(channel: Any, begin: np.datetime64 | None) -> Any:
    step, offset = _increment(channel) or 1.0, float(channel.properties.get("wf_start_offset", 0.0))
    start = _start(channel)
    # a channel that was started later than another of its file is no sample of the same rows
    late = (start - begin) / np.timedelta64(1, "ns") * 1e-9 if start is not None and begin is not None else 0.0
    return lambda a, b: late + offset + step * np.arange(a, b, dtype=np.float64)


def _cutter(channel: Any, number: bool, path: Path, name: str, origin: list[Any]) -> Any:
    def piece(a: int, b: int) -> Values:
        values = np.asarray(channel.read_data(offset=a, length=b - a))
        if not number:
            return text_array(values)
        if values.dtype.kind == "M":
            if not origin:
                origin.append(values[0])
            return (values - origin[0]) / np.timedelta64(1, "ns") * 1e-9
        if values.dtype.kind not in "biuf":
            raise SstlError(f"'{name}' holds text, not numbers", where=str(path), fix="map another channel", code="E328")
        return values.astype(np.float64)

    return piece
