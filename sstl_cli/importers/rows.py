"""Files that belong together row by row, such as one ``.npy`` a channel, read as one recording."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pyarrow as pa

from sstl_cli.core.errors import SstlError
from sstl_cli.importers.base import Block, Channel, Layout, Notes, Values, guarded
from sstl_cli.importers.finder import Recording


@dataclass(eq=False)
class JoinedRows:
    """A format made of files side by side: row n of each is the same sample."""

    parts: tuple[Recording, ...]
    ID: str = "rows"
    TITLE: str = "files joined row by row"
    EXTENSIONS: tuple[str, ...] = ()
    RANK: int = 0

    def names(self) -> dict[str, tuple[int, str]]:
        """Return where each channel stands; names that several files use get the file's stem in front."""
        count = Counter(c.name for p in self.parts for c in p.channels)
        return {
            c.name if count[c.name] == 1 else f"{p.path.stem}/{c.name}": (i, c.name) for i, p in enumerate(self.parts) for c in p.channels
        }

    def sniff(self, head: bytes, path: Path) -> bool:
        """Return False: files are joined because the mapping says so."""
        return False

    def channels(self, path: Path, layout: Layout) -> list[Channel]:
        """Return the channels of all files."""
        own = [{c.name: c for c in p.channels} for p in self.parts]
        return [replace(own[i][name], name=shown, time="") for shown, (i, name) in self.names().items()]

    def read(self, path: Path, numbers: list[str], labels: list[str], layout: Layout, notes: Notes) -> Iterator[Block]:
        """Yield blocks of the named channels.

        Raises
        ------
        SstlError
            If the files hold different numbers of rows.
        """
        names = self.names()
        readers = []
        for i, part in enumerate(self.parts):
            mine = {shown: own for shown, (at, own) in names.items() if at == i and shown in {*numbers, *labels}}
            if mine:
                readers.append(_Reader(part, mine, numbers, labels, notes))
        while True:
            ready = [r.fill() for r in readers]
            n = min(ready, default=0)
            if n == 0:
                break
            columns: dict[str, Values] = {}
            for reader in readers:
                columns.update(reader.take(n))
            yield Block(columns, sum(r.position for r in readers))
        if any(ready):
            short, long = readers[ready.index(0)], readers[ready.index(max(ready))]
            raise SstlError(
                f"has {short.rows} rows, '{long.part.path.name}' has more: row n of one does not belong to row n of the other",
                where=str(short.part.path),
                fix='cut them to the same rows, or use merge = "channels" with a time for each',
                code="E349",
            )


class _Reader:
    """One of the files: blocks in, any number of rows out."""

    def __init__(self, part: Recording, mine: dict[str, str], numbers: list[str], labels: list[str], notes: Notes) -> None:
        self.part, self.mine, self.position, self.rows = part, mine, 0, 0
        wanted = [own for shown, own in mine.items() if shown in numbers]
        texts = [own for shown, own in mine.items() if shown in labels]
        self._blocks = part.format.read(part.path, wanted, texts, part.layout, notes)
        self._held: dict[str, Values] = {}
        self._left = 0

    def fill(self) -> int:
        """Return how many rows are ready, 0 at the end."""
        while self._left == 0:
            with guarded(self.part.path, self.part.format.TITLE):
                block = next(self._blocks, None)
            if block is None:
                return 0
            self._held, self._left, self.position = block.columns, len(block), block.position
        return self._left

    def take(self, n: int) -> dict[str, Values]:
        """Return the next ``n`` rows of the wanted channels by the names they are shown under."""
        out: dict[str, Values] = {}
        for shown, own in self.mine.items():
            values = self._held[own]
            if len(values) == 1 and self._left > 1:
                out[shown] = np.repeat(values, n) if isinstance(values, np.ndarray) else pa.repeat(values[0], n)
                continue
            out[shown] = values[:n]
            self._held[own] = values[n:]
        self._left -= n
        self.rows += n
        return out
