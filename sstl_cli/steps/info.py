"""Summaries of tables run by run, and a small loop drawn in characters."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING

import numpy as np

from sstl_cli.core.runs import Run
from sstl_cli.core.sound import LARGEST

if TYPE_CHECKING:
    # pydantic is not imported for a call that shows no document
    from sstl_cli.core.documents.logs import LogRun

# dots of a braille cell by (column, row)
_DOTS = ((0x01, 0x02, 0x04, 0x40), (0x08, 0x10, 0x20, 0x80))


@dataclass(slots=True)
class RunSummary:
    """What one run of a log holds; times in s, tensions in N."""

    run_id: str
    system: str | None
    config_id: str | None
    location: str | None
    samples: int
    start_s: float
    end_s: float
    in_min_n: float
    in_max_n: float
    out_min_n: float
    out_max_n: float

    @property
    def rate_hz(self) -> float | None:
        """Mean sampling rate in Hz."""
        length = self.end_s - self.start_s
        return (self.samples - 1) / length if self.samples > 1 and length > 0 else None

    def document(self) -> LogRun:
        """Return the run as ``sstl info --json`` tells it."""
        from sstl_cli.core.documents.logs import LogRun

        return LogRun(**asdict(self), duration_s=self.end_s - self.start_s, rate_hz=self.rate_hz)

    def add(self, other: RunSummary) -> None:
        """Take in another stretch of the same run."""
        self.samples += other.samples
        self.start_s, self.end_s = min(self.start_s, other.start_s), max(self.end_s, other.end_s)
        self.in_min_n, self.in_max_n = min(self.in_min_n, other.in_min_n), max(self.in_max_n, other.in_max_n)
        self.out_min_n, self.out_max_n = min(self.out_min_n, other.out_min_n), max(self.out_max_n, other.out_max_n)


def run(parts: Iterable[RunSummary]) -> list[RunSummary]:
    """Return one summary a run, in order of appearance, from summaries of stretches of runs."""
    merged: dict[str, RunSummary] = {}
    for part in parts:
        if part.run_id in merged:
            merged[part.run_id].add(part)
        else:
            merged[part.run_id] = part
    return list(merged.values())


def summary_of(run: Run) -> RunSummary:
    """Return the summary of a run in memory."""
    ends = [float(f(v)) for v in (run.time_s, run.tension_in_n, run.tension_out_n) for f in (np.min, np.max)]
    return RunSummary(run.run_id, run.system, run.config_id, run.location, len(run), *ends)


def draw_loop(x: Sequence[float], y: Sequence[float], width: int = 44, height: int = 11) -> list[str]:
    """Return lines of braille characters that show y over x, joined by straight strokes; empty where there is no area.

    Examples
    --------
    >>> draw_loop([0.0, 1.0], [0.0, 1.0], 2, 1)
    ['⡠⠊']
    """
    pairs = [(a, b) for a, b in zip(x, y, strict=True) if a is not None and b is not None and abs(a) <= LARGEST and abs(b) <= LARGEST]
    if len(pairs) < 2:
        return []
    x0, x1 = min(p[0] for p in pairs), max(p[0] for p in pairs)
    y0, y1 = min(p[1] for p in pairs), max(p[1] for p in pairs)
    if x1 <= x0 or y1 <= y0:
        return []
    across, down = 2 * width - 1, 4 * height - 1
    cells = [[0] * width for _ in range(height)]
    last: tuple[int, int] | None = None
    for a, b in pairs:
        point = (round((a - x0) / (x1 - x0) * across), round((y1 - b) / (y1 - y0) * down))
        for c, r in _stroke(last or point, point):
            cells[r // 4][c // 2] |= _DOTS[c % 2][r % 4]
        last = point
    return ["".join(chr(0x2800 + cell) for cell in row) for row in cells]


def _stroke(a: tuple[int, int], b: tuple[int, int]) -> list[tuple[int, int]]:
    steps = max(abs(b[0] - a[0]), abs(b[1] - a[1]), 1)
    return [(a[0] + round((b[0] - a[0]) * i / steps), a[1] + round((b[1] - a[1]) * i / steps)) for i in range(steps + 1)]
