"""Rows of the comparison, and how their times are taken."""

from __future__ import annotations

import gc
import statistics
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

SHARE_OF_STORED = 0.7


@dataclass(frozen=True)
class Row:
    """One comparison; ``values`` are the measured ratios (or seconds, or percent), one a repetition.

    ``at_least`` says on which side of ``goal`` a value is good; ``unit`` follows the number in print.
    """

    id: str
    job: str
    against: str
    goal: float | None
    values: tuple[float, ...]
    at_least: bool = True
    unit: str = "x"
    seconds: dict[str, float] = field(default_factory=dict)
    note: str = ""

    @property
    def median(self) -> float:
        return statistics.median(self.values)

    @property
    def met(self) -> bool | None:
        """Whether the median reaches the goal; None without a goal."""
        if self.goal is None:
            return None
        return self.median >= self.goal if self.at_least else self.median <= self.goal

    def document(self) -> dict[str, Any]:
        """Return the row as plain values."""
        return {
            "id": self.id,
            "job": self.job,
            "against": self.against,
            "goal": self.goal,
            "at_least": self.at_least,
            "unit": self.unit,
            "median": rounded(self.median),
            "low": rounded(min(self.values)),
            "high": rounded(max(self.values)),
            "repetitions": len(self.values),
            "met": self.met,
            "seconds": {k: rounded(v) for k, v in self.seconds.items()},
            "note": self.note,
        }


Clock = Callable[[], float]


def seconds(work: Callable[[], object], clock: Clock = time.process_time) -> float:
    """Return the processor time of one call (s, all threads), without the collection of older garbage in between.

    On a machine with other work the wall clock tells more of that work than of this one.
    """
    gc.collect()
    gc.disable()
    try:
        before = clock()
        work()
        return clock() - before
    finally:
        gc.enable()


def paired(
    ours: Callable[[], object], peer: Callable[[], object], repeat: int, clock: Clock = time.process_time
) -> tuple[list[float], list[float]]:
    """Return the times of both, taken in turn so that a busy machine slows both; ours is called once before."""
    ours()
    first, second = [], []
    for _ in range(repeat):
        first.append(seconds(ours, clock))
        second.append(seconds(peer, clock))
    return first, second


def faster(ours: list[float], peer: list[float], factor: float = 1.0) -> tuple[float, ...]:
    """Return how many times faster ours is, the peer having done 1/factor of the work."""
    return tuple(factor * b / a for a, b in zip(ours, peer, strict=True))


def fell(row: dict[str, Any], stored: dict[str, Any]) -> bool:
    """Whether a ratio is worse than the stored one by more than 30 %."""
    if row["unit"] != "x" or stored.get("unit") != "x" or stored["median"] <= 0.0 or row["median"] <= 0.0:
        return False
    change = row["median"] / stored["median"]
    return change < SHARE_OF_STORED if row["at_least"] else 1.0 / change < SHARE_OF_STORED


def rounded(value: float) -> float:
    """Return a value with three digits: more would only be noise in the stored file."""
    return float(f"{value:.3g}")
