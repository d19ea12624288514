"""From planned channels to chunks of log columns, on one clock, block by block."""

from __future__ import annotations

from collections.abc import Iterator

from sstl_cli.importers.base import Notes
from sstl_cli.importers.chunk import Chunk
from sstl_cli.importers.clocks import ClockReport
from sstl_cli.importers.columns import Advance, blocks_of, label_of
from sstl_cli.importers.gridded import gridded
from sstl_cli.importers.plan import Plan


def chunks(
    plan: Plan, skip: int, align: str, max_offset_s: float | None, notes: Notes, clocks: list[ClockReport], advance: Advance
) -> Iterator[Chunk]:
    """Yield the chunks of one recording.

    Channels with several clocks are put on the grid of the reference clock by linear interpolation; what the clocks
    differ by goes to ``clocks``.
    """
    if len(plan.clocks) == 1:
        yield from _streamed(plan, skip, notes, advance)
    else:
        yield from gridded(plan, skip, align, max_offset_s, notes, clocks, advance)


def _streamed(plan: Plan, skip: int, notes: Notes, advance: Advance) -> Iterator[Chunk]:
    for block, index in blocks_of(plan, plan.clock, plan.signals, plan.labels, notes, advance):
        start = min(max(skip - index, 0), len(block))
        n = len(block)
        if start == n:
            continue
        signals = {"time_s": plan.clock.times(block.columns, len(block), index)[start:]}
        for signal in plan.signals:
            signals[signal.target] = signal.values(block.columns)[start:]
        yield Chunk(signals, {k: label_of(block.columns[c], n, start) for k, c in plan.labels.items()})
