"""Samples in reverse order: the hysteresis loop runs the wrong way, so that friction would give energy."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from sstl_cli.identification.gate.evidence import Evidence
from sstl_cli.identification.gate.remark import Remark, names

RULE, RANK = "reversed_time", 34
# residual of the reversed record over that of any other reading of it, and as a share of the output's span
BETTER, GOOD = 0.5, 0.08


def look(log: Sequence[Evidence]) -> Iterator[Remark]:
    """Yield runs that friction explains only from their last sample to the first."""
    hit = [e for e in log if e.tendon_like and e.play is not None and e.reversed_rms < GOOD and e.reversed_rms < BETTER * _otherwise(e)]
    if hit:
        share = 100.0 * max(e.reversed_rms / _otherwise(e) for e in hit)
        yield Remark(
            tuple(e.run_id for e in hit), RULE, "failure", share, "%",
            f"{names([e.run_id for e in hit])}: the hysteresis loop runs the wrong way, so that friction would give energy, and from "
            f"the last sample to the first it fits with {share:.0f} % of the error; the samples are probably in reverse order",
            "sort the rows of this file by their clock, the other way round",
        )  # fmt: skip


def _otherwise(e: Evidence) -> float:
    """Return what the best other reading leaves (share of the output's span): as recorded, moved in time, exchanged, flipped."""
    assert e.play is not None
    moved = e.play.delayed_rms_n / max(e.ranges[1].span, 1e-300)
    return min(v for v in (e.forward_rms, moved, e.swapped_rms, e.flipped_rms) if v == v)
