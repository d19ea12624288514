"""Channels of the files of one recording, found by name, number or pattern; a miss names the nearest."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from sstl_cli.core.errors import SstlError, nearest
from sstl_cli.core.units import Linear, is_force, is_unit
from sstl_cli.importers.base import Channel, Format, Layout
from sstl_cli.importers.mapping import TENSIONS, Reference, Source
from sstl_cli.importers.pattern import search
from sstl_cli.importers.text import require_once


@dataclass(frozen=True)
class Recording:
    """One input file: its format and channels; ``prefix`` where it holds several runs side by side."""

    path: Path
    format: Format
    channels: tuple[Channel, ...]
    layout: Layout
    prefix: str = ""


@dataclass(frozen=True)
class TimeBase:
    """A clock: the file and channel that tell the time, or a constant rate; ``fraction`` tells the parts of a second, of ``fraction_s`` each."""

    file: int
    channel: str | None
    convert: Linear
    rate_hz: float | None = None
    fraction: str | None = None
    fraction_s: float = 0.0

    @property
    def channels(self) -> list[str]:
        """Names of the channels that tell the time."""
        return [c for c in (self.channel, self.fraction) if c is not None]

    def times(self, columns: Mapping[str, object], n: int, first: int) -> NDArray[np.float64]:
        """Return the times (s) of ``n`` rows, the first of which is row ``first`` of the file, shape (n,)."""
        if self.rate_hz is not None:
            return np.asarray((np.arange(n) + first) / self.rate_hz)
        assert self.channel is not None
        times = converted(np.asarray(columns[self.channel], np.float64), self.convert)
        return times if self.fraction is None else times + self.fraction_s * np.asarray(columns[self.fraction], np.float64)


def converted(values: NDArray[np.float64], convert: Linear) -> NDArray[np.float64]:
    """Return recorded numbers in the log's unit, shape (n,); those that need no conversion keep every bit."""
    with np.errstate(over="ignore", invalid="ignore"):
        if convert.offset:
            values = values - convert.offset
        return values if convert.factor == 1.0 else values * convert.factor


class Finder:
    """Channels of the files of one recording, by name, number or pattern."""

    def __init__(self, files: list[Recording]) -> None:
        self.files = files
        self.where = str(files[0].path) if len(files) == 1 else f"{files[0].path} and {len(files) - 1} more"

    def has(self, name: str) -> bool:
        self._once(name)
        return any(f.prefix + name == c.name for f in self.files for c in f.channels)

    def _once(self, name: str) -> None:
        """Raise SstlError if a text file's header holds a name more than once (they are numbered there)."""
        for file in self.files:
            if file.format.ID == "text":
                require_once(name, {c.name for c in file.channels}, str(file.path))

    def canonical(self, name: str) -> Source:
        """Return the source of a column that has the log's own name, in the unit that the file states for it."""
        channel = next(c for f in self.files for c in f.channels if f.prefix + name == c.name)
        if name in TENSIONS and channel.unit and not is_force(channel.unit):
            # a log whose output is no tension comes back as it was
            return Source.model_validate({"column": name, "unit": channel.unit, "as": "N"})
        return Source(column=name, unit=channel.unit if is_unit(channel.unit) else "")

    def time_beside(self, clock: TimeBase) -> str:
        """Return the time channel of the topic that a clock's own channel stands in."""
        return next((c.time for c in self.files[clock.file].channels if c.name == clock.channel), "")

    def without_time(self, target: str, file: int) -> SstlError:
        """Return the error for a channel of another file than the clock's that has no time of its own."""
        channels = self.files[file].channels
        times = [c.name for c in channels if re.search(r"(?i)time|zeit|temps|tiempo|stamp|^t$|^t[_ \[(]", c.name)]
        shown = f'"{times[0]}"' if times else f'"..." (one of {", ".join(c.name for c in channels[:6])})'
        return SstlError(
            f"{target}: stands in another file than time_s, and it is not said which channel there is its time",
            where=str(self.files[file].path),
            fix=f'write {target} = {{ ..., time = {shown} }}, or merge = "rows" where row n of both belongs together',
            code="E339",
        )

    def missing(self, name: str) -> SstlError:
        names = [c.name.removeprefix(f.prefix) for f in self.files for c in f.channels if c.name.startswith(f.prefix)]
        return SstlError(
            f"misses column '{name}'",
            where=self.where,
            fix=f"{nearest(name, names)}; give a mapping, or try sstl import --guess",
            code="E336",
        )

    def channel(self, source: Source, target: str) -> tuple[int, Channel]:
        """Return the file number and channel of a source given by name, number or pattern."""
        wanted = source.column if source.column is not None else source.pattern
        assert wanted is not None
        return self.find(wanted, target, source.file, pattern=source.column is None)

    def find(self, wanted: Reference, target: str, file: str | None, pattern: bool = False) -> tuple[int, Channel]:
        fits = search(file, [f.path.name for f in self.files]) if file is not None else [{}] * len(self.files)
        pool = [(i, f) for i, f in enumerate(self.files) if fits[i] is not None]
        if not pool:
            names = ", ".join(f.path.name for f in self.files)
            raise SstlError(f"{target}: no file name matches '{file}'", where=self.where, fix=f"files: {names}", code="E337")
        found = [(i, c) for i, f in pool for c in self._match(f, wanted, pattern)]
        if len(found) == 1:
            return found[0]
        known = [c.name.removeprefix(f.prefix) for _, f in pool for c in f.channels]
        if not found and isinstance(wanted, int):
            raise SstlError(
                f"{target}: column {wanted} does not exist", where=self.where, fix=f"there are {len(known)}, counted from 1", code="E336"
            )
        if not found:
            self._once(str(wanted))
            fix = nearest(str(wanted), known) if not pattern else nearest("", known)
            raise SstlError(f"{target}: misses column '{wanted}'", where=self.where, fix=fix, code="E336")
        shown = ", ".join(c.name for _, c in found[:6])
        raise SstlError(
            f"{target}: '{wanted}' fits {len(found)} channels ({shown})",
            where=self.where,
            fix='make the pattern tighter, or say which file = "..."',
            code="E338",
        )

    def _match(self, file: Recording, wanted: Reference, pattern: bool) -> list[Channel]:
        under = [c for c in file.channels if c.name.startswith(file.prefix)]
        if isinstance(wanted, int):
            return [under[wanted - 1]] if 1 <= wanted <= len(under) else []
        if pattern:
            fits = search(wanted, [c.name.removeprefix(file.prefix) for c in under])
            return [c for c, fit in zip(under, fits, strict=True) if fit is not None]
        exact = [c for c in under if c.name.removeprefix(file.prefix) == wanted]
        number = re.fullmatch(r"col(\d{1,6})", wanted)
        return exact or (self._match(file, int(number[1]), False) if number else [])
