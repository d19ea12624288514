"""From pieces of runs to whole loops: samples put in order, faulty ones set aside and counted."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from sstl_cli.core.run_parts import SIGNALS
from sstl_cli.core.runs import Run
from sstl_cli.core.sound import FASTEST_S, GAP_PERIODS, LARGEST, LEAST_GAP_S, LEAST_SAMPLES, TENSIONS, too_small, unsound
from sstl_cli.identification.loops import WARM_UP, LoopCutter, usual_step

Array = NDArray[np.float64]
# so many samples behind the clock are a clock that was set back, fewer are faulty stamps
SET_BACK = 20
# a loop is given up where it grows beyond this (an hour at 500 Hz)
LONGEST = 1_800_000
# a release at the end of a recording closes a loop if it comes back this near to where the loop began
NEAR = 0.25


@dataclass(frozen=True)
class Pieces:
    """A whole loop and the position of its first sample in its uninterrupted stretch of samples."""

    run: Run
    position: int


class Intake:
    """Sorts pieces by run; counts what it sets aside, by reason."""

    def __init__(self) -> None:
        self.set_aside: dict[str, int] = {}
        self.samples = 0
        self.breaks = 0
        # the run that grows on each rig, by its labels without the run_id
        self._runs: dict[tuple[str, str | None, str | None], tuple[str, _Growing]] = {}

    def add(self, piece: Run) -> Iterator[Pieces]:
        """Take the next samples of a run and yield the loops they complete."""
        rig = (piece.system, piece.config_id, piece.tendon)
        run_id, growing = self._runs.get(rig, ("", None))
        if growing is None or run_id != piece.run_id:
            if growing is not None:
                # the run before it on the same rig is over
                yield from growing.over()
            growing = _Growing(self, piece)
            self._runs[rig] = (piece.run_id, growing)
        self.samples += len(piece)
        yield from growing.add(piece)

    def end(self) -> Iterator[Pieces]:
        """Yield the loops that end with the recording."""
        for _, growing in self._runs.values():
            yield from growing.over()
        self._runs.clear()

    def aside(self, reason: str, count: int) -> None:
        """Count samples that are not used."""
        if count:
            self.set_aside[reason] = self.set_aside.get(reason, 0) + count


class _Growing:
    """One run: its open loop and the samples that wait for the clock to make sense."""

    def __init__(self, intake: Intake, first: Run) -> None:
        self.intake, self.labels = intake, first
        self.names = [n for n in SIGNALS if getattr(first, n) is not None]
        # the largest tension so far of either side, and of how many samples
        self.top, self.sound = np.zeros(2), 0
        self._restart()

    def _restart(self) -> None:
        self.cutter = LoopCutter()
        self.rows = np.empty((len(self.names), 0))
        self.behind = np.empty((len(self.names), 0))
        self.offset = 0
        self.start: int | None = None
        self.last = -math.inf
        self.step = math.nan
        self.fed = 0

    def add(self, piece: Run) -> Iterator[Pieces]:
        rows = np.stack([_signal(piece, n) for n in self.names])
        good = ~unsound(rows[:3]).any(axis=0)
        absurd = int(np.count_nonzero(np.isfinite(rows[:3]).all(axis=0) & ~good))
        self.intake.aside("not a number", int(np.count_nonzero(~good)) - absurd)
        self.intake.aside(f"beyond any sensor or clock (over {LARGEST:.0e})", absurd)
        self.top = np.maximum(self.top, np.abs(rows[1:3, good]).max(axis=1, initial=0.0))
        self.sound += int(np.count_nonzero(good))
        yield from self._ordered(rows[:, good])

    def _ordered(self, rows: Array) -> Iterator[Pieces]:
        """Let samples through whose time goes on; a clock that stays behind begins a new stretch."""
        while rows.shape[1]:
            top = np.maximum.accumulate(np.concatenate(([self.last], rows[0])))[:-1]
            late = rows[0] <= top
            at = int(np.argmax(late)) if late.any() else rows.shape[1]
            if at:
                if self.behind.shape[1]:
                    self.intake.aside("time repeats or runs backwards", self.behind.shape[1])
                    self.behind = self.behind[:, :0]
                yield from self._steady(rows[:, :at])
                rows = rows[:, at:]
                continue
            ahead = np.flatnonzero(rows[0] > self.last)
            end = int(ahead[0]) if len(ahead) else rows.shape[1]
            end = min(end, SET_BACK - self.behind.shape[1])
            self.behind = np.concatenate((self.behind, rows[:, :end]), axis=1)
            rows = rows[:, end:]
            if self.behind.shape[1] >= SET_BACK:
                again = self.behind
                if np.any(np.diff(again[0]) <= 0.0):
                    # not a clock that runs: what is behind stays behind
                    self.intake.aside("time repeats or runs backwards", SET_BACK)
                    self.behind = self.behind[:, :0]
                    continue
                yield from self._break()
                yield from self._steady(again)

    def _steady(self, rows: Array) -> Iterator[Pieces]:
        """Cut increasing samples at gaps and into loops."""
        if math.isnan(self.step) and self.fed + rows.shape[1] >= WARM_UP:
            self.step = usual_step(np.concatenate((self.rows[0], rows[0])))
            if self.step < FASTEST_S:
                self._too_fast(rows)
                return
        limit = max(GAP_PERIODS * self.step, LEAST_GAP_S) if not math.isnan(self.step) else math.inf
        steps = np.diff(np.concatenate(([self.last if math.isfinite(self.last) else rows[0, 0]], rows[0])))
        # the first steps tell the usual one: they are no gaps
        index = self.offset + self.rows.shape[1] + np.arange(len(steps))
        gaps = np.flatnonzero((steps > limit) & (index >= WARM_UP))
        if len(gaps):
            at = int(gaps[0])
            if at:
                yield from self._cut(rows[:, :at])
            yield from self._break()
            yield from self._steady(rows[:, at:])
            return
        yield from self._cut(rows)

    def _too_fast(self, rows: Array) -> None:
        """Set aside what no recorder's clock gave: time in another unit, or none."""
        self.intake.aside(f"a sampling period of {self.step:.3g} s, faster than any recorder", self.rows.shape[1] + rows.shape[1])
        self.rows, self.last, self.step = self.rows[:, :0], float(rows[0, -1]), math.nan

    def _cut(self, rows: Array) -> Iterator[Pieces]:
        self.rows = np.concatenate((self.rows, rows), axis=1)
        self.last = float(rows[0, -1])
        if math.isnan(self.step):
            # too few samples to know their rate
            return
        new = self.rows[1, self.fed - self.offset :]
        turns = self.cutter.add(new, self.step)
        self.fed += len(new)
        for turn in turns:
            if self.start is not None:
                yield from self._whole(self.start, turn)
            self.start = turn
        keep = self.start if self.start is not None else max(self.fed - LONGEST, 0)
        if self.fed - keep > LONGEST:
            self.intake.aside("no loop ends", self.fed - keep)
            self._restart()
        elif keep > self.offset and (self.start is not None or keep - self.offset > LONGEST):
            self.rows = self.rows[:, keep - self.offset :]
            self.offset = keep

    def _whole(self, start: int, stop: int) -> Iterator[Pieces]:
        part = self.rows[:, start - self.offset : stop - self.offset + 1]
        if part.shape[1] < LEAST_SAMPLES:
            return
        signals = {n: part[i].copy() for i, n in enumerate(self.names)}
        whole = replace(
            self.labels,
            time_s=signals["time_s"],
            tension_in_n=signals["tension_in_n"],
            tension_out_n=signals["tension_out_n"],
            position_in_mm=signals.get("position_in_mm"),
            tension_ref_n=signals.get("tension_ref_n"),
        )
        yield Pieces(whole, start)

    def _break(self) -> Iterator[Pieces]:
        yield from self.close()
        self.intake.breaks += 1
        self._restart()

    def over(self) -> Iterator[Pieces]:
        """Yield the loop that ends with the run, and set aside what no sensor can have given throughout."""
        yield from self.close()
        small = [said for name, top in zip(TENSIONS, self.top, strict=True) if (said := too_small(name, np.array([top])))]
        if small:
            self.intake.aside("; ".join(small), self.sound)

    def close(self) -> Iterator[Pieces]:
        """Yield the loop that ends with the samples at hand, if it came back to where it began."""
        stop = self.cutter.falling_to
        if self.start is None or stop is None:
            return
        part = self.rows[1, self.start - self.offset : stop - self.offset + 1]
        if len(part) and part[-1] <= part[0] + NEAR * float(np.ptp(part)):
            yield from self._whole(self.start, stop)


def _signal(piece: Run, name: str) -> Array:
    value = getattr(piece, name)
    return np.full(len(piece), np.nan) if value is None else np.asarray(value, np.float64)
