"""A tension that is a straight line in time: a clock or a sample index in the wrong column."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from sstl_cli.identification.gate.evidence import Evidence
from sstl_cli.identification.gate.remark import Remark, names
from sstl_cli.identification.gate.units import CHANNELS, WORDS

RULE, RANK = "clock_channel", 5
# no drive pulls as evenly as a clock counts
STRAIGHT = 1.0 - 1e-6


def look(log: Sequence[Evidence]) -> Iterator[Remark]:
    """Yield runs one of whose channels grows evenly from the first sample to the last."""
    for i in (0, 1):
        hit = [e for e in log if e.usable and CHANNELS[i] in e.tensions and e.line_share[i] > STRAIGHT and e.samples > 100]
        if hit:
            number = max(e.line_share[i] for e in hit)
            yield Remark(
                tuple(e.run_id for e in hit), RULE, "failure", 100.0 * number, "%",
                f"{names([e.run_id for e in hit])}: the {WORDS[i]} is a straight line in time ({100 * number:.4f} %), "
                "probably a clock or a sample index and not a tension",
                f"{CHANNELS[i]} = {{ column = (the column of the tension) }}",
            )  # fmt: skip
