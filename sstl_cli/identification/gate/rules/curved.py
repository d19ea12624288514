"""An output that is no multiple of tension: its root, its logarithm, or behind an amplifier that gives way."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from sstl_cli.identification.gate.curves import Curve
from sstl_cli.identification.gate.evidence import Evidence
from sstl_cli.identification.gate.remark import Remark, names
from sstl_cli.identification.gate.rules.limit import limited
from sstl_cli.identification.gate.units import CHANNELS

RULE, RANK = "curved", 37
# what the curve may leave of what any slip leaves (nine tenths at the least in sound runs) and of the output's span, and by how much its slope must change
TAKES, LITTLE, BENDS = 0.5, 0.03, 1.3


def look(log: Sequence[Evidence]) -> Iterator[Remark]:
    """Yield runs that friction explains behind a curve of the output, and nothing else does."""
    cut = {e.run_id for e in limited(log, 1)}
    hit = [(e, c) for e in log if e.run_id not in cut and (c := _curve(e)) is not None]
    if hit:
        ratio = sorted(c.ratio for _, c in hit)[len(hit) // 2]
        less = "less and less" if ratio < 1.0 else "more and more"
        yield Remark(
            tuple(e.run_id for e, _ in hit), RULE, "remark", ratio, "1",
            f"{names([e.run_id for e, _ in hit])}: friction explains the output only if it grows {less} with tension (by {ratio:.2g} times as much at high as at "
            "low tension); it is probably no tension but its root, logarithm or square, or the amplifier is at its limit",
            f"{CHANNELS[1]} = {{ column = (the linear reading, before it was transformed) }}",
        )  # fmt: skip


def _curve(e: Evidence) -> Curve | None:
    """Return the curve that a run holds: one way alone, friction that sets in along a path is a curve by itself."""
    c = e.curve
    if (
        c is None
        or not (e.tendon_like and e.propagates_back)
        or e.shapes.parted is not None
        or not (c.share < TAKES and c.rms_n < LITTLE * e.ranges[1].span)
    ):
        return None
    return c if 0.0 < c.ratio < 1.0 / BENDS or c.ratio > BENDS else None
