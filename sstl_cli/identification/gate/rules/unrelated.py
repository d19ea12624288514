"""An output that does not follow its input: files or columns of different recordings put together."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from sstl_cli.identification.gate.evidence import Evidence
from sstl_cli.identification.gate.remark import Remark, names

RULE, RANK = "unrelated", 48
# what the play operator leaves (share of the output's span), and how much the output must move (share of the input)
LEFT, MOVES = 0.08, 0.15
# what is left must be more than noise
NOISE = 3.0


def look(log: Sequence[Evidence]) -> Iterator[Remark]:
    """Yield runs whose output moves, but not as any friction would move it."""
    hit = [e for e in log if _unrelated(e)]
    if hit:
        number = min(e.play.explained for e in hit if e.play is not None)
        yield Remark(
            tuple(e.run_id for e in hit), RULE, "remark", 100.0 * max(number, 0.0), "%",
            f"{names([e.run_id for e in hit])}: friction, backlash and delay explain {100 * max(number, 0.0):.0f} % of the "
            "output; input and output probably come from different recordings",
            "[files] merge = \"channels\", key = (the named group that tells which files belong together)",
        )  # fmt: skip


def _unrelated(e: Evidence) -> bool:
    p = e.play
    if not e.tendon_like or not e.loaded or p is None or e.correlation < -0.4:
        return False
    moves = e.ranges[1].span > MOVES * e.ranges[0].span
    # slopes that no friction has may still follow an output
    odd = p.explained < 0.5 or (p.explained < 0.8 and min(p.gamma_p, p.gamma_r) < 0.0)
    return moves and odd and p.typical_n > max(LEFT * e.ranges[1].span, NOISE * e.sensors[1].noise_n)
