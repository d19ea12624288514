"""Samples in reverse order: the hysteresis loop runs the wrong way, so that friction would give energy."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from sstl_cli.identification.gate.evidence import Evidence
from sstl_cli.identification.gate.remark import Remark, names

RULE, RANK = "reversed_time", 34
# what the reversed record may leave of what friction, any other slip, or free lines with a delay leave, and of the output's span
LESS, LITTLE = 0.5, 0.08


def look(log: Sequence[Evidence]) -> Iterator[Remark]:
    """Yield runs that friction explains only from their last sample to the first."""
    hit = [e for e in log if _reversed(e)]
    if hit:
        share = max(e.causes.left(e.causes.reversed.rms_n) / e.causes.left(e.causes.friction.rms_n) for e in hit)
        yield Remark(
            tuple(e.run_id for e in hit), RULE, "failure", 100.0 * share, "%",
            f"{names([e.run_id for e in hit])}: the hysteresis loop runs the wrong way, so that friction would give energy, and read "
            f"from the last sample to the first it fits with {100 * share:.0f} % of the error; the samples are probably in reverse order",
            "sort the rows of this file by their clock, the other way round",
        )  # fmt: skip


def _reversed(e: Evidence) -> bool:
    c, p = e.causes, e.play
    # what moves one way alone has no loop that could run the wrong way
    if e.loops == 0 or not e.tendon_like or p is None or not c.holds(c.reversed.rms_n, LESS):
        return False
    rest = min(c.left(v) for v in (p.rms_n, p.delayed_rms_n, *(s.rms_n for s in c.slips)))
    return c.left(c.reversed.rms_n) < LESS * rest and c.reversed.rms_n < LITTLE * e.ranges[1].span
