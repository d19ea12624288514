"""A reference from a file or a table: columns time_s and tension_ref_n."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from sstl_cli.control.references import Reference, from_samples
from sstl_cli.core.errors import SstlError
from sstl_cli.core.files import require_regular
from sstl_cli.core.parquet import schema_id_of

if TYPE_CHECKING:
    import pandas as pd

Array = NDArray[np.float64]
COLUMNS = ("time_s", "tension_ref_n")


def read(path: Path, dt_s: float) -> Reference:
    """Return the reference in a file at the controller's period; of several runs, the first.

    Raises
    ------
    SstlError
        If the file cannot be read, misses a column, or holds values that are not numbers.
    """
    table = _csv(path) if path.suffix.lower() in (".csv", ".txt", ".tsv") else _parquet(path)
    return _first(path.stem, *table, dt_s)


def of_frame(name: str, frame: pd.DataFrame, dt_s: float) -> Reference:
    """Return the reference in a table in memory, as ``read`` does that of a file."""
    return _first(name, *_columns(frame, name), dt_s)


def _first(name: str, time: Array, tension: Array, dt_s: float) -> Reference:
    back = np.flatnonzero(np.diff(time) < 0)
    if len(back):
        time, tension = time[: back[0] + 1], tension[: back[0] + 1]
    return from_samples(name, time, tension, dt_s)


def _csv(path: Path) -> tuple[Array, Array]:
    import pandas as pd

    require_regular(path)
    try:
        frame = pd.read_csv(path, sep="\t" if path.suffix.lower() == ".tsv" else ",")
    except (ValueError, OSError) as error:
        raise SstlError(f"cannot be read as CSV ({str(error)[:100]})", where=str(path), code="E407") from None
    return _columns(frame, str(path))


def _columns(frame: pd.DataFrame, where: str) -> tuple[Array, Array]:
    _require(list(frame.columns), where)
    try:
        time, tension = (frame[c].to_numpy(dtype=float) for c in COLUMNS)
    except (ValueError, TypeError):
        raise _text(where) from None
    return time, tension


def _parquet(path: Path) -> tuple[Array, Array]:
    import pyarrow as pa
    import pyarrow.parquet as pq

    schema_id_of(path)
    _require(pq.read_schema(path).names, str(path))
    try:
        table = pq.read_table(path, columns=list(COLUMNS), page_checksum_verification=True)
    except (pa.ArrowException, OSError) as error:
        raise SstlError(f"is damaged ({str(error)[:120]})", where=str(path), fix="copy it again, or make it again", code="E133") from None
    try:
        time, tension = (table.column(c).cast("float64").to_numpy() for c in COLUMNS)
    except (ValueError, pa.ArrowException):
        raise _text(str(path)) from None
    return time, tension


def _text(where: str) -> SstlError:
    return SstlError("holds text where numbers belong", where=where, fix=f"columns {' and '.join(COLUMNS)} hold numbers", code="E407")


def _require(names: list[str], where: str) -> None:
    missing = [c for c in COLUMNS if c not in names]
    # pandas names the second of two columns like the first with a number
    twice = [c for c in COLUMNS if names.count(c) > 1 or f"{c}.1" in names]
    if twice:
        raise SstlError(f"has column {twice[0]} more than once", where=where, fix="drop all but one", code="E407")
    if missing:
        raise SstlError(f"misses column {', '.join(missing)}", where=where, fix="rename it", code="E407")
