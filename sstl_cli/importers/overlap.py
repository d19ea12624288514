"""Blocks of a recording cut to the rows between the first and the last at which every other clock has a value."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np

from sstl_cli.importers.base import Notes
from sstl_cli.importers.chunk import Chunk, joined, rows_of
from sstl_cli.importers.columns import Advance

# rows behind the last known value that wait for the next one; with more, the end is looked up by reading ahead
WAITING_ROWS = 1 << 20
# rows that go on together: what counts as a gap is learned from the first of them
LEAST_ROWS = 4096
OUTSIDE = "outside the overlap of the clocks"


def overlapping(
    merged: Callable[[Advance], Iterator[Chunk]], targets: Sequence[str], notes: Notes, advance: Advance
) -> Iterator[tuple[Chunk, int]]:
    """Yield the chunks inside the overlap, each with the place of its first row; the rows outside are set aside.

    Parameters
    ----------
    merged : callable
        Gives the blocks from the first on, each time it is called.
    targets : sequence of str
        The columns that come from other clocks.
    """
    seen = _Seen(targets)
    end: int | None = None
    waiting = _Waiting()
    for chunk in merged(advance):
        seen.add(chunk)
        outside = len(chunk) if seen.begin is None else min(max(seen.begin - (seen.rows - len(chunk)), 0), len(chunk))
        notes.aside(OUTSIDE, outside)
        waiting.add(rows_of(chunk, slice(outside, None)), seen.rows)
        if end is None and waiting.first + waiting.rows - 1 - seen.end > WAITING_ROWS:
            end = _end(merged, targets)
        sure = 1 + (seen.end if end is None else end)
        if sure - waiting.first >= LEAST_ROWS:
            yield from waiting.until(sure)
        if end is not None and seen.rows > end:
            yield from waiting.until(sure)
            notes.aside(OUTSIDE, waiting.rows)
            waiting = _Waiting()
    yield from waiting.until(1 + seen.end)
    notes.aside(OUTSIDE, waiting.rows)


class _Waiting:
    """Rows of which it is not known yet whether they lie inside; ``first`` is the place of the first one."""

    def __init__(self) -> None:
        self.chunks: list[Chunk] = []
        self.first = self.rows = 0

    def add(self, chunk: Chunk, stop: int) -> None:
        """Take in the rows that end before row ``stop`` of the recording."""
        if not len(chunk):
            return
        if not self.rows:
            self.first = stop - len(chunk)
        self.chunks.append(chunk)
        self.rows += len(chunk)

    def until(self, stop: int) -> Iterator[tuple[Chunk, int]]:
        """Yield the rows before row ``stop``, if any, with the place of the first."""
        many = min(stop - self.first, self.rows)
        if many <= 0:
            return
        whole, first = joined(*self.chunks), self.first
        rest = rows_of(whole, slice(many, None))
        self.chunks = [rest] if len(rest) else []
        self.first, self.rows = first + many, len(rest)
        yield rows_of(whole, slice(0, many)), first


@dataclass
class _Seen:
    """How many rows were seen, and between which rows each column had values."""

    targets: Sequence[str]
    rows: int = 0
    first: dict[str, int] = field(default_factory=dict)
    last: dict[str, int] = field(default_factory=dict)

    def add(self, chunk: Chunk) -> None:
        for name in self.targets:
            finite = np.flatnonzero(np.isfinite(chunk.signals[name]))
            if len(finite):
                self.first.setdefault(name, self.rows + int(finite[0]))
                self.last[name] = self.rows + int(finite[-1])
        self.rows += len(chunk)

    @property
    def begin(self) -> int | None:
        """First row at which every column has begun, None until then."""
        return max(self.first.values()) if len(self.first) == len(self.targets) else None

    @property
    def end(self) -> int:
        """Last row up to which no column has ended so far, -1 where one has not begun."""
        return min(self.last.values()) if len(self.last) == len(self.targets) else -1


def _end(merged: Callable[[Advance], Iterator[Chunk]], targets: Sequence[str]) -> int:
    """Return the last row of the overlap, read from all blocks."""
    seen = _Seen(targets)
    for chunk in merged(lambda _: None):
        seen.add(chunk)
    return seen.end
