"""A text log that is still being written: whole new lines as pieces of runs, at every look."""

from __future__ import annotations

import os
import re
import stat
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import IO

import numpy as np
import pyarrow as pa
import pyarrow.compute as pac
import pyarrow.csv as pc

from sstl_cli.core.errors import SstlError
from sstl_cli.core.run_parts import SIGNALS, TEXTS
from sstl_cli.core.runs import Run
from sstl_cli.importers.mapping import Mapping
from sstl_cli.importers.plan import Plan, plan_of, recordings
from sstl_cli.importers.seen import Seen
from sstl_cli.importers.sources import Labels, labels_of
from sstl_cli.importers.systems import known_system
from sstl_cli.importers.text_cells import MISSING, SPACES
from sstl_cli.importers.text_file import wide
from sstl_cli.importers.text_layout import MAX_LINE_BYTES, TextLayout, layout_of
from sstl_cli.importers.text_stamps import StampReader
from sstl_cli.importers.text_whole import records_of

READ_BYTES = 4 << 20
# the layout of a text is told from its first lines: wait for some
ENOUGH_LINES = 8


class TextFollower:
    """Follows one text file; another one in its place is begun anew, the same one written once more goes on where it was.

    Parameters
    ----------
    path : Path
        The file; it need not exist yet.
    mapping : Mapping
        Columns, units and labels as for ``sstl import``; one file, one clock.
    """

    def __init__(self, path: Path, mapping: Mapping) -> None:
        if mapping.files.merge != "no" or mapping.runs is not None or mapping.text.blocks is not None:
            raise SstlError(
                "a mapping that merges or splits files cannot follow one", where=str(path), fix="import the finished files", code="E356"
            )
        self.path, self.mapping = path, mapping
        self.set_aside: dict[str, int] = {}
        self.notes: list[str] = []
        self.restarts = 0
        self._file: IO[bytes] | None = None
        self._plan: Plan | None = None
        self._begin()

    def _begin(self) -> None:
        self._rest = b""
        self._seen = Seen()
        self._rows = 0
        self._skip = self.mapping.skip_samples
        self._stamps: dict[str, StampReader] = {}

    @property
    def run_name(self) -> str:
        """The run's name where no column gives one; every restart of the file is another run."""
        name = self.path.stem if self._plan is None else self._plan.run_name
        return f"{name}+{self.restarts}" if self.restarts else name

    def look(self, last: bool = False) -> Iterator[Run]:
        """Yield what has been written since the last look; ``last`` says that nothing more will come.

        Raises
        ------
        SstlError
            If the file is no text, or the mapping does not fit it.
        """
        replaced = self._replaced()
        if replaced is None:
            # what has been read is being written once more
            return
        if replaced:
            # what was written before the file was renamed still counts
            yield from self._read(True)
            self._close()
        if self._file is None:
            try:
                if not stat.S_ISREG(os.stat(self.path).st_mode):
                    # a pipe would be waited for without an end, and cannot be looked at again
                    raise SstlError("is no regular file", where=str(self.path), fix="let the recorder write one", code="E356")
                self._file = open(self.path, "rb")
            except FileNotFoundError:
                return
            except OSError as error:
                raise SstlError(f"cannot be read: {error.strerror}", where=str(self.path), code="E356") from None
        yield from self._read(last)

    def _close(self) -> None:
        if self._file is not None:
            self._file.close()
            self._file = None
        if self._plan is not None:
            self.restarts += 1
            self.notes.append(f"{self.path} was begun anew; what follows is another run")
        self._plan = None
        self._begin()

    def _replaced(self) -> bool | None:
        """Whether another file has taken the name; one written over is begun anew at once. None: it has not come as far again as it was read.

        Some recorders write their whole file once more for every line, in its place or as another file of its name.
        """
        if self._file is None:
            return False
        here = os.fstat(self._file.fileno())
        if not self._seen.goes_on(self._file.fileno(), here.st_size):
            if here.st_size < self._seen.size and self._seen.begins(self._file.fileno(), here.st_size):
                return None
            self._close()
            return False
        try:
            there = os.stat(self.path)
            if (there.st_ino, there.st_dev) == (here.st_ino, here.st_dev):
                return False
            # a pipe would be waited for
            other = open(self.path, "rb") if stat.S_ISREG(there.st_mode) else None
        except OSError:
            # renamed, and nothing new yet
            return False
        if other is None:
            return True
        size = os.fstat(other.fileno()).st_size
        again = self._seen.begins(other.fileno(), size)
        if not again or size < self._seen.size:
            other.close()
            return not again
        other.seek(self._seen.size)
        self._file.close()
        self._file = other
        return False

    def _read(self, last: bool) -> Iterator[Run]:
        file = self._file
        if file is None:
            return
        if self._plan is None:
            if not self._ready(last):
                return
            file.seek(0)
            self._seen.add(file.read(self._layout.first_byte))
        end = self._layout.line_end
        while data := file.read(READ_BYTES):
            if not self._seen.goes_on(file.fileno(), os.fstat(file.fileno()).st_size):
                # written over since it was looked at, while what had been read was worked on: the next look begins it anew
                return
            self._seen.add(data)
            self._rest += data
            at = self._rest.rfind(end)
            if at < 0:
                if len(self._rest) > MAX_LINE_BYTES:
                    raise SstlError("a line is longer than 1 MiB", where=str(self.path), fix="is it text of one row a line?", code="E320")
                continue
            body, self._rest = self._rest[: at + len(end)], self._rest[at + len(end) :]
            yield from self._chunk(body.replace(end, b"\n"))

    def _ready(self, last: bool) -> bool:
        """Find layout and columns once enough lines are there."""
        try:
            with open(self.path, "rb") as file:
                head = file.read(READ_BYTES)
                if self._file is None or not os.path.sameopenfile(file.fileno(), self._file.fileno()):
                    # renamed before it could be told what its columns are
                    return False
        except OSError:
            return False
        lines = max(head.count(b"\n"), head.count(b"\r"))
        if lines < ENOUGH_LINES and not (last and lines > 1):
            return False
        try:
            found = recordings(self.path, self.mapping, self.mapping.format)[0]
        except SstlError as error:
            if error.code in ("E305", "E323") and not last and b"\0" not in head and len(head) < READ_BYTES:
                # a long preamble: the numbers are still to come
                return False
            raise
        if found.format.ID != "text":
            raise SstlError(
                f"is {found.format.TITLE}, which cannot grow in place",
                where=str(self.path),
                fix="give a folder in which finished files appear",
                code="E356",
            )
        labels: Labels = labels_of(self.path, self.mapping, {})
        name = str(labels.get("run_id", self.path.stem))
        self._plan = plan_of([replace(found, prefix="")], self.mapping, labels, name)
        if len(self._plan.clocks) > 1:
            self._plan = None
            raise SstlError(
                "channels with clocks of their own cannot be followed", where=str(self.path), fix="import the finished file", code="E356"
            )
        if wide(self.path):
            raise SstlError("is UTF-16 text, which cannot be followed", where=str(self.path), fix="import the finished file", code="E321")
        if records_of(self.path):
            raise SstlError(
                "is JSON as one value, which cannot be followed", where=str(self.path), fix="write one record a line", code="E323"
            )
        self._layout: TextLayout = layout_of(self.path, found.layout)
        return True

    def _chunk(self, body: bytes) -> Iterator[Run]:
        plan, layout = self._plan, self._layout
        assert plan is not None
        body = _plain(body, layout)
        if not body.strip():
            return
        columns = [c for s in plan.signals for c in s.channels]
        wanted = list(dict.fromkeys([*columns, *plan.clock.channels, *plan.labels.values()]))
        bad: list[int] = []

        def skip(row: object) -> str:
            bad.append(1)
            return "skip"

        table = pc.read_csv(
            pa.py_buffer(body),
            pc.ReadOptions(column_names=list(layout.names), use_threads=False, block_size=max(len(body) + 1, 1024)),
            pc.ParseOptions(
                delimiter="\t" if layout.delimiter == SPACES else layout.delimiter,
                quote_char='"' if layout.delimiter != SPACES else False,
                invalid_row_handler=skip,
            ),
            pc.ConvertOptions(column_types=dict.fromkeys(wanted, pa.string()), include_columns=wanted, check_utf8=False),
        )
        self._aside("lines of another width", len(bad))
        n = table.num_rows
        first = min(self._skip, n)
        self._skip -= first
        number = {c: self._read_column(c, table) for c in dict.fromkeys([*columns, *plan.clock.channels])}
        time = plan.clock.times(number, n, self._rows)
        self._rows += n
        signals = {"time_s": time[first:]}
        for s in plan.signals:
            if s.target in SIGNALS:
                signals[s.target] = s.values(number)[first:]
        labels = {k: table.column(c).to_pylist()[first:] for k, c in plan.labels.items()}
        yield from self._pieces(signals, labels)

    def _read_column(self, name: str, table: pa.Table) -> np.ndarray:
        """Return the numbers of a column, or the times that it holds as text; NaN where a cell holds none."""
        if not self._layout.stamps[self._layout.names.index(name)]:
            return _numbers(table.column(name), self._layout.decimal)
        reader = self._stamps.setdefault(name, StampReader())
        return np.array([_time(reader, c) for c in table.column(name).to_pylist()])

    def _pieces(self, signals: dict[str, np.ndarray], labels: dict[str, list[str | None]]) -> Iterator[Run]:
        """Yield the rows of each run; rows of several runs may take turns."""
        assert self._plan is not None
        n = len(signals["time_s"])
        rows: dict[tuple[str | None, ...], list[int]] = {}
        if labels:
            for i, key in enumerate(zip(*labels.values(), strict=True)):
                rows.setdefault(key, []).append(i)
        elif n:
            rows[()] = list(range(n))
        for key, at in rows.items():
            found: dict[str, str | float | None] = {**self._plan.constants, **dict(zip(labels, key, strict=True))}
            system = known_system(found.get("system"))
            if not system:
                self._aside("rows whose system is neither act nor sstl", len(at))
                continue
            text = {k: str(v) for k in TEXTS if (v := found.get(k)) is not None}
            some = {k: v[at] for k, v in signals.items()}
            yield Run(
                run_id=text.get("run_id", self.run_name),
                system=system,
                time_s=some["time_s"],
                tension_in_n=some["tension_in_n"],
                tension_out_n=some["tension_out_n"],
                config_id=text.get("config_id"),
                location=text.get("location"),
                lead_mm=_lead(found.get("lead_mm")),
                trajectory=text.get("trajectory"),
                position_in_mm=some.get("position_in_mm"),
                tension_ref_n=some.get("tension_ref_n"),
                tendon=text.get("tendon"),
                unit_in=self._plan.units.get("tension_in_n", "N"),
                unit_out=self._plan.units.get("tension_out_n", "N"),
            )

    def _aside(self, reason: str, count: int) -> None:
        if count:
            self.set_aside[reason] = self.set_aside.get(reason, 0) + count


def _plain(body: bytes, layout: TextLayout) -> bytes:
    """Return the lines as UTF-8, without comments and, for text cut by blanks, with one tab between columns."""
    try:
        body.decode()
    except UnicodeDecodeError:
        # labels in an older encoding, or damaged: shown as well as they can be; a number with such a byte is none
        body = body.decode("utf-8", "replace").encode()
    if layout.forms is not None:
        body = layout.forms.undone(body)
    if layout.comment:
        body = re.sub(rb"(?m)^[ \t]*" + re.escape(layout.comment.encode()) + rb".*$", b"", body)
    if layout.delimiter == SPACES:
        body = re.sub(rb"(?m)^[ \t]+|[ \t]+$", b"", body)
        body = re.sub(rb"[ \t]+", b"\t", body)
    return body


def _numbers(column: pa.ChunkedArray, decimal: str) -> np.ndarray:
    """Return the numbers of a text column, NaN where a cell holds none."""
    cells = pac.utf8_trim_whitespace(column)
    if decimal != ".":
        cells = pac.replace_substring(cells, decimal, ".")
    cells = pac.if_else(pac.is_in(cells, pa.array(list(MISSING))), pa.scalar(None, pa.string()), cells)
    try:
        return np.asarray(cells.cast(pa.float64()).to_numpy(), np.float64)
    except pa.ArrowInvalid:
        return np.array([_number(c) for c in cells.to_pylist()])


def _number(cell: str | None) -> float:
    try:
        return float(cell) if cell is not None and "_" not in cell else float("nan")
    except ValueError:
        return float("nan")


def _time(reader: StampReader, cell: str | None) -> float:
    try:
        return float(reader.seconds([cell or ""])[0])
    except ValueError:
        return float("nan")


def _lead(value: object) -> float | None:
    # in a log with decimal commas
    lead = _number(None if value is None else str(value).replace(",", "."))
    return lead if np.isfinite(lead) else None
