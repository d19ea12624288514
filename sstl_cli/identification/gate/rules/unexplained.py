"""One run that friction leaves unexplained, beside others of the same log that it explains: whatever went wrong, it went wrong there."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from sstl_cli.identification.gate.evidence import Evidence
from sstl_cli.identification.gate.remark import UNNAMED, Remark, names
from sstl_cli.identification.gate.rules.unrelated import follows, unexplained

RULE, RANK = "unexplained", UNNAMED
# share of the output's span left, how many times as much as in any other run, and runs that must be compared: a movement may show
# stick-slip, creep or slack that the others do not, which leaves up to half of this
LEAVES, TIMES, FEW = 0.05, 6.0, 4


def look(log: Sequence[Evidence]) -> Iterator[Remark]:
    """Yield the run that is unlike all others in what friction leaves of it."""
    known = [(unexplained(e), e) for e in log if e.tendon_like and e.loaded and follows(e) and not e.but_noise(1)]
    left = sorted(((share, e) for share, e in known if math.isfinite(share)), key=lambda v: -v[0])
    if len(left) < FEW:
        return
    (most, e), (other, _) = left[:2]
    if most > max(LEAVES, TIMES * other):
        yield Remark(
            (e.run_id,), RULE, "remark", 100.0 * most, "%",
            f"{names([e.run_id])}: this run is unlike all others: {100.0 * most:.2g} % of its output's span is explained by no friction, with any slip, and at "
            f"most {100.0 * other:.2g} % in the others; in a part of it rows of one channel were probably lost, or exchanged with those of the other one, "
            "or its sensor lost contact",
            "leave this file out, or export it anew",
        )  # fmt: skip
