"""An input that follows its reference at another scale, one of the two being in another unit, or not at all in one run of many."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from sstl_cli.identification.gate.beside import FOLLOWED
from sstl_cli.identification.gate.evidence import Evidence
from sstl_cli.identification.gate.remark import Remark, names
from sstl_cli.identification.gate.units import force_unit, stated

RULE, RANK = "reference", 26
APART = 2.0
# what a reference leaves of an input from which on it is not followed, and other runs that must show that it is
LEFT, FEW = math.sqrt(1.0 - FOLLOWED**2), 3
# part of the input's span by which readings in its own unit are off it where it is driven along them, and how much further another quantity is
READS, FURTHER = 0.12, 2.0


def look(log: Sequence[Evidence]) -> Iterator[Remark]:
    """Yield runs whose input is a multiple of the reference it tracks, or does not track it."""
    exchanged = [e for e in log if _exchanged(e, READS)]
    if 2 * len(exchanged) > sum(e.usable and math.isfinite(max(e.off)) for e in log):
        # one table has one order of columns: the runs that are tracked badly with those that tell
        exchanged = [e for e in log if _exchanged(e, math.inf)]
        off = float(np.median([e.off[0] for e in exchanged]))
        yield Remark(
            tuple(e.run_id for e in exchanged), RULE, "failure", 100.0 * off, "%",
            f"{names([e.run_id for e in exchanged])}: the position reads what the input does (to {100.0 * off:.2g} % of its span), as a reference in N would, and the reference "
            "goes with it at the scale of a position; the columns of position and reference are probably exchanged",
            "position_in_mm = { column = (that of tension_ref_n) }; tension_ref_n = { column = (that of position_in_mm) }",
        )  # fmt: skip
        log = [e for e in log if e not in exchanged]
    hit = [e for e in log if e.usable and "tension_in_n" in e.tensions and abs(math.log(_gain(e))) > math.log(APART)]
    if hit:
        g = _gain(hit[0])
        unit = force_unit(1.0 / g, 0.1)
        guess = f"the input is probably in {unit}, not N" if unit else "one of the two is probably in another unit"
        yield Remark(
            tuple(e.run_id for e in hit), RULE, "failure" if unit else "remark", g, "1",
            f"{names([e.run_id for e in hit])}: the input is {g:.3g} times the reference that it tracks; {guess}",
            stated(0, unit or "..."),
        )  # fmt: skip
    yield from _foreign([e for e in log if e.usable and math.isfinite(e.reference_left)])


def _exchanged(e: Evidence, reads: float) -> bool:
    """Whether the position reads what the input reads, within ``reads`` of its span, and the reference far from it."""
    position, reference = e.off
    return e.usable and "tension_in_n" in e.tensions and e.loaded and position < reads and reference > FURTHER * position


def _foreign(log: Sequence[Evidence]) -> Iterator[Remark]:
    """Yield the one run whose input does not go the way of its reference, as that of every other run does."""
    # of a gap that was filled, and of a sensor that shows nothing, the reference knows nothing
    hit = [e for e in log if e.reference_left > LEFT and not e.filled.length_s and not e.but_noise(0)]
    if len(hit) == 1 and len(log) > FEW:
        left = hit[0].reference_left
        yield Remark(
            (hit[0].run_id,), RULE, "remark", 100.0 * left, "%",
            f"{names([hit[0].run_id])}: the reference leaves {100 * left:.0f} % of the input's movement unexplained, at most "
            f"{100 * max(e.reference_left for e in log if e is not hit[0]):.0f} % in the other runs; it is probably the reference of another run",
            "tension_ref_n = { column = ..., file = (the file of this run) }",
        )  # fmt: skip


def _gain(e: Evidence) -> float:
    return e.reference_gain if e.reference_gain > 0.0 else 1.0
