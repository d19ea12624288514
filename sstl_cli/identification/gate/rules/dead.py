"""A sensor that shows nothing but its own noise while the other one goes where no friction would let it rest."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from sstl_cli.identification.gate.evidence import Evidence
from sstl_cli.identification.gate.remark import Remark, Severity, names
from sstl_cli.identification.gate.rules.stuck import dead
from sstl_cli.identification.gate.units import CHANNELS, WORDS, column_line

RULE, RANK = "dead", 44
# spreads of the noise within which a channel that rests stays
NOISE = 7.0
# n theta that no bend has (a loop of two passes has 2 at the most), and the zero (share of the other's largest tension) a sensor may be off by
MOST, ZERO = 2.3, 0.05
# how much more than the friction that other runs show is beyond doubt
BEYOND = 1.7


def look(log: Sequence[Evidence]) -> Iterator[Remark]:
    """Yield runs one of whose channels is noise about a constant though the other pulls far beyond what friction holds."""
    known = [e.wrap / e.passes for e in log if e.slopes.known and e.wrap > 0.0]
    seen = max(known, default=math.inf)
    for i in (0, 1):
        resting = {e.run_id: needed(e, i) for e in log}
        for severity in ("failure", "remark"):
            hit = [e for e in log if resting[e.run_id] > MOST and _severity(e, resting[e.run_id], seen) == severity]
            if hit:
                far = max(e.ranges[1 - i].span for e in hit)
                yield Remark(
                    tuple(e.run_id for e in hit), RULE, severity, far, "N",
                    f"{names([e.run_id for e in hit])}: the {WORDS[i]} is noise about a constant "
                    f"({hit[0].ranges[i].middle:.3g} N) while the {WORDS[1 - i]} moves by {far:.3g} N, which no friction holds "
                    "back; the sensor is probably dead or not connected",
                    column_line(i),
                )  # fmt: skip


def needed(e: Evidence, i: int) -> float:
    """Return n theta that friction would need to keep a channel where it rests, 0 where it moves by more than its noise."""
    s, rest, moves = e.sensors[i], e.ranges[i], e.ranges[1 - i]
    if not e.usable or CHANNELS[i] not in e.tensions or not e.both_tensions or dead(e):
        return 0.0
    # between coarse levels a movement may hide
    if not (s.fine and s.noise_n > 0.0) or rest.span > NOISE * s.noise_n or moves.high <= 0.0:
        return 0.0
    if moves.low < -0.25 * moves.high or moves.span < 0.5 * moves.high:
        return 0.0
    return math.log(moves.high / (abs(rest.middle) + ZERO * moves.high))


def _severity(e: Evidence, wrap: float, seen: float) -> Severity:
    """A failure where the other runs show that friction is by far smaller."""
    return "failure" if wrap > BEYOND * seen * e.passes else "remark"
