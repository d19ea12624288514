"""An output that holds its input: a mean, sum or difference of both channels in the place of the output."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from sstl_cli.identification.gate.causes import MOVED
from sstl_cli.identification.gate.evidence import Evidence
from sstl_cli.identification.gate.mixing import Mixed
from sstl_cli.identification.gate.remark import Remark, names
from sstl_cli.identification.gate.units import column_line

RULE, RANK = "mixed", 9
# what friction may leave of the output without its part of the input, of what friction, alone and with any slip, leaves of it as recorded, and where the noise
# of all runs tells the part
TAKES, AS_WELL = 0.5, 1.2
# by how much parts may differ from run to run: the noise of one run tells it to some percent
ALIKE, ERRORS = 0.1, 3.0
# and that of one sensor; runs that must show it, and by how much n theta of their bends must differ
ONE, FEW, APART = 0.04, 3, 0.2
# part of the runs whose noise tells that must be explained so for the others to be taken with them
MANY = 0.5


def look(log: Sequence[Evidence]) -> Iterator[Remark]:
    """Yield runs whose output is one only without a part of the input."""
    known = [(e, e.mixed) for e in log if e.mixed is not None and e.both_tensions]
    told = [(e, m) for e, m in known if _explains(e, m, TAKES)] or _alike(known, log)
    if not told:
        return
    share, gain = (float(np.median(v)) for v in ([m.share for _, m in told], [m.gain for _, m in told]))
    beside = [e for e, m in known if abs(m.share - share) < max(ALIKE, ERRORS * m.error)]
    # of a log that was mixed as a whole a run that stays within its backlash has but its noise to tell it
    hit = beside if len(told) > MANY * len(beside) else [e for e, _ in told]
    if 2 * len(hit) <= len(log):
        # of some runs among others ``crosstalk`` speaks
        return
    ids = tuple(e.run_id for e in hit)
    what = "the difference of both channels" if gain < 0.0 < share or share < 0.0 < gain else "the mean or the sum of both channels"
    yield Remark(
        ids, RULE, "failure", 100.0 * share, "%",
        f"{names(ids)}: the noise of the input is in the output ({share:.2f} of it), and without that part of the input friction explains the output, with it none "
        f"does; the column is probably {what}, and not the output, or a part of one channel is in the other one (amplifiers, cables)",
        column_line(1),
    )  # fmt: skip


def _explains(e: Evidence, m: Mixed, takes: float) -> bool:
    """Whether friction leaves of an output without a part of the input no more than that part of what it leaves with it, whatever slip is asked for."""
    c = e.causes
    slips = [v for v in (*c.slips, c.reversed, c.scale, c.scale_in) if v is not c.moved or abs(v.size) < MOVED * e.duration_s]
    return not c.enough and c.left(m.rms_n) < takes * min(c.left(v.rms_n) for v in slips)


def _alike(known: list[tuple[Evidence, Mixed]], log: Sequence[Evidence]) -> list[tuple[Evidence, Mixed]]:
    """Return the runs of a log all of which share one part of their noise, in bends that rub differently.

    What vibrates in the tendon itself passes on the less the more a bend rubs; what is added behind it is the same everywhere.
    """
    told = [(e, m) for e, m in known if _explains(e, m, AS_WELL)]
    if len(known) < max(FEW, len(log)) or len(told) < FEW:
        return []
    shares, wraps = [m.share for _, m in known], [m.wrap for _, m in told]
    one = all(abs(m.share - float(np.median(shares))) < max(ONE, ERRORS * m.error) for _, m in known)
    return told if one and max(wraps) - min(wraps) > APART else []
