"""The columns of the position and of a tension exchanged: friction explains the position as that tension, and not the tension as it stands."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from sstl_cli.identification.gate.evidence import Evidence
from sstl_cli.identification.gate.remark import Remark, names
from sstl_cli.identification.gate.units import CHANNELS, WORDS

RULE, RANK = "columns", 13
POSITION = "position_in_mm"
# what friction without any gain may leave of the output's span with the columns exchanged, and of what it leaves as recorded
LITTLE, TAKES = 0.07, 0.3
# by how much n theta of the bends must differ in the column of the position, and how many times as much as in that of the output
APART, TIMES = 0.2, 2.0


def look(log: Sequence[Evidence]) -> Iterator[Remark]:
    """Yield runs whose position is the tension and whose tension is the position."""
    # a tension that is the position again (see same_channel) is explained by it without friction
    known = [
        e for e in log if e.usable and math.isfinite(max(v.rms_n for v in e.instead)) and not any(POSITION in pair for pair in e.copies)
    ]
    for i in (0, 1):
        # one table has one order of columns
        if any(e.causes.enough and not e.one_way for e in log if e.usable):
            continue
        hit = [e for e in known if _goes_back(e, i) and _exchanged(e, i)]
        if 2 * len(hit) <= len(known):
            continue
        # a unit explains a tension of another scale as well, unless the bends rub in the one column alone
        if not (all(_scaled_n(e) > e.instead[i].rms_n * e.ranges[1].span for e in hit) or (i == 1 and _rubs(hit))):
            continue
        ids = tuple(e.run_id for e in known)
        left = float(np.median([e.instead[i].rms_n for e in hit]))
        yield Remark(
            ids, RULE, "failure", 100.0 * left, "%",
            f"{names(ids)}: with the columns of {WORDS[i]} and position exchanged friction explains the output to {100.0 * left:.2g} % of its span, and as they stand "
            f"it does not; the position is probably in the column of the {WORDS[i]}, and the {WORDS[i]} in that of the position",
            f"{CHANNELS[i]} = {{ column = (that of {POSITION}) }}; {POSITION} = {{ column = (that of {CHANNELS[i]}) }}",
        )  # fmt: skip


def _goes_back(e: Evidence, i: int) -> bool:
    """Whether what would be input and output then go both ways: anything that rises with an input that is only pulled does so along one line of friction."""
    # the column of the output holds the position where that of the position holds the output
    return e.comes_back and (i == 0 or e.propagates_back)


def _exchanged(e: Evidence, i: int) -> bool:
    """Whether friction alone explains a run with a tension (0 input, 1 output) and the position exchanged, and not as it stands: neither has another scale then."""
    there, other = e.instead[i].rms_n, e.instead[1 - i].rms_n
    return there < min(LITTLE, other, TAKES * e.causes.friction.rms_n / max(e.ranges[1].span, 1e-300))


def _scaled_n(e: Evidence) -> float:
    """Return what friction with another scale of a tension leaves (N RMS)."""
    c = e.causes
    return min((v.rms_n for v in (c.gain, c.scale, c.scale_in) if math.isfinite(v.rms_n)), default=math.inf)


def _rubs(hit: Sequence[Evidence]) -> bool:
    """Whether n theta differs from run to run in the column of the position, and not in that of the output, which follows its input at one scale and curve."""
    there, here = (
        [v for v in sizes if math.isfinite(v)] for sizes in ([e.instead[1].wrap for e in hit], [e.causes.gain.wrap for e in hit])
    )
    return len(there) > 1 and len(here) > 1 and max(there) - min(there) > max(APART, TIMES * (max(here) - min(here)))
