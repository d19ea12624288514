"""The part of a recording that is wanted: a time window, and samples dropped at its end."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np

from sstl_cli.importers.base import Notes
from sstl_cli.importers.chunk import Chunk, joined, rows_of
from sstl_cli.importers.mapping import Mapping


def windowed(chunks: Iterable[Chunk], mapping: Mapping, notes: Notes) -> Iterator[Chunk]:
    """Yield the chunks of one file without its last ``skip_end_samples`` and what lies outside the window.

    The window is told in s since the first sample of the file, so that it fits unix times and zero-based ones alike.
    """
    if mapping.skip_end_samples:
        chunks = _without_end(chunks, mapping.skip_end_samples, notes)
    low, high = mapping.time.from_s, mapping.time.to_s
    if low is None and high is None:
        yield from chunks
        return
    first: float | None = None
    for chunk in chunks:
        time = chunk.signals["time_s"]
        finite = time[np.isfinite(time)]
        if first is None and len(finite):
            first = float(finite[0])
        if first is None:
            continue
        since = time - first
        keep = ~((since < (low or 0.0)) | (since > (np.inf if high is None else high)))
        notes.trimmed += int(len(keep) - np.count_nonzero(keep))
        if keep.any():
            yield rows_of(chunk, keep)


def _without_end(chunks: Iterable[Chunk], samples: int, notes: Notes) -> Iterator[Chunk]:
    held: Chunk | None = None
    for chunk in chunks:
        held = chunk if held is None else joined(held, chunk)
        if len(held) > samples:
            yield rows_of(held, slice(0, len(held) - samples))
            held = rows_of(held, slice(len(held) - samples, None))
    notes.trimmed += len(held) if held is not None else 0
