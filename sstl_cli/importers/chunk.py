"""Consecutive samples of one recording on their way from a file to runs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass
class Chunk:
    """Consecutive samples of one recording: signals (with ``time_s``) and labels of the same length."""

    signals: dict[str, Array]
    labels: dict[str, pa.Array]

    def __len__(self) -> int:
        return len(self.signals["time_s"])


def rows_of(chunk: Chunk, rows: slice | NDArray[np.bool_]) -> Chunk:
    """Return the samples of a chunk in a slice, or where a mask is true."""
    if isinstance(rows, slice):
        start, stop, _ = rows.indices(len(chunk))
        labels = {k: v.slice(start, max(stop - start, 0)) for k, v in chunk.labels.items()}
    else:
        labels = {k: v.filter(pa.array(rows)) for k, v in chunk.labels.items()}
    return Chunk({k: v[rows] for k, v in chunk.signals.items()}, labels)


def filled_rows(chunk: Chunk) -> int:
    """Return the number of rows down to the last one that holds any number."""
    if len(chunk) and not all(np.isnan(v[-1]) for v in chunk.signals.values()):
        return len(chunk)
    filled = np.flatnonzero(~np.all([np.isnan(v) for v in chunk.signals.values()], axis=0))
    return int(filled[-1]) + 1 if len(filled) else 0


def joined(*chunks: Chunk) -> Chunk:
    """Return chunks one after the other as one."""
    first = chunks[0]
    return Chunk(
        {k: np.concatenate([c.signals[k] for c in chunks]) for k in first.signals},
        {k: pa.concat_arrays([c.labels[k] for c in chunks]) for k in first.labels},
    )
