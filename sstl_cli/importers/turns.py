"""Runs whose rows take turns in a table, as where it is sorted by time: each brought together again."""

from __future__ import annotations

import tempfile
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from sstl_cli.core.sound import GAP_PERIODS
from sstl_cli.importers.chunk import Chunk, joined, rows_of
from sstl_cli.importers.counts import Counts

# how many rows of others may stand between two of a run that goes on; longer absences are another run of the same name
AWAY_ROWS = 65_536
# rows of runs that take turns that may stand in memory; what is more waits in an unnamed temporary file
MOST_ROWS = 1_000_000
# rows of the run that is open which are kept, to tell whether it goes on
KEPT_ROWS = 16
# signals and labels share one table there
_SIGNAL = "signal "
Key = tuple[str | None, ...]


def by_run(chunks: Iterable[Chunk], gap_s: float | None, counts: Counts, where: str) -> Iterator[Chunk]:
    """Yield chunks in which the rows of a run follow one another.

    A run whose label comes back goes on where its clock has gone on without a gap. One that begins anew, or after a pause,
    stays where it is: that is another run of the same name.

    Parameters
    ----------
    chunks : iterable of Chunk
        In the order of the file.
    gap_s : float, optional
        What counts as a gap (s); ten usual steps where it is not given.
    counts : Counts
        Told once that rows took turns.
    where : str
        The file, for messages.
    """
    waiting: list[Chunk] = []
    read = iter(chunks)
    for chunk in read:
        names = _names(chunk)
        if not waiting and not names:
            yield chunk
            continue
        waiting.append(chunk)
        if sum(map(len, waiting)) < 2 * AWAY_ROWS:
            continue
        whole = _Whole.of(waiting, names, gap_s)
        if whole.turns:
            yield from _together(whole, read, names, counts, where)
            return
        sure = whole.sure
        yield rows_of(whole.chunk, slice(0, sure))
        waiting = [rows_of(whole.chunk, slice(sure, None))]
    if waiting:
        names = _names(waiting[0])
        whole = _Whole.of(waiting, names, gap_s)
        yield from _together(whole, read, names, counts, where) if whole.turns else [whole.chunk]


def _together(whole: _Whole, more: Iterator[Chunk], names: list[str], counts: Counts, where: str) -> Iterator[Chunk]:
    """Yield the rows that wait and all that follow, run by run in order of appearance."""
    with _Runs() as runs:
        waiting, rows = [whole.chunk], len(whole.chunk)
        for chunk in more:
            waiting.append(chunk)
            rows += len(chunk)
            if rows >= MOST_ROWS:
                runs.add(_Whole.of(waiting, names, None), names)
                waiting, rows = [], 0
        if waiting:
            runs.add(_Whole.of(waiting, names, None), names)
        by = ", ".join(names)
        counts.remarks.append(f"{where}: rows of runs take turns (sorted by time?): {len(runs.places)} runs were brought together by {by}")
        yield from runs


def _names(chunk: Chunk) -> list[str]:
    """Return the labels that tell runs apart: run_id, without one all there are."""
    return ["run_id"] if "run_id" in chunk.labels else list(chunk.labels)


@dataclass(frozen=True)
class _Whole:
    """Rows in the order of the file, and the run of each by number, in order of appearance."""

    chunk: Chunk
    run: NDArray[np.int64]
    gap_s: float | None

    @classmethod
    def of(cls, chunks: list[Chunk], names: list[str], gap_s: float | None) -> _Whole:
        chunk = joined(*chunks)
        codes = [chunk.labels[n].dictionary_encode().indices.fill_null(-1).to_numpy(zero_copy_only=False).astype(np.int64) for n in names]
        new = np.ones(len(chunk), bool)
        new[1:] = np.any([np.diff(c) != 0 for c in codes], axis=0)
        heads = np.flatnonzero(new)
        _, first, run = np.unique(np.array([c[heads] for c in codes]), axis=1, return_index=True, return_inverse=True)
        rank = np.empty(len(first), np.int64)
        rank[np.argsort(first)] = np.arange(len(first))
        return cls(chunk, np.repeat(rank[run.reshape(-1)], np.diff(heads, append=len(chunk))), gap_s)

    @property
    def begins(self) -> NDArray[np.int64]:
        """The rows at which another run than that of the row before goes on or begins."""
        return np.flatnonzero(np.diff(self.run)) + 1

    @property
    def turns(self) -> bool:
        """Whether a run comes back and its clock has gone on by no more than it may from one sample to the next."""
        if not len(self.run) or len(self.begins) == int(self.run.max()):
            return False
        order = np.argsort(self.run, kind="stable")
        step = np.diff(self.chunk.signals["time_s"][order])
        same = np.diff(self.run[order]) == 0
        forward = step[same & (step > 0)]
        if not len(forward):
            return False
        gap = self.gap_s if self.gap_s is not None else GAP_PERIODS * float(np.median(forward))
        back = np.diff(order) > 1
        return bool((same & back & (step > 0) & (step <= gap)).any())

    @property
    def sure(self) -> int:
        """How many rows, from the first on, are of runs that nothing can be added to, or that go on with what stays."""
        n, begins = len(self.chunk), self.begins
        late = n - begins < AWAY_ROWS
        over = int(begins[~late][-1]) if (~late).any() else 0
        return max(over, (int(begins[late][0]) if late.any() else n) - KEPT_ROWS)

    def parts(self) -> Iterator[Chunk]:
        """Yield the rows of each run."""
        order = np.argsort(self.run, kind="stable")
        labels = {k: v.take(pa.array(order)) for k, v in self.chunk.labels.items()}
        chunk = Chunk({k: v[order] for k, v in self.chunk.signals.items()}, labels)
        cuts = [*np.searchsorted(self.run[order], np.arange(int(self.run.max()) + 1)), len(chunk)]
        for a, b in pairwise(cuts):
            yield rows_of(chunk, slice(a, b))


class _Runs:
    """Rows by run; the first are kept in memory, further ones in a file, and come back run by run."""

    def __init__(self) -> None:
        self.places: dict[Key, list[int | Chunk]] = {}

    def __enter__(self) -> _Runs:
        self._file = tempfile.TemporaryFile()
        return self

    def __exit__(self, *_: object) -> None:
        self._file.close()

    def add(self, whole: _Whole, names: list[str]) -> None:
        """Take in rows; those that are there already go to the file."""
        self._put_away()
        for part in whole.parts():
            self.places.setdefault(tuple(part.labels[n][0].as_py() for n in names), []).append(part)

    def _put_away(self) -> None:
        for places in self.places.values():
            if places and isinstance(part := places[-1], Chunk):
                places[-1] = self._file.tell()
                batch = pa.record_batch({**{_SIGNAL + k: v for k, v in part.signals.items()}, **part.labels})
                with pa.ipc.new_stream(self._file, batch.schema) as stream:
                    stream.write_batch(batch)

    def __iter__(self) -> Iterator[Chunk]:
        for places in self.places.values():
            for place in places:
                yield place if isinstance(place, Chunk) else self._back(place)

    def _back(self, place: int) -> Chunk:
        self._file.seek(place)
        with pa.ipc.open_stream(self._file) as stream:
            batch = stream.read_next_batch()
        names = [n for n in batch.schema.names if n.startswith(_SIGNAL)]
        signals = {n.removeprefix(_SIGNAL): batch.column(n).to_numpy(zero_copy_only=False).copy() for n in names}
        return Chunk(signals, {n: batch.column(n) for n in batch.schema.names if n not in names})
