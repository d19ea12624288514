"""Look for what is wrong with a table: its columns and units, then block by block its samples, run by run."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass
from itertools import pairwise
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc

from sstl_cli.core.documents import logs
from sstl_cli.core.errors import SstlError, nearest
from sstl_cli.core.parquet import ROWS_PER_BLOCK
from sstl_cli.core.tables import LOG, THETA, Schema
from sstl_cli.core.units import is_force
from sstl_cli.identification import samples
from sstl_cli.identification.samples import FAILURE, REMARK, Finding, Piece

LABELS = ("config_id", "system", "location", "trajectory")
# findings of one kind that are listed one by one
LISTED = 50


@dataclass(frozen=True)
class Entry:
    """A finding, and the run it was made in."""

    finding: Finding
    run_id: str | None = None

    def of(self, file: str) -> logs.Finding:
        """Return the entry as a part of the document of ``check``."""
        return logs.Finding(file=file, run_id=self.run_id, **asdict(self.finding))


def unreadable(error: SstlError) -> Entry:
    """Return what is said of a file that cannot be read."""
    return Entry(Finding(FAILURE, "unreadable", "", 1, error.what, error.fix))


def run(reader: Any, schema: Schema, advance: Callable[[float], None]) -> Iterator[Entry]:
    """Yield what is wrong with a table.

    Parameters
    ----------
    reader : table reader
        The table, none of whose columns has been asked for: each that is missing is a finding of its own.
    schema : Schema
        What it should hold.
    advance : callable
        Told the number of rows that were looked at.
    """
    arrow = reader.file.schema_arrow
    yield from map(Entry, _schema_findings(arrow, schema))
    if reader.rows == 0:
        yield Entry(Finding(FAILURE, "no rows", "", 0, "the table is empty", "record or import again"))
        return
    numeric = [c.name for c in schema.columns if _is_number(arrow, c.name)]
    try:
        if schema is LOG:
            yield from _few(_of_log(reader, numeric, advance))
        else:
            yield from _of_table(reader, numeric, [n for n in schema.required if n in numeric])
    except SstlError as error:
        yield unreadable(error)


def _of_log(reader: Any, numeric: list[str], advance: Callable[[float], None]) -> Iterator[Entry]:
    """Yield the findings on every run, its rows brought together first where they lie apart."""
    optional = tuple(n for n in numeric if n not in LOG.required)
    stretches = _stretches(reader)
    apart = {run_id: n for run_id, n in stretches.items() if n > 1}
    blocks = _blocks(reader)
    if apart:
        runs = f"run {next(iter(apart))!r} comes" if len(apart) == 1 else f"{len(apart)} of {len(stretches)} runs come"
        detail = f"{runs} in {sum(apart.values())} pieces" + ("; is the log sorted by time?" if len(apart) > 1 else "")
        finding = Finding(FAILURE, "runs in pieces", "run_id", len(apart), detail, "sort by run_id, then by time_s")
        yield Entry(finding, next(iter(apart)) if len(apart) == 1 else None)
        blocks = iter([_by_run(blocks)])
    for piece in _pieces(blocks, numeric):
        yield from (Entry(f, piece.run_id) for f in samples.findings(piece, optional))
        advance(len(next(iter(piece.columns.values()), ())))


def _few(entries: Iterator[Entry]) -> Iterator[Entry]:
    """Yield the first entries of every kind, then one that counts the others of it."""
    kinds: dict[tuple[samples.Level, str, str, str], list[int]] = {}
    for entry in entries:
        f = entry.finding
        seen = kinds.setdefault((f.level, f.what, f.column, f.fix), [0, 0])
        seen[0] += 1
        if seen[0] <= LISTED:
            yield entry
        else:
            seen[1] += f.count
    for (level, what, column, fix), (n, count) in kinds.items():
        if n > LISTED:
            yield Entry(Finding(level, what, column, count, f"in {n - LISTED} more runs", fix))


def _stretches(reader: Any) -> dict[str | None, int]:
    """Return in how many stretches of rows each run comes, in order of appearance."""
    found: dict[str | None, int] = {}
    last: Any = ()
    for block in _blocks(reader, ["run_id"]) if "run_id" in reader.file.schema_arrow.names else ():
        ids = block.column("run_id").cast(pa.string()).combine_chunks()
        ids = ids.combine_chunks() if isinstance(ids, pa.ChunkedArray) else ids
        for run_id in pc.run_end_encode(ids).values.to_pylist():
            if run_id != last:
                found[run_id] = found.get(run_id, 0) + 1
            last = run_id
    return found


def _by_run(blocks: Iterator[Any]) -> Any:
    """Return all blocks as one table whose runs are contiguous, in order of appearance, their rows in file order."""
    table = pa.concat_tables(list(blocks), promote_options="permissive")
    codes = table.column("run_id").cast(pa.string()).combine_chunks().dictionary_encode()
    codes = codes.combine_chunks() if isinstance(codes, pa.ChunkedArray) else codes
    return table.take(pa.array(np.argsort(codes.indices.fill_null(-1).to_numpy(zero_copy_only=False), kind="stable")))


def _is_text(kind: Any) -> bool:
    return any(test(kind) for test in (pa.types.is_string, pa.types.is_large_string, pa.types.is_dictionary, pa.types.is_null))


def _is_number(arrow: Any, name: str) -> bool:
    return name in arrow.names and (pa.types.is_floating(arrow.field(name).type) or pa.types.is_integer(arrow.field(name).type))


def _schema_findings(arrow: Any, schema: Any) -> Iterator[Finding]:
    """Yield missing columns, columns of a wrong type, and units that are absent or not ours."""
    spare = [n for n in arrow.names if n not in schema.names]
    for column in schema.columns:
        if column.name not in arrow.names:
            if not column.nullable:
                hint = nearest(column.name, spare) if spare else "rename it or import with a mapping"
                yield Finding(FAILURE, "missing column", column.name, 1, "not in the file", hint)
            continue
        field = arrow.field(column.name)
        number = any(test(field.type) for test in (pa.types.is_floating, pa.types.is_integer, pa.types.is_null))
        fits = _is_text(field.type) if column.type == pa.string() else number
        if pa.types.is_null(field.type) and not column.nullable:
            yield Finding(FAILURE, "empty values", column.name, 1, "all of them: the column holds nothing", "record or import again")
        if not fits:
            yield Finding(FAILURE, "wrong type", column.name, 1, f"{field.type}, not {column.type}", f"write it as {column.type}")
        unit = (field.metadata or {}).get(b"unit")
        if unit is None and column.unit:
            yield Finding(REMARK, "no unit stated", column.name, 1, f"taken as {column.unit}", "none needed if that is right")
        elif unit is not None and unit.decode(errors="replace") != column.unit:
            stated = unit.decode(errors="replace")
            if column.name in ("tension_in_n", "tension_out_n") and not is_force(stated):
                detail = f"in {stated}, declared in the mapping: slopes and biases are in this unit too"
                yield Finding(REMARK, "not a tension", column.name, 1, detail, "none needed")
                continue
            detail = f"{stated!r}, not {column.unit!r}"
            yield Finding(FAILURE, "wrong unit", column.name, 1, detail, "convert it with sstl import")


def _blocks(reader: Any, columns: list[str] | None = None) -> Iterator[Any]:
    try:
        for batch in reader.file.iter_batches(ROWS_PER_BLOCK, columns=columns):
            for column in batch.columns:
                if _is_text(column.type):
                    # Arrow hands out bytes that are no UTF-8 as they are; Python would stop at them much later
                    column.validate(full=True)
            yield pa.Table.from_batches([batch])
    except (pa.ArrowException, OSError) as error:
        raise SstlError(f"damaged ({str(error)[:100]})", where=str(reader.path), fix="make the file again", code="E230") from None


def _of_table(reader: Any, numeric: list[str], required: list[str]) -> Iterator[Entry]:
    ids: dict[str, int] = {}
    for block in _blocks(reader):
        nulls = {n: block.column(n).null_count for n in block.column_names}
        columns = {n: _numbers(block.column(n)) for n in numeric}
        yield from map(Entry, samples.table_findings(columns, nulls, required))
        if "status" in block.column_names and reader.metadata.get("schema") == THETA.id:
            for run_id, status in zip(block.column("run_id").to_pylist(), block.column("status").to_pylist(), strict=True):
                ids[str(run_id)] = ids.get(str(run_id), 0) + 1
                if status != "ok":
                    yield Entry(Finding(REMARK, "set aside", "status", 1, str(status), "none needed"), run_id)
    for run_id, count in ids.items():
        if count > 1:
            yield Entry(Finding(FAILURE, "run comes twice", "run_id", count, f"{count} rows", "keep one row a run"), run_id)


def _numbers(column: Any) -> Any:
    return column.cast(pa.float64()).to_numpy(zero_copy_only=False) if not pa.types.is_null(column.type) else column.to_numpy()


def _pieces(blocks: Iterator[Any], numeric: list[str]) -> Iterator[Piece]:
    """Yield contiguous stretches of one run_id; memory is bounded by the longest."""
    pending: list[Piece] = []
    for block in blocks:
        for piece in _stretches_of(block, numeric):
            if pending and pending[0].run_id != piece.run_id:
                yield _joined(pending)
                pending = []
            pending.append(piece)
    if pending:
        yield _joined(pending)


def _stretches_of(block: Any, numeric: list[str]) -> Iterator[Piece]:
    """Yield the stretches of one run_id in one block; its columns are decoded once, not stretch by stretch."""
    n, named = block.num_rows, "run_id" in block.column_names
    signals = {s: _numbers(block.column(s)) for s in numeric}
    # of a column of another type the schema's findings have told
    texts = [s for s in LABELS if s in block.column_names and _is_text(block.column(s).type)]
    labels = {s: _coded(block.column(s)) for s in texts}
    ids, runs = _coded(block.column("run_id")) if named else ([None], np.zeros(n, np.int64))
    edges = np.unique(np.concatenate(([0], np.flatnonzero(np.diff(runs)) + 1, [n])))
    nulls = {s: _nulls(block.column(s), edges) for s in signals}
    texts_of = {s: _different(own, codes, edges) for s, (own, codes) in labels.items()}
    names = [ids[k] for k in runs[edges[:-1]].tolist()]
    for i, (a, b) in enumerate(pairwise(edges.tolist())):
        yield Piece(
            None if names[i] is None else str(names[i]),
            {s: v[a:b] for s, v in signals.items()},
            {s: texts[i] for s, texts in texts_of.items()},
            {s: counts[i] for s, counts in nulls.items()},
        )


def _nulls(column: Any, edges: Any) -> list[int]:
    """Return how many values are null between each two edges."""
    if not column.null_count:
        return [0] * (len(edges) - 1)
    total = np.cumsum(np.concatenate(([0], column.is_null().to_numpy())))
    counts: list[int] = np.diff(total[edges]).tolist()
    return counts


def _coded(column: Any) -> tuple[list[Any], Any]:
    """Return the texts of a column, None last, and for each row the place of its own."""
    values = column.cast(pa.string()).combine_chunks()
    coded = values.dictionary_encode()
    coded = coded.combine_chunks() if isinstance(coded, pa.ChunkedArray) else coded
    texts = coded.dictionary.to_pylist()
    return [*texts, None], coded.indices.fill_null(len(texts)).to_numpy(zero_copy_only=False)


def _different(texts: list[Any], codes: Any, edges: Any) -> list[list[Any]]:
    """Return the texts of each stretch between two edges, each text once, in order of appearance."""
    changes = np.flatnonzero(np.diff(codes)) + 1
    # a change at an edge is none within a stretch
    within = np.searchsorted(changes, edges[:-1], "right") != np.searchsorted(changes, edges[1:], "left")
    found = [[texts[k]] for k in codes[edges[:-1]].tolist()]
    for i in np.flatnonzero(within).tolist():
        found[i] = [texts[k] for k in dict.fromkeys(codes[edges[i] : edges[i + 1]].tolist())]
    return found


def _joined(parts: list[Piece]) -> Piece:
    """Return one run from its stretches, which blocks cut."""
    head = parts[0]
    if len(parts) == 1:
        return head
    return Piece(
        head.run_id,
        {s: np.concatenate([p.columns[s] for p in parts]) for s in head.columns},
        {s: list(dict.fromkeys(text for p in parts for text in p.labels[s])) for s in head.labels},
        {s: sum(p.nulls[s] for p in parts) for s in head.nulls},
    )
