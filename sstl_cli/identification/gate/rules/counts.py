"""Readings of a converter taken for newtons: whole numbers, hundreds of them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from sstl_cli.identification.gate.evidence import Evidence
from sstl_cli.identification.gate.remark import Remark, names
from sstl_cli.identification.gate.units import WORDS, stated

RULE, RANK = "counts", 10
WHOLE = 0.999
# a load cell of 1 N resolution exists, one that also reads beyond a tendon's strength does not
FEW_N, MANY_N = 100.0, 500.0


def look(log: Sequence[Evidence]) -> Iterator[Remark]:
    """Yield runs whose tensions are whole numbers beyond what a tendon bears, or lack a digit here and there."""
    lost = [e for e in log if e.usable and max(e.digits_lost) > 0.0]
    if lost:
        share = max(max(e.digits_lost) for e in lost)
        short = [i for i in (0, 1) if any(e.digits_lost[i] > 0.0 for e in lost)]
        yield Remark(
            tuple(e.run_id for e in lost), RULE, "failure", 100.0 * share, "%",
            f"{names([e.run_id for e in lost])}: {' and '.join(WORDS[i] for i in short)} are whole numbers, of which {100 * share:.0f} % are a tenth "
            "or a hundredth of their neighbours and join them once multiplied; a decimal comma was probably lost, with the zeros behind it "
            "(12,34 read as 1234 and 12,3 as 123)",
            '[files] decimal = ","',
        )  # fmt: skip
        log = [e for e in log if e not in lost]
    for severity in ("failure", "remark"):
        for which in ((0, 1), (0,), (1,)):
            hit = [e for e in log if tuple(i for i in (0, 1) if _counts(e, i) == severity) == which]
            if not hit:
                continue
            largest = max(e.ranges[i].largest for e in hit for i in which)
            channel = " and ".join(WORDS[i] for i in which)
            yield Remark(
                tuple(e.run_id for e in hit), RULE, severity, largest, "N",
                f"{names([e.run_id for e in hit])}: {channel} {'hold' if len(which) > 1 else 'holds'} whole numbers up to {largest:.0f}, "
                "probably counts of the converter and not newtons",
                stated(which[0], "counts", ", gain = (newtons per count), offset = (counts at no load)"),
            )  # fmt: skip


def _counts(e: Evidence, i: int) -> str:
    if not e.usable or ("tension_in_n", "tension_out_n")[i] not in e.tensions:
        return ""
    r = e.ranges[i]
    if e.whole_share[i] < WHOLE or r.span < 50.0 or r.largest < FEW_N:
        return ""
    return "failure" if r.largest > MANY_N else "remark"
