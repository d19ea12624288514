"""An input that follows its reference at another scale: one of the two is in another unit."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from sstl_cli.identification.gate.evidence import Evidence
from sstl_cli.identification.gate.remark import Remark, names
from sstl_cli.identification.gate.units import force_unit, stated

RULE, RANK = "reference", 26
APART = 2.0


def look(log: Sequence[Evidence]) -> Iterator[Remark]:
    """Yield runs whose input is a multiple of the reference it tracks."""
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


def _gain(e: Evidence) -> float:
    return e.reference_gain if e.reference_gain > 0.0 else 1.0
