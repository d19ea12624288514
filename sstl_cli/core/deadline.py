"""A limit on time that leaves whole stages out, and says which."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field


@dataclass
class Deadline:
    """What may still begin: everything until ``seconds`` after ``since``, nothing that can be left out from then on.

    A stage that has begun is finished, so that no result is half of one.
    """

    seconds: float | None = None
    since: float | None = None
    clock: Callable[[], float] = time.monotonic
    left_out: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.since = self.clock() if self.since is None else self.since

    def passed(self, stage: str) -> bool:
        """Whether ``stage`` has to be left out; if so it is remembered."""
        over = self.seconds is not None and self.since is not None and self.clock() - self.since >= self.seconds
        if over:
            self.left_out.append(stage)
        return over

    @property
    def notes(self) -> list[str]:
        """What was left out, in words; nothing where nothing was.

        Examples
        --------
        >>> limit = Deadline(20.0, since=0.0, clock=lambda: 21.0)
        >>> limit.passed("triples"), limit.passed("odd runs")
        (True, True)
        >>> limit.notes
        ['left out after 20 s: triples, odd runs']
        """
        return [f"left out after {self.seconds:g} s: {', '.join(self.left_out)}"] if self.left_out else []
