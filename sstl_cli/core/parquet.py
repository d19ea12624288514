"""Parquet with a schema: read in blocks, write atomically, say plainly what is wrong."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Collection, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import replace
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
MOST_CODES = 32_767


class TableWriter:
    """Write a table block by block; the file appears whole when the block ends without error."""

    def __init__(self, path: Path, schema: Schema, provenance: Provenance, force: bool = False, extra: list[Column] | None = None) -> None:
        fields = list(schema.arrow())
        fields += [pa.field(c.name, c.type, c.nullable, {"unit": c.unit, "meaning": c.meaning}) for c in extra or []]
        self.schema = pa.schema(fields, metadata=provenance.metadata(schema.id, schema.version))
        self._stack = ExitStack()
        self._path, self._force = Path(path), force

    def __enter__(self) -> TableWriter:
        self._stack.enter_context(self._opening())
        return self

    @contextmanager
    def _opening(self) -> Iterator[None]:
        """Hold the output open; what goes wrong while opening it goes through the same doors as later errors."""
        with atomic(self._path, self._force) as temporary, self._open(temporary) as self._writer:
            yield

    def _open(self, temporary: Path) -> pq.ParquetWriter:
        floats = [f.name for f in self.schema if pa.types.is_floating(f.type)]
        labels = [f.name for f in self.schema if not pa.types.is_floating(f.type)]
        # measured tensions hardly repeat: a dictionary only costs time and space there
        return pq.ParquetWriter(
            temporary,
            self.schema,
            compression="zstd",
            compression_level=1,
            use_dictionary=labels,
            use_byte_stream_split=floats,
            write_statistics=labels or False,
        )

    def write(self, table: pa.Table) -> None:
        """Append a table whose columns are those of the schema."""
        table = pa.Table.from_arrays([table.column(n).cast(self.schema.field(n).type) for n in self.schema.names], schema=self.schema)
        self._writer.write_table(table, row_group_size=ROWS_PER_BLOCK)

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self._stack.__exit__(kind, error, trace)


class TableReader:
    """A Parquet table checked against a schema and read in blocks.

    The text columns named in ``coded`` come as Arrow dictionaries where the file allows it.
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
                same = self._constant(groups, skip)
                columns = [n for n in self.file.schema_arrow.names if n not in skip and n not in same]
                done = 0
                # one reader over all row groups would hold what it read of every one
                for batch in self.file.iter_batches(ROWS_PER_BLOCK, row_groups=groups, columns=columns):
                    table = pa.Table.from_batches([batch])
                    for name, values in same.items():
                        table = table.append_column(name, values.slice(done, batch.num_rows))
                    done += batch.num_rows
                    yield conform(table, schema, str(self.path), self.coded)
        except (pa.ArrowException, OSError, UnicodeDecodeError) as error:
            raise SstlError(f"is damaged ({str(error)[:120]})", where=str(self.path), code="E133") from None

    def _constant(self, groups: list[int], skip: Collection[str]) -> dict[str, pa.Array]:
        """Return the coded columns that hold one text a row group, by its statistics: they need no decoding.

        Statistics are believed in files of this program only: others may cut long texts in them.
        """
        if self.metadata.get("schema") != self.schema.id or len(groups) > MOST_CODES:
            return {}
        info = self.file.metadata
        parts = [info.row_group(g) for g in groups]
        rows = [part.num_rows for part in parts]
        found: dict[str, pa.Array] = {}
        for place in range(info.num_columns):
            name = info.schema.column(place).path
            if name in skip or name not in self.coded:
                continue
            texts = []
            for part in parts:
                known = part.column(place).statistics
                if known is None or not known.has_min_max or known.null_count or known.min != known.max:
                    break
                texts.append(known.min)
            if len(texts) == len(parts) and all(isinstance(t, str) for t in texts):
                words = list(dict.fromkeys(texts))
                codes = np.repeat(np.array([words.index(t) for t in texts], np.int16), rows)
                found[name] = pa.DictionaryArray.from_arrays(pa.array(codes), pa.array(words, pa.string()))
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
        raise SstlError(f"holds {found['schema']!r}, not {schema.id!r}", where=str(path), code="E131")
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
    except ValueError:
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

    Columns in ``coded`` may stay dictionaries of the schema's type.
    """
    check_columns(table.column_names, schema, where)
    arrays, fields = [], []
    for column in schema.columns:
        if column.name in table.column_names:
            values = table.column(column.name)
            kind = column.type
            if column.name in coded and pa.types.is_dictionary(values.type) and values.type.value_type == kind:
                kind = values.type
            try:
                values = values.cast(kind)
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
            values = pa.chunked_array([pa.nulls(table.num_rows, column.type)])
        arrays.append(values)
        fields.append(pa.field(column.name, values.type, column.nullable, {"unit": column.unit}))
    for name in table.column_names:
        if name not in schema.names:
            arrays.append(table.column(name))
            fields.append(table.schema.field(name))
    return pa.Table.from_arrays(arrays, schema=pa.schema(fields))


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
        file = pq.ParquetFile(path)
        types = {f.name: f.type for f in file.schema_arrow}
        present = [n for n in coded if n in types and pa.types.is_string(types[n])]
        return pq.ParquetFile(path, read_dictionary=present) if present else file
    except (pa.ArrowException, OSError, UnicodeDecodeError):
        what, fix = not_parquet(path)
        raise SstlError(what, where=str(path), fix=fix, code="E130") from None
