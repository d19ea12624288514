"""Blocks of a planned file as they are read, and the labels of the log in them."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import numpy as np
import pyarrow as pa

from sstl_cli.importers.base import Block, Notes, guarded, text_array
from sstl_cli.importers.finder import TimeBase
from sstl_cli.importers.plan import Plan, Signal

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


def label_of(values: object, n: int, start: int) -> pa.Array:
    """Return the labels of a block of ``n`` rows from row ``start`` on; a single one holds for all."""
    array = values if isinstance(values, pa.Array) else text_array(values)
    if len(array) == 1 and n > 1:
        array = pa.repeat(array[0], n)
    return array.slice(start)
