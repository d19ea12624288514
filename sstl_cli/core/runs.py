"""One uninterrupted recording in memory, and log files as streams of them."""

from __future__ import annotations

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
from sstl_cli.core.run_parts import TEXTS, Part, Pending, parts
from sstl_cli.core.sound import LEAST_SAMPLES, TENSIONS, note, noted
from sstl_cli.core.tables import LOG, TENDON
from sstl_cli.core.units import is_force

Array = NDArray[np.float64]
T = TypeVar("T")
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
    pending: Pending | None = None
    seen: set[str] = set()
    for block in blocks:
        for part in parts(block):
            if pending is not None and pending.head.labels["run_id"] != part.labels["run_id"]:
                yield _run(pending, source, seen, units)
                pending = None
            for name in part.changes:
                raise _split(name, part, source)
            if pending is None:
                pending = Pending(part)
                continue
            for name in TEXTS:
                if part.labels.get(name) != pending.head.labels.get(name):
                    raise _split(name, part, source)
            pending.add(part)
    if pending is not None:
        yield _run(pending, source, seen, units)


def _split(name: str, part: Part, source: str) -> SstlError:
    where = f"{source}, run {part.labels['run_id']!r}"
    return SstlError(f"{name} changes within the run", where=where, fix="split the run", code="E123")


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


def _run(pending: Pending, source: str, seen: set[str], units: dict[str, str] | None) -> Run:
    head = pending.head
    run_id = head.labels["run_id"]
    where = f"{source}, run {run_id!r}"
    if str(run_id) in seen:
        raise SstlError("the run comes in two pieces", where=where, fix="sort the file by run_id", code="E122")
    seen.add(str(run_id))
    # NaN says "not given"; what no screw can have is for ``sound`` to tell
    lead = None if head.lead_mm is None or math.isnan(head.lead_mm) else head.lead_mm
    if head.labels["system"] not in PASSES:
        raise SstlError(f"system is {head.labels['system']!r}", where=where, fix="it must be 'act' or 'sstl'", code="E124")
    return Run(**(units or {}), **head.labels, lead_mm=lead, **pending.signals())  # type: ignore[arg-type]
