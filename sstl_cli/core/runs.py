"""One uninterrupted recording in memory, and log files as streams of them."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Collection, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TypeVar

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from sstl_cli.core.aside import LISTED, Aside
from sstl_cli.core.errors import SstlError
from sstl_cli.core.parquet import TableWriter, open_table
from sstl_cli.core.provenance import Provenance
from sstl_cli.core.sound import CHANNELS, LEAST_SAMPLES, OPTIONAL, TENSIONS, note, noted
from sstl_cli.core.tables import LOG, TENDON
from sstl_cli.core.units import is_force

Array = NDArray[np.float64]
T = TypeVar("T")
SIGNALS = CHANNELS
LABELS = ("run_id", "config_id", "system", "location", "lead_mm", "trajectory", "tendon")
TEXTS = tuple(n for n in LABELS if n != "lead_mm")
PASSES = {"act": 1, "sstl": 2}


@dataclass(frozen=True)
class Run:
    """One run: labels and equally long float64 arrays (time in s, tensions in N, position in mm).

    ``unit_in`` and ``unit_out`` differ from N where the log's mapping declared an input or output that is no tension.
    """

    run_id: str
    system: str
    time_s: Array
    tension_in_n: Array
    tension_out_n: Array
    config_id: str | None = None
    location: str | None = None
    lead_mm: float | None = None
    trajectory: str | None = None
    position_in_mm: Array | None = None
    tension_ref_n: Array | None = None
    tendon: str | None = None
    extra: dict[str, Array] = field(default_factory=dict)
    unit_in: str = "N"
    unit_out: str = "N"

    @property
    def units(self) -> dict[str, str]:
        """Units of the two tension columns, by column name."""
        return {"tension_in_n": self.unit_in, "tension_out_n": self.unit_out}

    def __len__(self) -> int:
        return len(self.time_s)

    def cut(self, rows: slice | NDArray[np.bool_]) -> Run:
        """Return the run with these samples of every channel."""

        def kept(values: Array | None) -> Array | None:
            return None if values is None else values[rows]

        return replace(
            self,
            time_s=self.time_s[rows],
            tension_in_n=self.tension_in_n[rows],
            tension_out_n=self.tension_out_n[rows],
            position_in_mm=kept(self.position_in_mm),
            tension_ref_n=kept(self.tension_ref_n),
            extra={k: v[rows] for k, v in self.extra.items()},
        )

    @property
    def passes(self) -> int:
        """Passes through the tube: 1 for act, 2 for sstl."""
        return PASSES[self.system]

    @property
    def dt_s(self) -> float:
        """Median sampling period in s (NaN for a single sample)."""
        return float(np.median(np.diff(self.time_s))) if len(self) > 1 else float("nan")


def run_table(run: Run, with_tendon: bool = False) -> pa.Table:
    """Return a run as a table of the log schema."""
    n = len(run)
    arrays: list[pa.Array] = []
    columns = [*LOG.columns, TENDON] if with_tendon else list(LOG.columns)
    for column in columns:
        value = getattr(run, column.name)
        if value is None:
            arrays.append(pa.nulls(n, column.type))
        elif isinstance(value, np.ndarray):
            # NaN in an optional channel means "not measured here"
            arrays.append(pa.array(value, column.type, from_pandas=column.nullable))
        else:
            arrays.append(pa.repeat(pa.scalar(value, column.type), n))
    schema = LOG.arrow()
    if with_tendon:
        schema = schema.append(pa.field(TENDON.name, TENDON.type, True, {"unit": "", "meaning": TENDON.meaning}))
    return pa.Table.from_arrays(arrays, schema=schema)


def write_runs(
    path: Path, runs: Iterable[Run], provenance: Provenance, force: bool = False, tendons: Callable[[], bool] = lambda: False
) -> int:
    """Write runs one by one (memory bounded by the largest) and return the number of samples.

    The log gets a column ``tendon`` if the first run names one, or ``tendons``, asked once that run is there, says so.

    Raises
    ------
    SstlError
        If there is no run, a run names a tendon after the file was begun without that column, or units differ.
    """
    samples = 0
    iterator = iter(runs)
    first = next(iterator, None)
    if first is None:
        raise SstlError("no run to write", where=str(path), fix="check the input for usable samples", code="E120")
    named = first.tendon is not None or tendons()
    with TableWriter(path, LOG.in_units(first.units), provenance, force, extra=[TENDON] if named else []) as writer:
        run: Run | None = first
        while run is not None:
            if run.tendon is not None and not named:
                where = f"{path}, run {run.run_id!r}"
                raise SstlError("names a tendon, the runs before it do not", where=where, fix="put it first", code="E127")
            require_units_of(run, first, path)
            writer.write(run_table(run, named))
            samples += len(run)
            run = next(iterator, None)
    return samples


def require_units_of(run: Run, first: Run, path: Path) -> None:
    """Raise SstlError E128 if a run is in other units than the first one of its log: one column has one unit."""
    if run.units != first.units:
        raise SstlError(
            f"is in {run.unit_in} and {run.unit_out}, the runs before it in {first.unit_in} and {first.unit_out}",
            where=f"{path}, run {run.run_id!r}",
            fix="give runs of other units a log of their own",
            code="E128",
        )


def read_runs(path: Path, skip: Collection[str] = ()) -> Iterator[Run]:
    """Yield the runs of a log in file order, made sound (see :mod:`sstl_cli.core.sound`): cut at pauses, without
    samples that no recorder can have given. A run that keeps no sample comes without any.

    Parameters
    ----------
    skip : collection of str
        Columns that may be null and are not needed: they are not read.

    Raises
    ------
    SstlError
        As :func:`recorded_runs`.
    """
    for run in recorded_runs(path, skip):
        yield from noted(run)


def read_logs(paths: Iterable[Path]) -> list[Run]:
    """Return the runs of several logs, file by file, as :func:`read_runs` yields them."""
    return [run for path in paths for run in read_runs(path)]


def few_short(runs: Iterable[Run], left: Callable[[Run], None] = lambda _: None) -> Iterator[Run]:
    """Yield runs; of those with fewer than 16 samples the first LISTED, the others are noted as set aside, and ``left`` is told.

    Nothing is learned from so short a run but that it is there, and one takes a kilobyte.
    """
    kept = 0
    for run in runs:
        if len(run) < LEAST_SAMPLES:
            if kept == LISTED:
                note([Aside(run.run_id, len(run), len(run), f"one of more than {LISTED} runs of fewer than {LEAST_SAMPLES} samples")])
                left(run)
                continue
            kept += 1
        yield run


def recorded_runs(path: Path, skip: Collection[str] = ()) -> Iterator[Run]:
    """Yield the runs of a log in file order, as they stand there; a run must be contiguous.

    Raises
    ------
    SstlError
        If the file is not a log or in other units, a required value is null, a label changes within a run, or a run
        comes in two pieces.
    """
    reader = open_table(path, LOG, coded=TEXTS)
    _require_units(reader.file.schema_arrow, str(path))
    yield from runs_of(ahead(reader.blocks(skip)), str(path), units_of(reader.file.schema_arrow))


def ahead(items: Iterator[T]) -> Iterator[T]:
    """Yield items while the next one is being made in a thread: decoding and the work on what was decoded overlap."""
    with ThreadPoolExecutor(1) as thread:
        coming = thread.submit(next, items, None)
        while (item := coming.result()) is not None:
            coming = thread.submit(next, items, None)
            yield item


def runs_of(blocks: Iterable[pa.Table], source: str, units: dict[str, str] | None = None) -> Iterator[Run]:
    """Yield the runs of tables that follow one another (columns of the log schema); ``source`` stands in errors.

    ``units`` are those that ``units_of`` finds where the tables come from (default: newtons).
    """
    pending: list[_Part] = []
    seen: set[str] = set()
    for block in blocks:
        for part in _parts(block):
            if pending and pending[0].labels["run_id"] != part.labels["run_id"]:
                yield _run(pending, source, seen, units)
                pending = []
            pending.append(part)
            for name in part.changes:
                raise _split(name, part, source)
            for name in TEXTS if part is not pending[0] else ():
                if part.labels.get(name) != pending[0].labels.get(name):
                    raise _split(name, part, source)
    if pending:
        yield _run(pending, source, seen, units)


def _split(name: str, part: _Part, source: str) -> SstlError:
    where = f"{source}, run {part.labels['run_id']!r}"
    return SstlError(f"{name} changes within the run", where=where, fix="split the run", code="E123")


@dataclass(frozen=True)
class _Part:
    """What one block holds of one run: its labels, the signals, which of them are null throughout, labels that change in it."""

    labels: dict[str, str | None]
    lead_mm: float | None
    signals: dict[str, Array]
    empty: frozenset[str]
    changes: tuple[str, ...]


def _parts(block: pa.Table) -> Iterator[_Part]:
    """Yield the runs of one block in order; its columns are decoded once, not run by run."""
    changes = {name: _changes(block.column(name)) for name in TEXTS if name in block.column_names}
    edges = np.concatenate(([0], changes["run_id"], [block.num_rows]))
    starts, ends = edges[:-1][np.diff(edges) > 0], edges[1:][np.diff(edges) > 0]
    if not len(starts):
        return
    labels = {name: _taken(block.column(name), starts) for name in changes}
    leads = block.column("lead_mm").take(pa.array(starts)).to_pylist()
    signals = {n: block.column(n) for n in SIGNALS if n in block.column_names}
    values = {n: _floats(c) for n, c in signals.items()}
    nulls = {n: _null_counts(c, starts, ends) for n, c in signals.items() if n in OPTIONAL}
    within = {n: np.searchsorted(at, starts, "right") != np.searchsorted(at, ends, "left") for n, at in changes.items()}
    for i, (a, b) in enumerate(zip(starts.tolist(), ends.tolist(), strict=True)):
        yield _Part(
            {n: None if v[i] is None else str(v[i]) for n, v in labels.items()},
            leads[i],
            {n: v[a:b] for n, v in values.items()},
            frozenset(n for n, count in nulls.items() if count[i] == b - a),
            tuple(n for n, changed in within.items() if changed[i]),
        )


def _floats(column: pa.ChunkedArray) -> Array:
    """Return a column as floats, NaN where it is null; one that is null throughout takes no memory."""
    if len(column) and column.null_count == len(column):
        return np.broadcast_to(np.nan, len(column))
    return np.asarray(column.cast(pa.float64()).to_numpy())


def _taken(column: pa.ChunkedArray, at: NDArray[np.int64]) -> list[object]:
    """Return the values at these positions."""
    if pa.types.is_run_end_encoded(column.type):
        ends, texts = _stretches(column)
        found: list[object] = texts.take(pa.array(np.searchsorted(ends, at, "right"))).to_pylist()
        return found
    return list(column.take(pa.array(at)).to_pylist())


def _stretches(column: pa.ChunkedArray) -> tuple[NDArray[np.int64], pa.Array]:
    """Return the ends and the texts of a run-end encoded column, one entry a stretch."""
    ends, texts, before = [], [], 0
    for chunk in column.chunks:
        first, count = chunk.find_physical_offset(), chunk.find_physical_length()
        stops = chunk.run_ends.to_numpy()[first : first + count].astype(np.int64) - chunk.offset
        ends.append(before + np.minimum(stops, len(chunk)))
        texts.append(chunk.values.slice(first, count))
        before += len(chunk)
    return np.concatenate(ends), pa.concat_arrays(texts)


def _null_counts(column: pa.ChunkedArray, starts: NDArray[np.int64], ends: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return how many values of each stretch are null."""
    if not column.null_count:
        return np.zeros(len(starts), np.int64)
    if column.null_count == len(column):
        return ends - starts
    total = np.concatenate(([0], np.cumsum(column.is_null().to_numpy())))
    return np.asarray(total[ends] - total[starts], np.int64)


def _changes(column: pa.ChunkedArray) -> NDArray[np.int64]:
    """Return the positions whose value differs from the one before (codes are compared, not texts)."""
    if pa.types.is_run_end_encoded(column.type):
        ends, texts = _stretches(column)
        words = texts.to_pylist()
        return np.asarray(ends[:-1][np.array([a != b for a, b in itertools.pairwise(words)], bool)], np.int64)
    values = column.combine_chunks() if column.num_chunks != 1 else column.chunk(0)
    if isinstance(values, pa.ChunkedArray):
        values = values.unify_dictionaries().combine_chunks()
    if pa.types.is_null(values.type) or values.null_count == len(values):
        return np.empty(0, np.int64)
    coded = values if pa.types.is_dictionary(values.type) else values.dictionary_encode()
    codes = coded.indices
    numbers = (codes.fill_null(-1) if codes.null_count else codes).to_numpy(zero_copy_only=False)
    at = np.flatnonzero(numbers[1:] != numbers[:-1]) + 1
    # a foreign file may hold one text under two codes
    texts = coded.dictionary
    if len(texts) != len(texts.unique()):
        at = np.array([i for i in at.tolist() if coded[i].as_py() != coded[i - 1].as_py()], np.int64)
    return at


def units_of(schema: pa.Schema) -> dict[str, str]:
    """Return ``unit_in`` and ``unit_out`` from the field metadata of a log; N where nothing is stated."""
    out = {}
    for name, column in (("unit_in", "tension_in_n"), ("unit_out", "tension_out_n")):
        stated = (schema.field(column).metadata or {}).get(b"unit", b"") if column in schema.names else b""
        out[name] = stated.decode("utf-8", "replace") or "N"
    return out


def _require_units(schema: pa.Schema, source: str) -> None:
    """Raise SstlError E129 if a column says that it is in another unit than the log's: its numbers would be taken for those."""
    for column in LOG.columns:
        stated = (schema.field(column.name).metadata or {}).get(b"unit", b"") if column.name in schema.names else b""
        unit = stated.decode("utf-8", "replace")
        # an input or output that is no tension keeps its own, as its mapping declared
        if unit in ("", column.unit) or (column.name in TENSIONS and not is_force(unit)):
            continue
        raise SstlError(
            f"column '{column.name}' is in {unit}, not {column.unit}", where=source, fix="convert it with sstl import", code="E129"
        )


def _run(parts: list[_Part], source: str, seen: set[str], units: dict[str, str] | None) -> Run:
    head = parts[0]
    run_id = head.labels["run_id"]
    where = f"{source}, run {run_id!r}"
    if str(run_id) in seen:
        raise SstlError("the run comes in two pieces", where=where, fix="sort the file by run_id", code="E122")
    seen.add(str(run_id))
    # NaN says "not given"; what no screw can have is for ``sound`` to tell
    lead = None if head.lead_mm is None or math.isnan(head.lead_mm) else head.lead_mm
    if head.labels["system"] not in PASSES:
        raise SstlError(f"system is {head.labels['system']!r}", where=where, fix="it must be 'act' or 'sstl'", code="E124")
    empty = frozenset.intersection(*(p.empty for p in parts))
    signals = {
        n: None if n in empty else head.signals[n] if len(parts) == 1 else np.concatenate([p.signals[n] for p in parts])
        for n in head.signals
    }
    return Run(**(units or {}), **head.labels, lead_mm=lead, **signals)  # type: ignore[arg-type]
