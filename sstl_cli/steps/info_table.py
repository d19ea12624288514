"""What a table holds: its runs block by block, the loop of the first, or the ranges of its columns.

Pandas takes a second to load and would be imported by Arrow's own grouping, by arrays made of lists, and by some
conversions: none of these is used here.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc

from sstl_cli.core.aside import LISTED, Aside
from sstl_cli.core.documents.logs import ColumnRange
from sstl_cli.core.errors import SstlError
from sstl_cli.core.parquet import ROWS_PER_BLOCK, conform
from sstl_cli.core.sound import LARGEST, LEAST_SAMPLES, OPTIONAL, SMALLEST, too_short, too_small, unsound, why_unsound
from sstl_cli.core.tables import LOG, Schema
from sstl_cli.steps import info
from sstl_cli.steps.info import RunSummary, draw_loop

COLUMNS = ("run_id", "config_id", "system", "location", "time_s", "tension_in_n", "tension_out_n")
# not shown, but read for values that nothing can have measured
JUDGED = ("lead_mm", *OPTIONAL)
LOOP_POINTS = 3000
LABELS = ("status", "phase", "method", "variant", "window")


def runs_of(reader: Any) -> tuple[list[RunSummary], list[Aside]]:
    """Return a summary of every run of a log, and what no recorder can have given."""
    lost = _Lost()
    runs = info.run(s for table in _tables(reader) for s in _summaries(table, lost))
    return runs, list(lost.entries(runs))


def told(runs: Sequence[RunSummary]) -> tuple[list[RunSummary], int]:
    """Return the runs that a document lists, and how many it leaves out: those of fewer than 16 samples beyond the first LISTED of them."""
    short = [r.samples < LEAST_SAMPLES for r in runs]
    nth = np.cumsum(short).tolist()
    found = [r for r, brief, n in zip(runs, short, nth, strict=True) if not brief or n <= LISTED]
    return found, len(runs) - len(found)


def loop_of(reader: Any, first: RunSummary) -> list[str]:
    """Return the drawing of the first run's loop, read from as many row groups as it needs."""
    stride = max(1, first.samples // LOOP_POINTS)
    x: list[float] = []
    y: list[float] = []
    left = first.samples
    run_id: Any = None
    for table in _tables(reader):
        # an Arrow scalar: converting a Python string would import pandas
        run_id = table.column("run_id")[0] if run_id is None else run_id
        mine = table.filter(pc.equal(table.column("run_id"), run_id))
        left -= len(mine)
        x += mine.column("tension_in_n").to_pylist()[::stride]
        y += mine.column("tension_out_n").to_pylist()[::stride]
        if left <= 0:
            break
    return draw_loop(x, y)


def ranges_of(table: Any) -> dict[str, ColumnRange]:
    """Return count of nulls, minimum, mean and maximum of each number column, and counts of each label, by column."""
    ranges: dict[str, ColumnRange] = {}
    for name in table.column_names:
        column = table.column(name)
        if pa.types.is_floating(column.type) or pa.types.is_integer(column.type):
            ends = pc.min_max(column).as_py()
            ranges[name] = ColumnRange(nulls=column.null_count, min=ends["min"], mean=pc.mean(column).as_py(), max=ends["max"])
        else:
            counts = pc.value_counts(column).to_pylist()
            by_label = {"counts": {str(c["values"]): int(c["counts"]) for c in counts}} if name in LABELS else {}
            ranges[name] = ColumnRange(nulls=column.null_count, distinct=len(counts), **by_label)
    return ranges


def _tables(reader: Any) -> Iterator[Any]:
    # only what is shown is read; empty values are for sstl check to judge
    wanted = Schema(LOG.id, LOG.version, tuple(_relaxed(c) for c in LOG.columns if c.name in (*COLUMNS, *JUDGED)))
    present = [n for n in (*COLUMNS, *JUDGED) if n in reader.file.schema_arrow.names]
    try:
        for batch in reader.file.iter_batches(ROWS_PER_BLOCK, columns=present):
            yield conform(pa.Table.from_batches([batch]), wanted, str(reader.path))
    except (pa.ArrowException, OSError) as error:
        raise SstlError(f"is damaged ({str(error)[:120]})", where=str(reader.path), fix="make the file again", code="E241") from None


def _relaxed(column: Any) -> Any:
    return replace(column, nullable=True)


class _Lost:
    """Values that no recorder can have given, counted by run and reason; the ranges shown leave them out."""

    def __init__(self) -> None:
        self.by_run: dict[str, dict[str, int]] = {}

    def ranges(self, name: str, column: Any, starts: Any, run_ids: list[str]) -> tuple[list[float], list[float]]:
        """Return the smallest and largest sound value of each stretch of rows (NaN where it has none), and count the others.

        Parameters
        ----------
        column : Arrow chunked array, shape (n,)
            The values; empty ones are for sstl check to judge.
        starts : ndarray of int, shape (m,)
            First row of each stretch.
        run_ids : list of str
            The run of each stretch.
        """
        null = pc.is_null(column)
        empty = _numpy(pc.cast(null, "uint8")).astype(bool)
        values = _filled(column)
        wrong = unsound(values)
        with_faults = np.logical_or.reduceat(wrong, starts)
        out = wrong | empty
        ends = [*starts.tolist()[1:], len(values)]
        for i in np.flatnonzero(with_faults).tolist():
            rows = slice(starts[i], ends[i])
            self._add(run_ids[i], name, values[rows][~empty[rows]])
        low = np.minimum.reduceat(np.where(out, np.inf, values), starts)
        high = np.maximum.reduceat(np.where(out, -np.inf, values), starts)
        none = low > high
        return np.where(none, np.nan, low).tolist(), np.where(none, np.nan, high).tolist()

    def look(self, name: str, column: Any, starts: Any, run_ids: list[str]) -> None:
        """Count the unsound values of a column that may be empty; NaN is no fault there: it says "not measured"."""
        held = column.drop_null()
        if not len(held):
            return
        ends = pc.min_max(held)
        if max(abs(ends["min"].as_py()), abs(ends["max"].as_py())) <= LARGEST:
            return
        values = _filled(column)
        for run_id, a, b in zip(run_ids, starts.tolist(), [*starts.tolist()[1:], len(values)], strict=True):
            rows = values[a:b]
            self._add(run_id, name, rows[unsound(rows) & ~np.isnan(rows)])

    def _add(self, run_id: str, name: str, values: Any) -> None:
        for why, n in why_unsound(name, values).items():
            counts = self.by_run.setdefault(run_id, {})
            counts[f"{why} in {name}"] = counts.get(f"{why} in {name}", 0) + n

    def entries(self, runs: list[RunSummary]) -> Iterator[Any]:
        """Yield what was left out, one entry a run and reason, and runs that no sensor can have given."""
        for run in runs:
            for why, n in self.by_run.get(run.run_id, {}).items():
                yield Aside(run.run_id, n, run.samples, why)
            ranges = {"tension_in_n": (run.in_min_n, run.in_max_n), "tension_out_n": (run.out_min_n, run.out_max_n)}
            for name, ends in ranges.items():
                # an array a run takes longer than all else; where neither end is small there is nothing to say
                if max(-ends[0], ends[1]) < SMALLEST and (said := too_small(name, np.array(ends))):
                    yield Aside(run.run_id, run.samples, run.samples, said)
            if run.samples > 1 and (said := too_short((run.end_s - run.start_s) / (run.samples - 1))):
                yield Aside(run.run_id, run.samples, run.samples, said)


def _summaries(table: Any, lost: _Lost) -> Iterator[RunSummary]:
    """Yield a summary of each stretch of one run_id (Arrow's own grouping would import pandas)."""
    ids = table.column("run_id").combine_chunks()
    ids = ids.combine_chunks() if isinstance(ids, pa.ChunkedArray) else ids
    ends = pc.run_end_encode(ids).run_ends.to_pylist()
    if not ends:
        return
    starts = np.array([0, *ends[:-1]], np.int64)
    # an Arrow array made of a list, or of an array, would import pandas
    rows = np.diff([0, *ends]).tolist()
    first = pa.Array.from_buffers(pa.int64(), len(starts), [None, pa.py_buffer(starts)])
    labels = [table.column(n).take(first).to_pylist() for n in ("run_id", "system", "config_id", "location")]
    run_ids = [str(v) for v in labels[0]]
    for name in JUDGED:
        lost.look(name, table.column(name), starts, run_ids)
    limits = [v for name in COLUMNS[-3:] for v in lost.ranges(name, table.column(name), starts, run_ids)]
    for run_id, system, config_id, location, n, *six in zip(run_ids, *labels[1:], rows, *limits, strict=True):
        yield RunSummary(run_id, system, config_id, location, n, *six)


def _filled(column: Any) -> Any:
    """Return an Arrow column as an array of floats, with a number in the place of empty values; a Python one would import pandas."""
    any_number = pc.cast(pc.cast(pc.is_null(column), "uint8"), "double")
    return _numpy(pc.coalesce(pc.cast(column, "double"), any_number)).astype(np.float64)


def _numpy(column: Any) -> Any:
    """Return an Arrow column without nulls as an array; Arrow's own way there would import pandas."""
    held = column.combine_chunks()
    return np.from_dlpack(held if isinstance(held, pa.Array) else pa.concat_arrays(held.chunks))
