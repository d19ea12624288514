"""Channels with clocks of their own on the grid of the reference clock, read in pieces.

A first pass over every clock says where it begins and ends and keeps a thinned series, from which offset and drift are
found. In the second pass the reference is read block by block and the others follow it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from sstl_cli.core.errors import SstlError
from sstl_cli.importers.base import Notes
from sstl_cli.importers.chunk import Chunk, rows_of
from sstl_cli.importers.clocks import ClockReport, compare, drift_tells, on_grid
from sstl_cli.importers.columns import Advance, blocks_of, label_of
from sstl_cli.importers.finder import TimeBase
from sstl_cli.importers.overlap import overlapping
from sstl_cli.importers.plan import Plan, Signal
from sstl_cli.importers.thinned import Thinned, advancing

Array = NDArray[np.float64]
Moved = Callable[[Array], Array]
Pair = tuple[Signal, Signal]


def gridded(
    plan: Plan, skip: int, align: str, max_offset_s: float | None, notes: Notes, reports: list[ClockReport], advance: Advance
) -> Iterator[Chunk]:
    """Yield the chunks of a recording with several clocks, without what lies outside their overlap."""
    others = plan.clocks[1:]
    pairs = {clock: _compared(plan, clock) for clock in others}
    # the reference is read twice, so are the others; what a reader sets aside is counted once
    seen = _first_look(plan, pairs, notes, lambda done: advance(done / 2))
    moves: dict[TimeBase, Moved] = {}
    for clock in others:
        _must_meet(plan, clock, seen[plan.clock], seen[clock], align)
        moves[clock] = _met(plan, clock, seen, pairs[clock], align, max_offset_s, reports)

    def merged(told: Advance) -> Iterator[Chunk]:
        return _merged(plan, moves, told)

    targets = [s.target for s in plan.signals if s.clock != plan.clock]
    for chunk, row in overlapping(merged, targets, notes, lambda done: advance(done / 2)):
        start = max(skip - row, 0)
        if start < len(chunk):
            yield rows_of(chunk, slice(start, None))


@dataclass
class _Look:
    """What a first pass over a clock found: its first time, its first and last finite ones (s), how many, and thinned series."""

    first: float = np.nan
    begin: float = np.nan
    end: float = np.nan
    rows: int = 0
    series: dict[str, Thinned] = field(default_factory=dict)

    @property
    def span(self) -> tuple[float, float, float, int]:
        """What two copies of one clock have in common."""
        return self.first, self.begin, self.end, self.rows

    def add(self, time: Array) -> None:
        finite = time[np.isfinite(time)]
        self.rows += len(finite)
        if np.isnan(self.begin) and len(finite):
            self.begin = float(finite[0])
        if len(finite):
            self.end = float(finite[-1])


def _first_look(plan: Plan, pairs: dict[TimeBase, Pair | None], notes: Notes, advance: Advance) -> dict[TimeBase, _Look]:
    """Return what every clock holds; what is set aside on the others is counted here."""
    compared = [s for pair in pairs.values() if pair is not None for s in pair]
    found: dict[TimeBase, _Look] = {}
    for clock in plan.clocks:
        mine = [s for s in plan.signals if s.clock == clock]
        series = [s for s in dict.fromkeys(compared) if s.clock == clock]
        look = _Look(series={s.target: Thinned() for s in series})
        labels = plan.labels if clock == plan.clock else {}
        top, rows = -np.inf, 0
        for block, index in blocks_of(plan, clock, [*mine, *series], labels, notes, advance):
            time = clock.times(block.columns, len(block), index)
            if clock != plan.clock:
                keep, top = advancing(time, top)
                notes.aside("repeated or backward time on a second clock", int(np.isfinite(time).sum() - keep.sum()))
            else:
                keep = np.ones(len(time), bool)
            if np.isnan(look.first) and keep.any():
                look.first = float(time[keep][0])
            rows += len(time)
            look.add(time[keep])
            for signal in series:
                look.series[signal.target].add(time[keep], signal.values(block.columns)[keep])
        if not rows:
            raise SstlError(
                f"clock '{clock.channel}' has no sample",
                where=str(plan.files[clock.file].path),
                fix="leave it out of the mapping, or record it",
                code="E340",
            )
        found[clock] = look
    return found


def _compared(plan: Plan, clock: TimeBase) -> Pair | None:
    """Return what the two clocks are compared by: shared content, else input and output; None where one has nothing."""
    if plan.content is not None:
        a, b = plan.content
        if (a.clock, b.clock) == (clock, plan.clock):
            a, b = b, a
        if (a.clock, b.clock) == (plan.clock, clock):
            return a, b
    mine = [s for s in plan.signals if s.clock == plan.clock]
    theirs = [s for s in plan.signals if s.clock == clock]
    return (mine[0], theirs[0]) if mine and theirs else None


def _met(
    plan: Plan,
    clock: TimeBase,
    seen: dict[TimeBase, _Look],
    pair: Pair | None,
    align: str,
    max_offset_s: float | None,
    reports: list[ClockReport],
) -> Moved:
    """Return how times of a clock become those of the reference; an estimate goes to ``reports``."""
    here, there = seen[plan.clock], seen[clock]
    if align == "start":
        # both recorders were started together: their first samples are the same instant
        first, zero = there.first, here.first
        return lambda time: time - first + zero
    if align not in ("report", "apply"):
        return _as_is
    if align == "report" and plan.content is None and clock.file == plan.clock.file and here.span == there.span:
        # channels of one recorder, each with its own copy of the clock: a lag between them is friction's
        return _as_is
    none = (np.empty(0), np.empty(0))
    a, b = (here.series[pair[0].target].arrays(), there.series[pair[1].target].arrays()) if pair else (none, none)
    report = compare(_name(plan, plan.clock), _name(plan, clock), *a, *b, max_offset_s, shared=plan.content is not None)
    applied = align == "apply" and report.estimated
    # friction's loop, which pulls the content of pull and release apart, is fitted by a drift as well
    told = applied or report.shared_content or not report.estimated or drift_tells(report, *a, *b)
    reports.append(report.applied(applied) if told else replace(report, drift_ppm=None, drift_se_ppm=None))
    return report.to_reference if applied else _as_is


def _as_is(time: Array) -> Array:
    return time


def _merged(plan: Plan, moves: dict[TimeBase, Moved], advance: Advance) -> Iterator[Chunk]:
    """Yield the blocks of the reference with the values of the other clocks at its times, NaN where they have none."""
    mine = [s for s in plan.signals if s.clock == plan.clock]
    followers = [_Follower(plan, clock, moved, advance) for clock, moved in moves.items()]
    for block, index in blocks_of(plan, plan.clock, mine, plan.labels, Notes(), advance):
        time = plan.clock.times(block.columns, len(block), index)
        signals = {"time_s": time, **{s.target: s.values(block.columns) for s in mine}}
        for follower in followers:
            signals.update(follower.at(time))
        yield Chunk(signals, {k: label_of(block.columns[c], len(block), 0) for k, c in plan.labels.items()})


class _Follower:
    """The channels of another clock at the times of the reference; holds one block at a time.

    Where the reference goes back behind what is held, the file is read again from its beginning.
    """

    def __init__(self, plan: Plan, clock: TimeBase, moved: Moved, advance: Advance) -> None:
        self.plan, self.clock, self.moved, self.advance = plan, clock, moved, advance
        self.signals = [s for s in plan.signals if s.clock == clock]
        self._rewind()

    def at(self, time: Array) -> dict[str, Array]:
        """Return the values at times of the reference (s), shape (n,), that come in any order."""
        order = np.argsort(time, kind="stable")
        wanted = time[order]
        n = int(np.isfinite(wanted).sum())
        if n and self.began and wanted[0] < self.time[0]:
            self._rewind()
        found = {s.target: np.full(len(time), np.nan) for s in self.signals}
        done = 0
        while done < n:
            stop = int(np.searchsorted(wanted[:n], self.time[-1], "right")) if len(self.time) else 0
            for signal in self.signals if stop > done else ():
                name = signal.target
                found[name][order[done:stop]] = on_grid(wanted[done:stop], self.time, self.values[name])
            done = max(done, stop)
            if done < n and not self._read():
                break
        return found

    def _rewind(self) -> None:
        self.time: Array = np.empty(0)
        self.values: dict[str, Array] = {s.target: np.empty(0) for s in self.signals}
        self.top = -np.inf
        # whether what is held is no longer the beginning of the file
        self.began = False
        self.blocks = blocks_of(self.plan, self.clock, self.signals, {}, Notes(), self.advance)

    def _read(self) -> bool:
        """Hold the next block behind the last sample of this one; False at the end of the file."""
        for block, index in self.blocks:
            time = self.clock.times(block.columns, len(block), index)
            keep, self.top = advancing(time, self.top)
            if not keep.any():
                continue
            self.began = self.began or len(self.time) > 1
            # between two blocks a line joins their nearest samples
            self.time = np.concatenate((self.time[-1:], self.moved(time[keep])))
            for s in self.signals:
                self.values[s.target] = np.concatenate((self.values[s.target][-1:], s.values(block.columns)[keep]))
            return True
        return False


def _must_meet(plan: Plan, clock: TimeBase, here: _Look, there: _Look, align: str) -> None:
    """Refuse clocks with another zero, such as unix time beside one from 0 s, unless it is said how they meet."""
    if align in ("apply", "start") or np.isnan(here.begin) or np.isnan(there.begin):
        return
    if there.begin <= here.end and here.begin <= there.end:
        return
    raise SstlError(
        f"clock '{_name(plan, clock)}' runs from {there.begin:.6g} to {there.end:.6g} s, "
        f"'{_name(plan, plan.clock)}' from {here.begin:.6g} to {here.end:.6g} s: they never meet",
        where=str(plan.files[clock.file].path),
        fix='in [clocks] write align = "start" if both were started together, or align = "apply" to find it by the motion',
        code="E357",
    )


def _name(plan: Plan, clock: TimeBase) -> str:
    name = clock.channel or f"{clock.rate_hz:g} Hz"
    return name if len(plan.files) == 1 else f"{plan.files[clock.file].path.name}:{name}"
