"""Parquet tables of any columns, read block by block."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from sstl_cli.core.errors import SstlError
from sstl_cli.core.parquet import require_text
from sstl_cli.importers.base import ROWS_PER_BLOCK, Block, Channel, Layout, Notes, check_declared, guarded, require_few, text_array

ID = "parquet"
TITLE = "Parquet"
EXTENSIONS = (".parquet", ".pq")
RANK = 10
MAGIC = b"PAR1"


def sniff(head: bytes, path: Path) -> bool:
    """Return whether the file begins with the Parquet magic."""
    return head.startswith(MAGIC)


def channels(path: Path, layout: Layout) -> list[Channel]:
    """Return the columns that are numbers, times or strings."""
    require_text(path)
    with guarded(path, TITLE):
        _complete(path)
        file = pq.ParquetFile(path)
        out = []
        require_few(path, len(file.schema_arrow), "columns")
        for field in file.schema_arrow:
            unit = (field.metadata or {}).get(b"unit", b"").decode("utf-8", "replace")
            if _is_time(field.type):
                unit = "s"
            if _is_number(field.type) or _is_time(field.type):
                out.append(Channel(field.name, file.metadata.num_rows, unit))
            elif _is_text(field.type):
                out.append(Channel(field.name, file.metadata.num_rows, text=True))
        return out


def _complete(path: Path) -> None:
    """Refuse a file without its end, where Parquet keeps what it holds: a copy or a recorder that stopped."""
    with open(path, "rb") as file:
        file.seek(max(path.stat().st_size - len(MAGIC), 0))
        if file.read() != MAGIC:
            fix = "copy it again; a recorder that was stopped leaves such files: close it first"
            raise SstlError("is a Parquet file without its end", where=str(path), fix=fix, code="E310")


def read(path: Path, numbers: list[str], labels: list[str], layout: Layout, notes: Notes) -> Iterator[Block]:
    """Yield blocks of the named columns; time stamps become seconds since the first of the file."""
    wanted = list(dict.fromkeys([*numbers, *labels]))
    size = path.stat().st_size
    with guarded(path, TITLE):
        file = pq.ParquetFile(path, memory_map=False, page_checksum_verification=True)
        rows = file.metadata.num_rows
        # a constant column compresses without limit; only what must stand in memory at once is bounded
        for group in range(min(file.metadata.num_row_groups, 100_000)):
            rows_in = file.metadata.row_group(group).num_rows
            if rows_in < 0:
                raise SstlError("declares a negative number of rows", where=str(path), fix="write it again", code="E312")
            if rows_in > rows or rows_in * 8 > (4 << 30):
                check_declared(path, rows_in * 8 * len(wanted), "a row group")
        origins: dict[str, int] = {}
        done = 0
        for batch in file.iter_batches(ROWS_PER_BLOCK, columns=wanted, use_threads=False):
            done += batch.num_rows
            columns = {}
            for name in wanted:
                values = batch.column(name)
                columns[name] = _number(values, name, origins, path) if name in numbers else _label(values)
            yield Block(columns, int(size * done / max(rows, 1)))


def _is_number(kind: pa.DataType) -> bool:
    return bool(
        pa.types.is_floating(kind)
        or pa.types.is_integer(kind)
        or pa.types.is_boolean(kind)
        or pa.types.is_decimal(kind)
        or (pa.types.is_dictionary(kind) and _is_number(kind.value_type))
    )


def _is_time(kind: pa.DataType) -> bool:
    return bool(pa.types.is_timestamp(kind) or pa.types.is_duration(kind))


def _is_text(kind: pa.DataType) -> bool:
    return bool(
        pa.types.is_string(kind)
        or pa.types.is_large_string(kind)
        or pa.types.is_null(kind)
        or (pa.types.is_dictionary(kind) and _is_text(kind.value_type))
    )


def _number(values: pa.Array, name: str, origins: dict[str, int], path: Path) -> np.ndarray:
    if _is_time(values.type):
        raw = values.cast(pa.timestamp("ns") if pa.types.is_timestamp(values.type) else pa.duration("ns")).cast(pa.int64())
        first = next((v for v in raw.to_pylist() if v is not None), 0) if name not in origins else 0
        origin = origins.setdefault(name, first)
        whole = raw.fill_null(origin).to_numpy(zero_copy_only=False) - origin
        seconds = whole * 1e-9
        seconds[np.asarray(raw.is_null())] = np.nan
        return np.asarray(seconds, np.float64)
    if pa.types.is_dictionary(values.type):
        values = values.dictionary_decode()
    if not _is_number(values.type):
        try:
            values = values.cast(pa.float64())
        except pa.ArrowException:
            raise SstlError(
                f"column '{name}' holds {values.type}, not numbers", where=str(path), fix="map another column", code="E328"
            ) from None
    # nanoseconds since 1970 are beyond what a double holds exactly, as in all formats: a proposal asks where that matters
    return np.asarray(values.cast(pa.float64(), safe=False).to_numpy(zero_copy_only=False), np.float64)


def _label(values: pa.Array) -> pa.Array:
    if pa.types.is_dictionary(values.type):
        values = values.dictionary_decode()
    if pa.types.is_floating(values.type):
        return text_array(values.to_pylist())
    # by way of bytes, so that text that is no UTF-8 is refused here and not where it is used
    return values.cast(pa.string()).cast(pa.binary()).cast(pa.string())
