"""What the reading of logs sets aside in one call: which run, how many samples, why."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass

# what is told run by run, of many runs; the others are counted: a million lines tell no more
LISTED = 1000


@dataclass(frozen=True)
class Aside:
    """Samples of a run that are not used (none where it was only split), how many it had, and why."""

    run_id: str
    samples: int
    of: int
    why: str

    def __str__(self) -> str:
        lost = f"{self.samples} of {self.of} samples: " if self.samples else ""
        return f"run {self.run_id}: {lost}{self.why}"


class Ledger:
    """What the reading of one call set aside, in the order read: the first entries, and of the others how many and of how many samples."""

    def __init__(self) -> None:
        self.entries: list[Aside] = []
        self.more = 0
        self.more_samples = 0

    def add(self, entries: Iterable[Aside]) -> None:
        """Take entries; beyond the first LISTED they are counted."""
        for entry in entries:
            if len(self.entries) < LISTED:
                self.entries.append(entry)
            else:
                self.more += 1
                self.more_samples += entry.samples

    def brief(self) -> str:
        """Return the first entry, and how many more there are, as one line ('' where nothing was set aside)."""
        others = len(self.entries) - 1 + self.more
        more = f", and {others} more" if others > 0 else ""
        return f"{self.entries[0]}{more}" if self.entries else ""


_LEDGER: ContextVar[Ledger | None] = ContextVar("ledger", default=None)


def open_ledger() -> Ledger:
    """Return a new ledger; from here on the runs that are read note in it what they lose."""
    book = Ledger()
    _LEDGER.set(book)
    return book


@contextmanager
def kept_apart() -> Iterator[None]:
    """Let what one call of the program notes be forgotten after it."""
    token = _LEDGER.set(Ledger())
    try:
        yield
    finally:
        _LEDGER.reset(token)


def ledger() -> Ledger | None:
    """Return the ledger that is open, if one is."""
    return _LEDGER.get()
