"""An output that does not follow its input: files or columns of different recordings put together."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from sstl_cli.identification.gate.evidence import Evidence
from sstl_cli.identification.gate.remark import Remark, names
from sstl_cli.identification.gate.rules.dead import MOST, lost_by

RULE, RANK = "unrelated", 48
# what the play operator leaves (share of the output's span), and how much the output must move (share of the input)
LEFT, MOVES = 0.08, 0.15
# what is left must be more than noise
NOISE = 3.0
# part of the run that an output may be late by if the delay explains it but half
FAR, CLEAR = 0.02, 0.9
# part of its way that an output must go against the input; of two movements of their own it is a half
AGAINST = 0.06
# what friction, alone and with any slip, must leave (share of the output's span)
NOTHING = 0.12
# part of what is left as recorded that another sign must leave for it to be the sign
SIGN = 0.6


def look(log: Sequence[Evidence]) -> Iterator[Remark]:
    """Yield runs whose output moves, but not as any friction would move it."""
    hit = [e for e in log if _unrelated(e)]
    if hit:
        number = min(explained_by(e) for e in hit)
        yield Remark(
            tuple(e.run_id for e in hit), RULE, "remark", 100.0 * max(number, 0.0), "%",
            f"{names([e.run_id for e in hit])}: friction, backlash and delay explain {100 * max(number, 0.0):.0f} % of the "
            "output; input and output probably come from different recordings",
            "[files] merge = \"channels\", key = (the named group that tells which files belong together)",
        )  # fmt: skip


def explained_by(e: Evidence) -> float:
    """Return the share of the output's variance that is explained; of other movements a long delay always explains some."""
    p = e.play
    if p is None or p.explained > CLEAR or abs(p.delay_s) < FAR * e.duration_s:
        return p.explained if p is not None else 1.0
    return 1.0 - (1.0 - p.explained) * (p.rms_n / max(min(p.rms_n, p.delayed_rms_n), 1e-300)) ** 2


def _unrelated(e: Evidence) -> bool:
    p = e.play
    if max(lost_by(e, 0), lost_by(e, 1)) > MOST:
        # a sensor that was lost midway follows nothing from there on
        return False
    flipped = e.correlation < -0.4 and not e.flipped_rms > SIGN * e.forward_rms
    if not e.tendon_like or not e.wide or p is None or flipped:
        return False
    moves = e.ranges[1].span > MOVES * e.ranges[0].span
    # slopes that no friction has may still follow an output
    explained = explained_by(e)
    odd = explained < 0.5 or (explained < 0.9 and min(p.gamma_p, p.gamma_r) < 0.0)
    # whatever the friction, an output does not fall as the input rises, nor rise as it falls
    # and no slip explains it
    left = min((c.rms_n for c in (*e.causes.slips, e.causes.reversed) if math.isfinite(c.rms_n)), default=math.inf)
    if left < NOTHING * e.ranges[1].span:
        return False
    return moves and odd and e.shapes.against > AGAINST and p.typical_n > max(LEFT * e.ranges[1].span, NOISE * e.sensors[1].noise_n)
