"""A gain that changes within a run: friction on both sides of one sample, with another gain behind it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from sstl_cli.identification.gate.evidence import Evidence
from sstl_cli.identification.gate.remark import Remark, names
from sstl_cli.identification.gate.units import CHANNELS, WORDS

RULE, RANK = "gain_change", 21


def look(log: Sequence[Evidence]) -> Iterator[Remark]:
    """Yield runs one of whose channels is amplified otherwise from one moment on."""
    for i in (0, 1):
        hit = [(e, c) for e in log if e.tendon_like and (c := e.shapes.change) is not None and c.is_gain and c.channel == i]
        if hit:
            c = hit[0][1]
            yield Remark(
                tuple(e.run_id for e, _ in hit), RULE, "failure", c.size, "1",
                f"{names([e.run_id for e, _ in hit])}: from {c.at_s:.4g} s on the {WORDS[i]} is {c.size:.3g} times what friction makes "
                "of it before; its gain was probably changed during the run",
                f"split the run there, and {CHANNELS[i]} = {{ column = ..., scale = {1.0 / c.size:.4g} }} for one part",
            )  # fmt: skip
