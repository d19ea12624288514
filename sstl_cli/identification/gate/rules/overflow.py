"""A converter that overflows: a channel jumps from one end of its range to the other and back, and the other channel does not."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from sstl_cli.identification.gate.evidence import Evidence
from sstl_cli.identification.gate.remark import Remark, names
from sstl_cli.identification.gate.units import CHANNELS, WORDS

RULE, RANK = "overflow", 24


def look(log: Sequence[Evidence]) -> Iterator[Remark]:
    """Yield runs one of whose channels wraps around."""
    for i in (0, 1):
        hit = [e for e in log if e.usable and CHANNELS[i] in e.tensions and math.isfinite(e.shapes.wrap_n[i])]
        if hit:
            size = max(e.shapes.wrap_n[i] for e in hit)
            yield Remark(
                tuple(e.run_id for e in hit), RULE, "failure", size, "N",
                f"{names([e.run_id for e in hit])}: the {WORDS[i]} jumps by {size:.4g} N from one end of its range to the other and back while "
                f"the {WORDS[1 - i]} goes on; its converter or number format probably overflows and wraps around",
                f"{CHANNELS[i]} = {{ column = (exported anew in a wider number format) }}",
            )  # fmt: skip
