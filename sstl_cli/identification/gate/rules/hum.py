"""Hum: a channel holds a sinusoid of one frequency that the other channel does not."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from sstl_cli.identification.gate.evidence import Evidence
from sstl_cli.identification.gate.remark import Remark, names
from sstl_cli.identification.gate.units import WORDS

RULE, RANK = "hum", 19


def look(log: Sequence[Evidence]) -> Iterator[Remark]:
    """Yield runs one of whose channels hums."""
    for i in (0, 1):
        hit = [(e, h) for e in log if e.tendon_like and (h := e.hums[i]) is not None]
        if hit:
            h = max((h for _, h in hit), key=lambda v: v.amplitude_n)
            yield Remark(
                tuple(e.run_id for e, _ in hit), RULE, "remark", h.amplitude_n, "N",
                f"{names([e.run_id for e, _ in hit])}: the {WORDS[i]} holds a sinusoid of {h.amplitude_n:.3g} N at {h.frequency_hz:.4g} Hz "
                f"(or an alias of it) that the {WORDS[1 - i]} does not; probably hum of the mains, or other interference, on its cable",
                "none: record again with shielded and grounded cables, or filter this frequency before the import",
            )  # fmt: skip
