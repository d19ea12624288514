"""An output without its sign: below a zero that is off it rises again."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from sstl_cli.identification.gate.evidence import Evidence
from sstl_cli.identification.gate.remark import Remark, names
from sstl_cli.identification.gate.units import CHANNELS

RULE, RANK = "folded", 33
# correlation below which an output falls as its input rises
FALLS = -0.3


def look(log: Sequence[Evidence]) -> Iterator[Remark]:
    """Yield runs whose output friction explains, or whose input goes with the output, once its sign is put back."""
    inputs = [e for e in log if e.usable and e.shapes.fold_in and e.dropouts[0] is None]
    yield from _unsigned(inputs, 0, "the input turns back at zero while the output goes on")
    hit = folds(log)
    # what goes to both sides of zero at the input (an angle, a difference of two tendons) has lost its sign, and no zero was wrong
    both = [e for e in hit if not e.tendon_like]
    hit = [e for e in hit if e.tendon_like]
    yield from _unsigned(both, 1, "the output turns back at zero against its input, which itself goes through zero")
    if hit:
        size = float(np.median([e.shapes.fold_n for e in hit]))
        own = {e.run_id for e in hit}
        hit = [e for e in log if e.run_id in own or beyond_fold(e)]
        yield Remark(
            tuple(e.run_id for e in hit), RULE, "failure", size, "N",
            f"{names([e.run_id for e in hit])}: the output turns back at zero against its input, which no friction does, and goes with it once "
            f"its sign is changed beyond, with {size:.3g} N at no tension; it was probably rectified after its zero was taken under load",
            f"{CHANNELS[1]} = {{ column = (the reading with its sign), offset = (reading at no load, about {size:.3g}) }}",
        )  # fmt: skip


def folds(log: Sequence[Evidence]) -> list[Evidence]:
    """Return the runs whose output shows that it lost its sign below zero."""
    # a connector that lets go turns the output at zero as well
    return [e for e in log if e.usable and math.isfinite(e.shapes.fold_n) and e.dropouts[1] is None]


def beyond_fold(e: Evidence) -> bool:
    """Whether an output that falls as its input rises may be that of a sensor which folds in other runs, and here never comes back to zero."""
    never_negative = e.extremes[1][0] >= -e.sensors[1].noise_n
    return e.tendon_like and e.correlation < FALLS and never_negative


def _unsigned(hit: Sequence[Evidence], side: int, how: str) -> Iterator[Remark]:
    """Yield runs of which a channel (``side``: 0 the input, 1 the output) has lost its sign beyond zero, with no zero that was wrong."""
    if hit:
        ids, name = tuple(e.run_id for e in hit), ("input", "output")[side]
        yield Remark(
            # a size without a sign may be meant where a channel is no tension
            ids, RULE, "failure" if all(e.both_tensions for e in hit) else "remark", 0.0, "N",
            f"{names(ids)}: {how}, and goes with it once its sign is changed beyond; the absolute value of the {name} was probably taken",
            f"{CHANNELS[side]} = {{ column = (the reading with its sign) }}",
        )  # fmt: skip
