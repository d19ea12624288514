"""Blocks of a planned file as they are read, and the times, values and labels of the log in them."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from sstl_cli.importers.base import Block, Notes, guarded, text_array
from sstl_cli.importers.finder import TimeBase
from sstl_cli.importers.plan import Plan, Signal

Array = NDArray[np.float64]
Advance = Callable[[float], None]


def blocks_of(
    plan: Plan, clock: TimeBase, signals: Sequence[Signal], labels: dict[str, str], notes: Notes, advance: Advance
) -> Iterator[tuple[Block, int]]:
    """Yield the blocks of a clock's file with its own channel and those of signals and labels, and their first row."""
    file = plan.files[clock.file]
    numbers = list(dict.fromkeys([*(c for s in signals for c in s.channels), *clock.channels]))
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


def time_of(clock: TimeBase, block: Block, index: int) -> Array:
    """Return the times (s) of a block whose first row is ``index``, shape (n,)."""
    if clock.rate_hz is not None:
        return np.asarray((np.arange(len(block)) + index) / clock.rate_hz)
    assert clock.channel is not None
    times = _linear(np.asarray(block.columns[clock.channel], np.float64), clock.convert.factor, clock.convert.offset)
    return times if clock.fraction is None else times + clock.fraction_s * np.asarray(block.columns[clock.fraction], np.float64)


def value_of(signal: Signal, block: Block) -> Array:
    """Return the values of a signal in a block in the log's unit, shape (n,)."""
    return _linear(signal.recorded(block.columns), signal.convert.factor, signal.convert.offset)


def _linear(values: Array, factor: float, offset: float) -> Array:
    # values that need no conversion keep every bit
    if offset:
        values = values - offset
    with np.errstate(over="ignore", invalid="ignore"):
        return values if factor == 1.0 else values * factor


def label_of(values: object, n: int, start: int) -> pa.Array:
    """Return the labels of a block of ``n`` rows from row ``start`` on; a single one holds for all."""
    array = values if isinstance(values, pa.Array) else text_array(values)
    if len(array) == 1 and n > 1:
        array = pa.repeat(array[0], n)
    return array.slice(start)
