"""An input that follows its reference at another scale, one of the two being in another unit, or not at all in one run of many."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from sstl_cli.identification.gate.beside import FOLLOWED
from sstl_cli.identification.gate.evidence import Evidence
from sstl_cli.identification.gate.movement import unlike
from sstl_cli.identification.gate.remark import Remark, names
from sstl_cli.identification.gate.units import force_unit, stated

RULE, RANK = "reference", 26
APART = 2.0
# what a reference leaves of an input from which on it is not followed, and other runs that must show that it is
LEFT, FEW = math.sqrt(1.0 - FOLLOWED**2), 3
# part of the input's span by which readings in its own unit are off it where it is driven along them, and how much further another quantity is
READS, FURTHER = 0.12, 2.0
# how many times more of a reference must be left by its own input than by those of all other runs, and by the one that follows it
ANOTHERS = 2.0


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
    tracked = [e for e in log if not e.filled.length_s and not e.but_noise(0)]
    hit = [e for e in tracked if e.reference_left > LEFT]
    if not hit and len(log) > FEW:
        yield from _anothers(tracked)
    if len(hit) == 1 and len(log) > FEW:
        left = hit[0].reference_left
        yield Remark(
            (hit[0].run_id,), RULE, "remark", 100.0 * left, "%",
            f"{names([hit[0].run_id])}: the reference leaves {100 * left:.0f} % of the input's movement unexplained, at most "
            f"{100 * max(e.reference_left for e in log if e is not hit[0]):.0f} % in the other runs; it is probably the reference of another run",
            "tension_ref_n = { column = ..., file = (the file of this run) }",
        )  # fmt: skip


def _anothers(log: Sequence[Evidence]) -> Iterator[Remark]:
    """Yield the run whose reference the input of another run follows as every other one follows its own, where its own input goes another way of the same period."""
    worst = max(log, key=lambda e: e.reference_left, default=None)
    if worst is None or len(log) <= FEW:
        return
    rest = [e for e in log if e is not worst]
    own, most = worst.reference_left, max(e.reference_left for e in rest)
    # a reference that others of this name have as well is the right one, and the input is off
    called = [o for o in rest if (o.trajectory or o.config_id) == (worst.trajectory or worst.config_id)]
    if own < ANOTHERS * most or any(unlike(worst.reference_movement, o.reference_movement) < most for o in called):
        return
    left, other = min(((unlike(worst.reference_movement, o.movement), o) for o in rest), key=lambda pair: pair[0])
    if ANOTHERS * left < own and left < ANOTHERS * most and ANOTHERS * left < unlike(worst.movement, other.movement):
        yield Remark(
            (worst.run_id,), RULE, "remark", 100.0 * own, "%",
            f"{names([worst.run_id])}: the reference leaves {100 * own:.0f} % of the input's movement unexplained, at most {100 * most:.0f} % in the other runs, and {100 * left:.0f} % of that of "
            f"run {other.run_id}; it is probably the reference of another run",
            "tension_ref_n = { column = ..., file = (the file of this run) }",
        )  # fmt: skip


def _gain(e: Evidence) -> float:
    return e.reference_gain if e.reference_gain > 0.0 else 1.0
