"""A gain that changes within a run: two parts follow friction, each with a gain of its own."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from sstl_cli.identification.gate.evidence import Evidence
from sstl_cli.identification.gate.remark import Remark, names
from sstl_cli.identification.gate.units import CHANNELS

RULE, RANK = "gain_change", 32


def look(log: Sequence[Evidence]) -> Iterator[Remark]:
    """Yield runs whose output is amplified otherwise from one moment on."""
    hit = [e for e in log if e.tendon_like and math.isfinite(e.shapes.gain)]
    if hit:
        e = hit[0]
        yield Remark(
            tuple(h.run_id for h in hit), RULE, "failure", e.shapes.gain, "1",
            f"{names([h.run_id for h in hit])}: from {e.shapes.gain_at_s:.4g} s on the output is {e.shapes.gain:.3g} times what friction makes "
            "of it before; its gain was probably changed during the run",
            f"split the run there, and {CHANNELS[1]} = {{ column = ..., scale = {1.0 / e.shapes.gain:.4g} }} for one part",
        )  # fmt: skip
