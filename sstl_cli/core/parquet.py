"""Parquet with a schema: read in blocks, write atomically, say plainly what is wrong."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from types import TracebackType

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from sstl_cli.core.errors import SstlError, nearest
from sstl_cli.core.files import atomic
from sstl_cli.core.kinds import not_parquet
from sstl_cli.core.provenance import Provenance
from sstl_cli.core.tables import Column, Schema

ROWS_PER_BLOCK = 262_144
# the footer keeps some kilobytes of each row group: what is shorter shares one
LEAST_ROWS = 256


class TableWriter:
    """Write a table block by block; the file appears whole when the block ends without error."""

    def __init__(self, path: Path, schema: Schema, provenance: Provenance, force: bool = False, extra: list[Column] | None = None) -> None:
        fields = list(schema.arrow())
        fields += [pa.field(c.name, c.type, c.nullable, {"unit": c.unit, "meaning": c.meaning}) for c in extra or []]
        self.schema = pa.schema(fields, metadata=provenance.metadata(schema.id, schema.version))
        self._stack = ExitStack()
        self._held: list[pa.Table] = []
        self._path, self._force = Path(path), force

    def __enter__(self) -> TableWriter:
        self._stack.enter_context(self._opening())
        return self

    @contextmanager
    def _opening(self) -> Iterator[None]:
        """Hold the output open; what goes wrong while opening it goes through the same doors as later errors."""
        require_text(self._path)
        with atomic(self._path, self._force) as temporary, self._open(temporary) as self._writer:
            yield
            self._write_held()

    def _open(self, temporary: Path) -> pq.ParquetWriter:
        floats = [f.name for f in self.schema if pa.types.is_floating(f.type)]
        labels = [f.name for f in self.schema if not pa.types.is_floating(f.type)]
        # a reader learns from them which texts are constant and which channels hold nothing: neither needs decoding
        told = labels + [f.name for f in self.schema if pa.types.is_floating(f.type) and f.nullable]
        # measured tensions hardly repeat: a dictionary only costs time and space there
        return pq.ParquetWriter(
            temporary,
            self.schema,
            # a few per cent larger than zstd at its quickest, and decoded in two thirds of the time
            compression="lz4",
            use_dictionary=labels,
            use_byte_stream_split=floats,
            write_statistics=told or False,
            # a page that lost a bit is still a page of numbers
            write_page_checksum=True,
        )

    def write(self, table: pa.Table) -> None:
        """Append a table whose columns are those of the schema."""
        table = pa.Table.from_arrays([table.column(n).cast(self.schema.field(n).type) for n in self.schema.names], schema=self.schema)
        if len(table) >= LEAST_ROWS:
            self._write_held()
        self._held.append(table)
        if sum(map(len, self._held)) >= LEAST_ROWS:
            self._write_held()

    def _write_held(self) -> None:
        """Write the tables that wait for others, as one row group."""
        if self._held:
            self._writer.write_table(pa.concat_tables(self._held), row_group_size=ROWS_PER_BLOCK)
            self._held = []

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self._stack.__exit__(kind, error, trace)


def require_text(path: Path) -> None:
    """Raise SstlError E005 if the name of a Parquet file is no UTF-8: the library takes no other."""
    try:
        str(path).encode()
    except UnicodeEncodeError:
        raise SstlError("its name is no UTF-8, which Parquet files have to have", where=str(path), fix="rename it", code="E005") from None


class TableReader:
    """A Parquet table checked against a schema and read in blocks.

    The text columns named in ``coded`` come as Arrow dictionaries where the file allows it, and run-end encoded where its
    statistics say that a row group holds one text.
    """

    def __init__(self, path: Path, file: pq.ParquetFile, schema: Schema, coded: Sequence[str] = ()) -> None:
        self.path, self.file, self.schema, self.coded = path, file, schema, coded
        self.metadata: dict[str, object] = metadata_of(file)

    @property
    def rows(self) -> int:
        return int(self.file.metadata.num_rows)

    def blocks(self, skip: Collection[str] = ()) -> Iterator[pa.Table]:
        """Yield tables with the schema's columns in the schema's types (missing nullable ones as null).

        Memory is bounded by a block and a row group, however many row groups there are.

        Parameters
        ----------
        skip : collection of str
            Nullable columns that are not read at all; the tables are without them.
        """
        schema = replace(self.schema, columns=tuple(c for c in self.schema.columns if c.name not in skip))
        try:
            for groups in self._row_groups():
                told = self._believed(groups, skip)
                same = self._constant(groups, told)
                away = {*skip, *same, *self._null(groups, told)}
                columns = [n for n in self.file.schema_arrow.names if n not in away]
                done = 0
                # one reader over all row groups would hold what it read of every one
                for batch in self.file.iter_batches(ROWS_PER_BLOCK, row_groups=groups, columns=columns):
                    table = pa.Table.from_batches([batch])
                    for name, values in same.items():
                        table = table.append_column(name, values.slice(done, batch.num_rows))
                    done += batch.num_rows
                    yield conform(table, schema, str(self.path), self.coded)
        except (pa.ArrowException, OSError, UnicodeDecodeError) as error:
            raise SstlError(
                f"is damaged ({str(error)[:120]})", where=str(self.path), fix="copy it again, or make it again", code="E133"
            ) from None

    def _believed(self, groups: list[int], skip: Collection[str]) -> dict[str, int]:
        """Return the place of each column whose statistics may be asked for in these row groups; OSError for a damaged footer.

        Arrow ends the process where it is asked for statistics that a damaged footer makes impossible.
        """
        info = self.file.metadata
        names = [info.schema.column(place).path for place in range(info.num_columns)]
        optional = {c.name for c in self.schema.columns if c.nullable}
        wanted = {name: place for place, name in enumerate(names) if name not in skip and name in optional.union(self.coded)}
        # what it reads ahead it has looked at first, and says so where that is wrong
        looked = pq.ParquetFile(self.path, metadata=info, pre_buffer=True)
        next(looked.iter_batches(1, row_groups=groups, columns=list(wanted), use_threads=False), None)
        parts = [info.row_group(g) for g in groups]
        kinds = {name: info.schema.column(place).physical_type for name, place in wanted.items()}
        return {name: place for name, place in wanted.items() if all(p.column(place).physical_type == kinds[name] for p in parts)}

    def _constant(self, groups: list[int], told: Mapping[str, int]) -> dict[str, pa.Array]:
        """Return the coded columns that hold one text a row group, run-end encoded, by its statistics: they need no decoding.

        Statistics are believed in files of this program only: others may cut long texts in them.
        """
        if self.metadata.get("schema") != self.schema.id:
            return {}
        parts = [self.file.metadata.row_group(g) for g in groups]
        ends = pa.array(np.cumsum([part.num_rows for part in parts]), pa.int32())
        found: dict[str, pa.Array] = {}
        for name in (n for n in told if n in self.coded):
            known = [part.column(told[name]).statistics for part in parts]
            if any(k is None or not k.has_min_max or k.null_count or k.min != k.max for k in known):
                continue
            texts = [k.min for k in known]
            if all(isinstance(t, str) for t in texts):
                found[name] = pa.RunEndEncodedArray.from_arrays(ends, pa.array(texts, pa.string()))
        return found

    def _null(self, groups: list[int], told: Mapping[str, int]) -> list[str]:
        """Return the schema's columns that these row groups' statistics say are null throughout."""
        parts = [self.file.metadata.row_group(g) for g in groups]
        found = []
        for column in self.schema.columns:
            if column.nullable and column.name in told:
                known = (part.column(told[column.name]).statistics for part in parts)
                if all(k is not None and k.has_null_count and k.num_values == 0 and k.null_count > 0 for k in known):
                    found.append(column.name)
        return found

    def _row_groups(self) -> Iterator[list[int]]:
        """Yield neighbouring row groups that make up about a block."""
        held: list[int] = []
        rows = 0
        for group in range(self.file.metadata.num_row_groups):
            more = self.file.metadata.row_group(group).num_rows
            if held and rows + more > ROWS_PER_BLOCK:
                yield held
                held, rows = [], 0
            held.append(group)
            rows += more
        if held:
            yield held

    def table(self) -> pa.Table:
        """Return the whole table."""
        blocks = list(self.blocks())
        return pa.concat_tables(blocks) if blocks else self.schema.arrow().empty_table()


def open_table(path: Path, schema: Schema, coded: Sequence[str] = ()) -> TableReader:
    """Open a Parquet file that holds ``schema``; SstlError names what does not fit."""
    file = _open(Path(path), coded)
    found = metadata_of(file)
    if found and (found.get("schema") not in (schema.id, None)):
        what = f"holds {found['schema']!r}, not {schema.id!r}"
        raise SstlError(what, where=str(path), fix="give a table of that kind; 'sstl info' shows what a file holds", code="E131")
    if found and found.get("schema") == schema.id and found.get("schema_version") != schema.version:
        raise SstlError(
            f"has {schema.id} version {found.get('schema_version')}, this program reads version {schema.version}",
            where=str(path),
            fix="make the file again with this version of sstl",
            code="E132",
        )
    check_columns(file.schema_arrow.names, schema, str(path))
    return TableReader(Path(path), file, schema, coded)


def schema_id_of(path: Path) -> str | None:
    """Return the schema id stored in a Parquet file, or None if it carries none."""
    value = metadata_of(_open(Path(path))).get("schema")
    return str(value) if value is not None else None


def metadata_of(file: pq.ParquetFile) -> dict[str, object]:
    """Return the document stored under the table metadata key ``sstl`` (empty if there is none)."""
    raw = (file.schema_arrow.metadata or {}).get(b"sstl")
    if raw is None:
        return {}
    try:
        document = json.loads(raw)
    except (ValueError, RecursionError):
        return {}
    return document if isinstance(document, dict) else {}


def check_columns(names: list[str], schema: Schema, where: str) -> None:
    """Raise SstlError naming every missing required column and the nearest one present, or a column given twice."""
    missing = [c for c in schema.required if c not in names]
    if missing:
        spare = [n for n in names if n not in schema.names]
        hints = "; ".join(f"'{m}'" + (f" ({nearest(m, spare)})" if spare else "") for m in missing)
        raise SstlError(f"misses column {hints}", where=where, fix="rename it, or give a mapping to sstl import", code="E134")
    twice = [c for c, n in Counter(names).items() if n > 1]
    if twice:
        raise SstlError(f"has column '{twice[0]}' {names.count(twice[0])} times", where=where, fix="drop all but one", code="E137")


def conform(table: pa.Table, schema: Schema, where: str, coded: Sequence[str] = ()) -> pa.Table:
    """Return the table with the schema's columns and types; extra columns are kept behind them.

    Columns in ``coded`` may stay dictionaries, or run-end encoded, of the schema's type.
    """
    check_columns(table.column_names, schema, where)
    arrays, fields = [], []
    for column in schema.columns:
        if column.name in table.column_names:
            values = table.column(column.name)
            kind = column.type
            if column.name in coded and _coded(values.type) and values.type.value_type == kind:
                kind = values.type
            try:
                values = values if values.type == kind else values.cast(kind)
            except (pa.ArrowInvalid, pa.ArrowNotImplementedError):
                raise SstlError(
                    f"column '{column.name}' holds {values.type}, not {column.type}",
                    where=where,
                    fix=f"write it as {column.type}" + (f" in {column.unit}" if column.unit else ""),
                    code="E135",
                ) from None
            if pa.types.is_string(column.type):
                # Arrow hands out bytes that are no UTF-8 as they are; Python would stop at them much later
                values.validate(full=True)
            if values.null_count and not column.nullable:
                raise SstlError(
                    f"column '{column.name}' has {values.null_count} empty values",
                    where=where,
                    fix="drop or repair these samples (sstl check lists them)",
                    code="E136",
                )
        else:
            values = pa.chunked_array([_nulls(table.num_rows, column.type)])
        arrays.append(values)
        fields.append(pa.field(column.name, values.type, column.nullable, {"unit": column.unit}))
    for name in table.column_names:
        if name not in schema.names:
            arrays.append(table.column(name))
            fields.append(table.schema.field(name))
    return pa.Table.from_arrays(arrays, schema=pa.schema(fields))


def _nulls(rows: int, kind: pa.DataType) -> pa.Array:
    """Return an array of nulls; those of every block share one, which need not be filled with zeros again."""
    return _kept_nulls(ROWS_PER_BLOCK, kind).slice(0, rows) if rows <= ROWS_PER_BLOCK else pa.nulls(rows, kind)


@lru_cache(8)
def _kept_nulls(rows: int, kind: pa.DataType) -> pa.Array:
    return pa.nulls(rows, kind)


def _coded(kind: pa.DataType) -> bool:
    return bool(pa.types.is_dictionary(kind) or pa.types.is_run_end_encoded(kind))


def write_table(
    path: Path, table: pa.Table, schema: Schema, provenance: Provenance, force: bool = False, extra: list[Column] | None = None
) -> None:
    """Write a whole table atomically."""
    with TableWriter(path, schema, provenance, force, extra) as writer:
        writer.write(table)


def _open(path: Path, coded: Sequence[str] = ()) -> pq.ParquetFile:
    if not path.exists():
        raise SstlError("file not found", where=str(path), fix="give the path of a table that sstl wrote", code="E130")
    if path.is_dir():
        raise SstlError("is a folder, not a file", where=str(path), fix="name the files in it", code="E130")
    if not path.is_file():
        # reading one waits for whoever writes to it, in compiled code that no signal ends
        raise SstlError("is no regular file (a device or a pipe)", where=str(path), fix="write it to a file first", code="E130")
    try:
        file = pq.ParquetFile(path, page_checksum_verification=True)
        types = {f.name: f.type for f in file.schema_arrow}
        present = [n for n in coded if n in types and pa.types.is_string(types[n])]
        # the footer of a long log is large: it is parsed once
        if not present:
            return file
        return pq.ParquetFile(path, read_dictionary=present, metadata=file.metadata, page_checksum_verification=True)
    except (pa.ArrowException, OSError, UnicodeDecodeError):
        what, fix = not_parquet(path)
        raise SstlError(what, where=str(path), fix=fix, code="E130") from None
