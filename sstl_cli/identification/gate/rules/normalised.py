"""A channel that was scaled to its own extremes: its largest value is exactly 1 (or 100), and its smallest exactly 0 or that of every run the same."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from sstl_cli.identification.gate.evidence import Evidence
from sstl_cli.identification.gate.remark import Remark, names
from sstl_cli.identification.gate.units import WORDS, column_line

RULE, RANK = "normalised", 11
# largest values of what was normalised, and runs that share one if it is divided by its largest value alone
LARGEST, FEWEST = (1.0, 100.0), 3


def look(log: Sequence[Evidence]) -> Iterator[Remark]:
    """Yield runs one of whose channels holds shares of its own range."""
    runs = [e for e in log if e.usable and e.both_tensions]
    for i in (0, 1):
        largest = [e for e in runs if e.extremes[i][1] in LARGEST and not e.two_values[i]]
        every = len(largest) == len(runs) >= FEWEST and len({e.extremes[i][1] for e in largest}) == 1
        hit = largest if every else [e for e in largest if e.extremes[i][0] == 0.0]
        if hit:
            most = hit[0].extremes[i][1]
            goes = f"goes from exactly 0 to exactly {most:.0f}" if hit[0].extremes[i][0] == 0.0 else f"goes up to exactly {most:.0f}"
            yield Remark(
                tuple(e.run_id for e in hit), RULE, "failure", most, "N",
                f"{names([e.run_id for e in hit])}: the {WORDS[i]} {goes}, which no sensor does; it was probably "
                "normalised to its own range, and its tension is lost",
                column_line(i),
            )  # fmt: skip
