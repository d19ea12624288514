"""A channel that was scaled to its own extremes: its smallest value is exactly 0 and its largest exactly 1 (or 100)."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from sstl_cli.identification.gate.evidence import Evidence
from sstl_cli.identification.gate.remark import Remark, names
from sstl_cli.identification.gate.units import WORDS, column_line

RULE, RANK = "normalised", 11


def look(log: Sequence[Evidence]) -> Iterator[Remark]:
    """Yield runs one of whose channels holds shares of its own range."""
    for i in (0, 1):
        hit = [e for e in log if e.usable and e.both_tensions and e.own_range[i] > 0.0 and not e.two_values[i]]
        if hit:
            yield Remark(
                tuple(e.run_id for e in hit), RULE, "failure", hit[0].own_range[i], "N",
                f"{names([e.run_id for e in hit])}: the {WORDS[i]} goes from exactly 0 to exactly {hit[0].own_range[i]:.0f}, which no sensor does; it was probably "
                "normalised to its own range, and its tension is lost",
                column_line(i),
            )  # fmt: skip
