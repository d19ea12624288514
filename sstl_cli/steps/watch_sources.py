"""Where a watch gets its samples: growing text files, and folders in which finished files appear."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Protocol

from sstl_cli.core.errors import SstlError
from sstl_cli.core.runs import Run, recorded_runs
from sstl_cli.importers.follow import TextFollower
from sstl_cli.importers.mapping import Mapping
from sstl_cli.steps import import_

# a file that cannot be read and has not grown for so many looks is damaged
PATIENCE = 20


class Source(Protocol):
    """Something to look at again and again."""

    set_aside: dict[str, int]
    notes: list[str]

    def look(self, last: bool = False) -> Iterator[Run]:
        """Yield the pieces of runs that came since the last look."""
        ...


def source_of(text: str, mapping: Mapping) -> Source:
    """Return the source a user named: a folder, a pattern of files, or one file."""
    path = Path(text)
    if path.is_dir():
        return Chunks(path, "*.parquet", mapping)
    if any(c in path.name for c in "*?[") and not path.exists():
        return Chunks(path.parent, path.name, mapping)
    if path.suffix.lower() == ".parquet":
        return Chunks(path.parent, path.name, mapping, pattern=False)
    return TextFollower(path, mapping)


class Chunks:
    """Files of a folder, read once each when they are whole, in the order of their names."""

    def __init__(self, folder: Path, name: str, mapping: Mapping, pattern: bool = True) -> None:
        self.folder, self.name, self.mapping, self.pattern = folder, name, mapping, pattern
        self.set_aside: dict[str, int] = {}
        self.notes: list[str] = []
        self._done: set[str] = set()
        self._waiting: dict[str, tuple[int, int]] = {}

    def look(self, last: bool = False) -> Iterator[Run]:
        """Yield the runs of files that are new; one still being written is tried again."""
        names = [p.name for p in self.folder.glob(self.name)] if self.pattern else [self.name]
        for name in sorted(n for n in names if n not in self._done and not n.startswith(".")):
            path = self.folder / name
            if not path.is_file():
                continue
            try:
                # whole before any of it counts: a file that breaks off half-way is read again later
                runs = list(self._runs(path))
            except SstlError as error:
                if not self._hopeless(path, last):
                    # what comes after it must wait: samples are fed in order
                    return
                self.set_aside["file that cannot be read"] = self.set_aside.get("file that cannot be read", 0) + 1
                self.notes.append(f"set aside: {error.line()}")
                runs = []
            self._done.add(name)
            yield from runs

    def _runs(self, path: Path) -> Iterator[Run]:
        if path.suffix.lower() == ".parquet" and not self.mapping.columns:
            # pauses and faulty samples are sorted out over the ends of files, by the watcher
            yield from recorded_runs(path)
            return
        result = import_.run([path], self.mapping)
        yield from result.runs
        for reason, count in result.counts.notes.set_aside.items():
            self.set_aside[reason] = self.set_aside.get(reason, 0) + count

    def _hopeless(self, path: Path, last: bool) -> bool:
        size = path.stat().st_size
        before, looks = self._waiting.get(path.name, (-1, 0))
        looks = looks + 1 if size == before else 0
        self._waiting[path.name] = (size, looks)
        return last or looks >= PATIENCE
