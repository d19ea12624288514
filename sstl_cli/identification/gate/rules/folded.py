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
    yield from _inputs([e for e in log if e.usable and e.shapes.fold_in and e.dropouts[0] is None])
    hit = folds(log)
    # what goes to both sides of zero at the input (an angle, a difference of two tendons) has lost its sign, and no zero was wrong
    both = [e for e in hit if not e.tendon_like]
    hit = [e for e in hit if e.tendon_like]
    if both:
        ids = tuple(e.run_id for e in both)
        yield Remark(
            # a size without a sign may be meant where the output is no tension
            ids, RULE, "failure" if all(e.both_tensions for e in both) else "remark", 0.0, "N",
            f"{names(ids)}: the output turns back at zero against its input, which itself goes through zero, and goes with it once its sign is changed beyond; "
            "the absolute value of the output was probably taken",
            f"{CHANNELS[1]} = {{ column = (the reading with its sign) }}",
        )  # fmt: skip
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


def _inputs(hit: Sequence[Evidence]) -> Iterator[Remark]:
    """Yield runs whose input turns at zero while the output goes on."""
    if hit:
        ids = tuple(e.run_id for e in hit)
        yield Remark(
            # a size without a sign may be meant where a channel is no tension
            ids, RULE, "failure" if all(e.both_tensions for e in hit) else "remark", 0.0, "N",
            f"{names(ids)}: the input turns back at zero while the output goes on, and goes with it once its sign is changed beyond; "
            "the absolute value of the input was probably taken",
            f"{CHANNELS[0]} = {{ column = (the reading with its sign) }}",
        )  # fmt: skip
