"""From planned channels to chunks of log columns, on one clock, block by block where that is possible."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from sstl_cli.core.errors import SstlError
from sstl_cli.importers.base import ROWS_PER_BLOCK, Block, Notes, guarded, text_array
from sstl_cli.importers.chunk import Chunk
from sstl_cli.importers.clocks import ClockReport, compare, on_grid
from sstl_cli.importers.finder import TimeBase
from sstl_cli.importers.plan import Plan, Signal

Array = NDArray[np.float64]
Advance = Callable[[float], None]
# time and values by target, of every clock
Held = dict[TimeBase, tuple[Array, dict[str, Array]]]


def chunks(
    plan: Plan,
    skip: int,
    align: str,
    max_offset_s: float | None,
    notes: Notes,
    clocks: list[ClockReport],
    advance: Advance,
) -> Iterator[Chunk]:
    """Yield the chunks of one recording.

    With one clock the file is streamed. With several, every channel of the recording is held in memory and put on the
    grid of the reference clock by linear interpolation; what the clocks differ by goes to ``clocks``.
    """
    if len(plan.clocks) == 1 and plan.content is None:
        yield from _streamed(plan, skip, notes, advance)
    else:
        yield from _gridded(plan, skip, align, max_offset_s, notes, clocks, advance)


def _streamed(plan: Plan, skip: int, notes: Notes, advance: Advance) -> Iterator[Chunk]:
    for block, index in _blocks(plan, plan.clock, plan.signals, plan.labels, notes, advance):
        start = min(max(skip - index, 0), len(block))
        n = len(block)
        if start == n:
            continue
        signals = {"time_s": _time(plan.clock, block, index)[start:]}
        for signal in plan.signals:
            signals[signal.target] = _value(signal, block)[start:]
        yield Chunk(signals, {k: _label(block.columns[c], n, start) for k, c in plan.labels.items()})


def _blocks(
    plan: Plan,
    clock: TimeBase,
    signals: tuple[Signal, ...] | list[Signal],
    labels: dict[str, str],
    notes: Notes,
    advance: Advance,
) -> Iterator[tuple[Block, int]]:
    file = plan.files[clock.file]
    numbers = list(dict.fromkeys(c for s in signals for c in s.channels))
    if clock.channel is not None and clock.channel not in numbers:
        numbers.append(clock.channel)
    before = index = 0
    with guarded(file.path, file.format.TITLE):
        for block in file.format.read(file.path, numbers, list(dict.fromkeys(labels.values())), file.layout, notes):
            n = len(block)
            for name, values in block.columns.items():
                if len(values) == 1 and n > 1 and isinstance(values, np.ndarray):
                    block.columns[name] = np.full(n, values[0])
            yield block, index
            index += n
            advance(block.position - before)
            before = block.position


def _time(clock: TimeBase, block: Block, index: int) -> Array:
    if clock.rate_hz is not None:
        return np.asarray((np.arange(len(block)) + index) / clock.rate_hz)
    assert clock.channel is not None
    return _linear(np.asarray(block.columns[clock.channel], np.float64), clock.convert.factor, clock.convert.offset)


def _value(signal: Signal, block: Block) -> Array:
    return _linear(signal.recorded(block.columns), signal.convert.factor, signal.convert.offset)


def _linear(values: Array, factor: float, offset: float) -> Array:
    # values that need no conversion keep every bit
    if offset:
        values = values - offset
    with np.errstate(over="ignore", invalid="ignore"):
        return values if factor == 1.0 else values * factor


def _label(values: object, n: int, start: int) -> pa.Array:
    array = values if isinstance(values, pa.Array) else text_array(values)
    if len(array) == 1 and n > 1:
        array = pa.repeat(array[0], n)
    return array.slice(start)


def _gridded(
    plan: Plan,
    skip: int,
    align: str,
    max_offset_s: float | None,
    notes: Notes,
    reports: list[ClockReport],
    advance: Advance,
) -> Iterator[Chunk]:
    held, labels = _held(plan, notes, advance)
    reference, at_reference = held[plan.clock]
    signals = {"time_s": reference, **{k: v for k, v in at_reference.items() if not k.startswith("content")}}
    for clock in plan.clocks[1:]:
        time, report = _met(plan, held, clock, align, max_offset_s)
        if report is not None:
            reports.append(report)
        for name, series in held[clock][1].items():
            if not name.startswith("content"):
                signals[name] = on_grid(reference, time, series)
    inside = np.ones(len(reference), bool)
    for clock in plan.clocks[1:]:
        for signal in plan.signals:
            if signal.clock == clock:
                inside &= ~_outside(signals[signal.target])
    notes.aside("outside the overlap of the clocks", int(len(inside) - inside.sum()))
    keep = np.flatnonzero(inside)
    keep = keep[keep >= skip]
    for a in range(0, len(keep), ROWS_PER_BLOCK):
        rows = keep[a : a + ROWS_PER_BLOCK]
        yield Chunk({k: v[rows] for k, v in signals.items()}, {k: v.take(pa.array(rows)) for k, v in labels.items()})


def _held(plan: Plan, notes: Notes, advance: Advance) -> tuple[Held, dict[str, pa.Array]]:
    """Return time and values of every clock, and the labels of the reference."""
    every = [*plan.signals, *(plan.content or ())]
    held: Held = {}
    labels: dict[str, list[pa.Array]] = {k: [] for k in plan.labels}
    for clock in dict.fromkeys([*plan.clocks, *(s.clock for s in plan.content or ())]):
        mine = [s for s in every if s.clock == clock]
        times: list[Array] = []
        values: dict[str, list[Array]] = {s.target: [] for s in mine}
        wanted = plan.labels if clock == plan.clock else {}
        for block, index in _blocks(plan, clock, mine, wanted, notes, advance):
            times.append(_time(clock, block, index))
            for signal in mine:
                values[signal.target].append(_value(signal, block))
            for label, channel in wanted.items():
                labels[label].append(_label(block.columns[channel], len(block), 0))
        if not times:
            raise SstlError(
                f"clock '{clock.channel}' has no sample", where=str(plan.files[clock.file].path), code="E340"
            )
        held[clock] = _increasing(
            np.concatenate(times),
            {k: np.concatenate(v) for k, v in values.items()},
            notes,
            keep_all=clock == plan.clock,
        )
    return held, {k: pa.concat_arrays(v) for k, v in labels.items()}


def _met(
    plan: Plan, held: Held, clock: TimeBase, align: str, max_offset_s: float | None
) -> tuple[Array, ClockReport | None]:
    """Return the time of a clock as the reference counts it, and what they differ by where that is asked for."""
    reference, time = held[plan.clock][0], held[clock][0]
    _must_meet(plan, clock, reference, time, align)
    if align == "start" and len(time) and len(reference):
        # both recorders were started together: their first samples are the same instant
        return time - time[0] + reference[0], None
    if align not in ("report", "apply"):
        return time, None
    content = _content(plan, held, clock)
    shared = plan.content is not None
    report = compare(_name(plan, plan.clock), _name(plan, clock), *content, max_offset_s, shared=shared)
    applied = align == "apply" and report.estimated
    return report.to_reference(time) if applied else time, report.applied(applied)


def _must_meet(plan: Plan, clock: TimeBase, reference: Array, time: Array, align: str) -> None:
    """Refuse clocks with another zero, such as unix time beside one from 0 s, unless it is said how they meet."""
    here, there = reference[np.isfinite(reference)], time[np.isfinite(time)]
    if align in ("apply", "start") or not len(here) or not len(there):
        return
    if there[0] <= here[-1] and here[0] <= there[-1]:
        return
    raise SstlError(
        f"clock '{_name(plan, clock)}' runs from {there[0]:.6g} to {there[-1]:.6g} s, "
        f"'{_name(plan, plan.clock)}' from {here[0]:.6g} to {here[-1]:.6g} s: they never meet",
        where=str(plan.files[clock.file].path),
        fix='in [clocks] write align = "start" if both were started together, or align = "apply" to find it by the motion',
        code="E357",
    )


def _outside(values: Array) -> NDArray[np.bool_]:
    """Return the samples before the first and after the last finite one."""
    finite = np.flatnonzero(np.isfinite(values))
    outside = np.ones(len(values), bool)
    if len(finite):
        outside[finite[0] : finite[-1] + 1] = False
    return outside


def _increasing(time: Array, values: dict[str, Array], notes: Notes, keep_all: bool) -> tuple[Array, dict[str, Array]]:
    """Return the samples of a second clock that go forward; the reference is left for the repair to judge."""
    if keep_all:
        return time, values
    finite = np.isfinite(time)
    top = np.maximum.accumulate(np.where(finite, time, -np.inf))
    keep = finite & np.concatenate(([True], time[1:] > top[:-1]))
    notes.aside("repeated or backward time on a second clock", int(len(time) - keep.sum()))
    return time[keep], {k: v[keep] for k, v in values.items()}


def _content(
    plan: Plan, held: Held, clock: TimeBase
) -> tuple[Array, Array, Array, Array]:
    """Return time and values of what the two clocks are compared by: shared content, else input and output."""
    if plan.content is not None:
        a, b = plan.content
        if b.clock != clock or a.clock != plan.clock:
            a, b = (b, a) if (a.clock == clock and b.clock == plan.clock) else (a, b)
        if a.clock == plan.clock and b.clock == clock:
            return (*_pair(held, a), *_pair(held, b))
    mine = [s for s in plan.signals if s.clock == plan.clock]
    theirs = [s for s in plan.signals if s.clock == clock]
    if not mine:
        return (np.empty(0), np.empty(0), *_pair(held, theirs[0]))
    return (*_pair(held, mine[0]), *_pair(held, theirs[0]))


def _pair(held: Held, signal: Signal) -> tuple[Array, Array]:
    time, values = held[signal.clock]
    return time, values[signal.target]


def _name(plan: Plan, clock: TimeBase) -> str:
    name = clock.channel or f"{clock.rate_hz:g} Hz"
    return name if len(plan.files) == 1 else f"{plan.files[clock.file].path.name}:{name}"
