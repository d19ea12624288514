"""What a block of a log holds of each run, and runs put together from the parts of several blocks."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from sstl_cli.core.sound import CHANNELS, OPTIONAL

Array = NDArray[np.float64]
SIGNALS = CHANNELS
LABELS = ("run_id", "config_id", "system", "location", "lead_mm", "trajectory", "tendon")
TEXTS = tuple(n for n in LABELS if n != "lead_mm")


@dataclass(frozen=True)
class Part:
    """What one block holds of one run: its labels, the signals, which of them are null throughout, labels that change in it."""

    labels: dict[str, str | None]
    lead_mm: float | None
    signals: dict[str, Array]
    empty: frozenset[str]
    changes: tuple[str, ...]


class Pending:
    """A run of which more may come: its first part, or all parts in arrays that grow, so that no block outlives its copy."""

    def __init__(self, head: Part) -> None:
        self.head, self.rows = head, len(head.signals["time_s"])
        self._grown: dict[str, Array] = {}

    def add(self, part: Part) -> None:
        """Append what another block holds of the run."""
        if not self._grown:
            self._grown = {n: np.array(v) for n, v in self.head.signals.items() if n not in self.head.empty}
            # only its labels are still asked for: its block need not be kept
            self.head = replace(self.head, signals=dict.fromkeys(self.head.signals, np.empty(0)))
        before, self.rows = self.rows, self.rows + len(part.signals["time_s"])
        for name, values in part.signals.items():
            if name not in self._grown:
                if name in part.empty:
                    continue
                self._grown[name] = np.full(before, np.nan)
            whole = self._grown[name]
            # in place: the system moves pages of a long array, not their content
            whole.resize(self.rows, refcheck=False)
            whole[before:] = np.nan if name in part.empty else values

    def signals(self) -> dict[str, Array | None]:
        """Return the whole channels, None where all parts are null."""
        if self._grown:
            return {n: self._grown.get(n) for n in self.head.signals}
        return {n: None if n in self.head.empty else v for n, v in self.head.signals.items()}


def parts(block: pa.Table) -> Iterator[Part]:
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
        yield Part(
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
