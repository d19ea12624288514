"""A converter that overflows: a channel jumps from one end of its range to the other and back, and the other channel does not."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from sstl_cli.identification.gate.evidence import Evidence
from sstl_cli.identification.gate.remark import Remark, names
from sstl_cli.identification.gate.rules.unrelated import NOTHING, unexplained
from sstl_cli.identification.gate.units import CHANNELS, WORDS

RULE, RANK = "overflow", 24
# part of the range of a converter by which a run may miss its ends and still read from one to the other
ENDS = 0.05


def look(log: Sequence[Evidence]) -> Iterator[Remark]:
    """Yield runs one of whose channels wraps around."""
    for i in (0, 1):
        known = [e for e in log if e.usable and CHANNELS[i] in e.tensions]
        hit = [e for e in known if math.isfinite(e.shapes.wrap_n[i])]
        if hit:
            size = max(e.shapes.wrap_n[i] for e in hit)
            ids = tuple(e.run_id for e in known if e in hit or _wraps_too(e, hit, i))
            yield Remark(
                ids, RULE, "failure", size, "N",
                f"{names(ids)}: the {WORDS[i]} jumps by {size:.4g} N from one end of its range to the other and back while "
                f"the {WORDS[1 - i]} goes on; its converter or number format probably overflows and wraps around",
                f"{CHANNELS[i]} = {{ column = (exported anew in a wider number format) }}",
            )  # fmt: skip


def _wraps_too(e: Evidence, hit: Sequence[Evidence], i: int) -> bool:
    """Whether a run reads from one end to the other of the range over which the same sensor wraps in another run, and no friction explains it.

    Jumps that are lost between samples, or come while the other channel moves, do not tell themselves.
    """
    for o in hit:
        (low, high), miss = o.extremes[i], ENDS * o.shapes.wrap_n[i]
        if o.system == e.system and abs(e.extremes[i][0] - low) < miss and abs(e.extremes[i][1] - high) < miss:
            return unexplained(e) > NOTHING
    return False
