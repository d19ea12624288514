"""An output without its sign: below a zero that is off it rises again."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from sstl_cli.identification.gate.evidence import Evidence
from sstl_cli.identification.gate.remark import Remark, names
from sstl_cli.identification.gate.units import CHANNELS

RULE, RANK = "folded", 33


def look(log: Sequence[Evidence]) -> Iterator[Remark]:
    """Yield runs whose output friction explains once its sign is put back."""
    # a connector that lets go turns the output at zero as well
    hit = [e for e in log if e.tendon_like and math.isfinite(e.shapes.fold_n) and e.dropouts[1] is None]
    if hit:
        size = hit[0].shapes.fold_n
        yield Remark(
            tuple(e.run_id for e in hit), RULE, "failure", size, "N",
            f"{names([e.run_id for e in hit])}: the output turns back at zero against its input, which no friction does, and goes with it once "
            f"its sign is changed beyond, with {size:.3g} N at no tension; it was probably rectified after its zero was taken under load",
            f"{CHANNELS[1]} = {{ column = (the reading with its sign), offset = (reading at no load, about {size:.3g}) }}",
        )  # fmt: skip
