"""An output behind a low-pass of its own: its loop grows wider with the rate of the input, which friction does not make."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from sstl_cli.identification.gate.evidence import Evidence
from sstl_cli.identification.gate.leading import BY_SPEED
from sstl_cli.identification.gate.remark import Remark, names
from sstl_cli.identification.gate.rules.lead import FILTER, HELD, LATE_S
from sstl_cli.identification.gate.rules.stuck import dead

RULE, RANK = "slow", 36
# what the low-pass may leave of what any other explanation leaves, and of the output's span
LESS, LITTLE = 0.5, 0.03


def look(log: Sequence[Evidence]) -> Iterator[Remark]:
    """Yield runs whose output friction explains only once it is smoothed."""
    hit = [e for e in log if _slow(e)]
    if hit:
        tau = sorted(e.causes.slow.size for e in hit)[len(hit) // 2]
        yield Remark(
            tuple(e.run_id for e in hit), RULE, "remark", tau, "s",
            f"{names([e.run_id for e in hit])}: the output lags behind what friction makes of the input, the more the faster the input goes, as "
            f"behind a low-pass of {1.0 / (2.0 * math.pi * tau):.2g} Hz (time constant {tau:.2g} s) that the input does not pass; the output "
            f"channel is probably {'summed up (integrated) over time' if tau > hit[0].duration_s else 'filtered or smoothed'}",
            "none: record again with the same filter on both channels, one well above the movement",
        )  # fmt: skip


def _slow(e: Evidence) -> bool:
    c, p = e.causes, e.play
    if not e.tendon_like or not e.wide or p is None or dead(e) or not c.holds(c.slow.rms_n, HELD):
        return False
    # drag along the tendon opens the loop with speed as well
    if not c.speed.rms_n > BY_SPEED * max(c.slow.rms_n, c.noise_n) or not c.slow.rms_n < LITTLE * e.ranges[1].span:
        return False
    others = (c.gain, c.zero_in, c.zero_out, c.moved, c.speed, c.reversed)
    rest = min(c.left(v) for v in (p.rms_n, p.delayed_rms_n, *(o.rms_n for o in others)))
    return c.left(c.slow.rms_n) < LESS * rest and c.slow.size > max(LATE_S, FILTER * e.dt_s)
