"""One uninterrupted recording in memory, and log files as streams of them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
from numpy.typing import NDArray

from sstl_cli.core.errors import SstlError
from sstl_cli.core.parquet import TableWriter, open_table
from sstl_cli.core.provenance import Provenance
from sstl_cli.core.tables import LOG, TENDON

Array = NDArray[np.float64]
SIGNALS = ("time_s", "tension_in_n", "tension_out_n", "position_in_mm", "tension_ref_n")
LABELS = ("run_id", "config_id", "system", "location", "lead_mm", "trajectory", "tendon")
PASSES = {"act": 1, "sstl": 2}


@dataclass(frozen=True)
class Run:
    """One run: labels and equally long float64 arrays (time in s, tensions in N, position in mm)."""

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

    def __len__(self) -> int:
        return len(self.time_s)

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


def write_runs(path: Path, runs: Iterable[Run], provenance: Provenance, force: bool = False) -> int:
    """Write runs one by one (memory bounded by the largest) and return the number of samples."""
    samples = 0
    iterator = iter(runs)
    first = next(iterator, None)
    if first is None:
        raise SstlError("no run to write", where=str(path), fix="check the input for usable samples", code="E120")
    tendons = first.tendon is not None
    with TableWriter(path, LOG, provenance, force, extra=[TENDON] if tendons else []) as writer:
        run: Run | None = first
        while run is not None:
            writer.write(run_table(run, tendons))
            samples += len(run)
            run = next(iterator, None)
    return samples


def read_runs(path: Path) -> Iterator[Run]:
    """Yield the runs of a log in file order; a run must be contiguous.

    Raises
    ------
    SstlError
        If the file is not a log, a required value is null, or a run comes in two pieces.
    """
    pending: pa.Table | None = None
    seen: set[str] = set()
    reader = open_table(path, LOG)
    for block in reader.blocks():
        ids = block.column("run_id")
        if ids.null_count:
            raise SstlError("run_id is null", where=str(path), fix="give every sample a run_id", code="E121")
        encoded = ids.combine_chunks().dictionary_encode()
        if isinstance(encoded, pa.ChunkedArray):
            encoded = encoded.combine_chunks()
        codes = encoded.indices.to_numpy(zero_copy_only=False)
        starts = np.concatenate(([0], np.flatnonzero(np.diff(codes)) + 1, [len(codes)]))
        for a, b in zip(starts[:-1], starts[1:], strict=True):
            if a == b:
                continue
            piece = block.slice(a, b - a)
            if pending is not None and pending.column("run_id")[0].as_py() == piece.column("run_id")[0].as_py():
                pending = pa.concat_tables([pending, piece])
                continue
            if pending is not None:
                yield _run(pending, path, seen)
            pending = piece
    if pending is not None:
        yield _run(pending, path, seen)


def _run(table: pa.Table, path: Path, seen: set[str]) -> Run:
    run_id = table.column("run_id")[0].as_py()
    where = f"{path}, run {run_id!r}"
    if run_id in seen:
        raise SstlError("the run comes in two pieces", where=where, fix="sort the file by run_id", code="E122")
    seen.add(run_id)
    values: dict[str, object] = {}
    for name in LABELS:
        if name in table.column_names:
            column = table.column(name)
            first = column[0].as_py()
            if name == "lead_mm" and first is not None and first != first:
                first = None
            if name != "lead_mm" and first is not None and pc.count_distinct(column, mode="all").as_py() > 1:
                raise SstlError(f"{name} changes within the run", where=where, fix="split the run", code="E123")
            values[name] = first
    if values["system"] not in PASSES:
        raise SstlError(f"system is {values['system']!r}", where=where, fix="it must be 'act' or 'sstl'", code="E124")
    for name in SIGNALS:
        column = table.column(name)
        if name in ("position_in_mm", "tension_ref_n") and column.null_count == len(column):
            values[name] = None
            continue
        values[name] = column.to_numpy()
    return Run(**values)  # type: ignore[arg-type]
