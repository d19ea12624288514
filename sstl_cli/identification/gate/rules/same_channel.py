"""Input and output from one sensor: the output is a straight line of the input, noise and all."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from sstl_cli.identification.gate.evidence import Evidence
from sstl_cli.identification.gate.remark import Remark, names
from sstl_cli.identification.gate.units import column_line

RULE, RANK = "same_channel", 15
EXACT = 1e-6


def look(log: Sequence[Evidence]) -> Iterator[Remark]:
    """Yield runs whose channels share even their noise."""
    hit = [e for e in log if e.usable and _copy(e)]
    if hit:
        share = max(e.copy_rms for e in hit)
        yield Remark(
            tuple(e.run_id for e in hit), RULE, "failure", 100.0 * share, "%",
            f"{names([e.run_id for e in hit])}: the output is the input on a straight line to {100 * share:.2g} % of its "
            "span, noise included; one column was probably taken twice",
            column_line(1),
        )  # fmt: skip


def _copy(e: Evidence) -> bool:
    if e.copy_rms < EXACT:
        return True
    # two sensors on a straight tube agree to their noise, but not in it
    noise = e.sensors[1].noise_n
    return e.noise_correlation > 0.8 and noise > 0.0 and e.copy_rms * e.ranges[1].span < 0.7 * noise
