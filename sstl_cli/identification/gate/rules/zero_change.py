"""A zero that jumps within a run: friction on both sides of one sample, with another zero behind it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from sstl_cli.identification.gate.evidence import Evidence
from sstl_cli.identification.gate.remark import Remark, names
from sstl_cli.identification.gate.units import CHANNELS, WORDS

RULE, RANK = "zero_change", 21


def look(log: Sequence[Evidence]) -> Iterator[Remark]:
    """Yield runs one of whose channels reads more or less by one tension from one moment on."""
    for i in (0, 1):
        hit = [
            (e, c) for e in log if e.usable and e.both_tensions and (c := e.shapes.change) is not None and not c.is_gain and c.channel == i
        ]
        if hit:
            c = hit[0][1]
            yield Remark(
                tuple(e.run_id for e, _ in hit), RULE, "failure", c.size, "N",
                f"{names([e.run_id for e, _ in hit])}: from {c.at_s:.4g} s on the {WORDS[i]} reads {c.size:+.3g} N beside what friction makes "
                "of it before; its zero was probably set anew (tared) during the run",
                f"split the run there, and {CHANNELS[i]} = {{ column = ..., offset = {c.size:.3g} }} for the second part",
            )  # fmt: skip
