"""Configurations whose friction contradicts the lead screw: more lead, more bend, more wrap."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from scipy.stats import kendalltau, theilslopes

from sstl_cli.identification.gate.evidence import Evidence
from sstl_cli.identification.gate.remark import Remark, names

RULE, RANK = "lead_order", 57
FEW = 5
ORDERED, DISORDERED = 0.75, 0.35
# variation of n theta that counts, and how far a configuration may lie from the trend
VARIES, OFF_TREND, SPREADS = 0.05, 0.3, 6.0


def look(log: Sequence[Evidence]) -> Iterator[Remark]:
    """Yield configurations out of the order of their lead."""
    groups: dict[object, list[Evidence]] = {}
    for e in log:
        if e.slopes.known and e.lead_mm is not None:
            groups.setdefault((e.location, e.system, e.tendon), []).append(e)
    for group in groups.values():
        yield from _ordered(group)


def _ordered(group: list[Evidence]) -> Iterator[Remark]:
    leads = sorted({float(e.lead_mm) for e in group if e.lead_mm is not None})
    if len(leads) < FEW:
        return
    runs = [[e for e in group if e.lead_mm == lead] for lead in leads]
    x = np.array(leads)
    f = np.array([float(np.median([e.slopes.friction for e in r])) for r in runs])
    error = float(np.median([e.slopes.friction_se for e in group]))
    spread = float(np.std(f))
    if spread < max(VARIES * float(np.mean(f)), 4.0 * error):
        return
    tau = float(kendalltau(x, f).statistic)
    where = f"{group[0].location or 'all'}, {group[0].system}"
    mend = "lead_mm from file_name = '(pattern)', or a manifest with the right lead_mm"
    ids = tuple(e.run_id for e in group)
    if abs(tau) < DISORDERED or tau < -ORDERED:
        how = "does not follow" if abs(tau) < DISORDERED else "falls with"
        yield Remark(
            ids, RULE, "remark", tau, "1",
            f"{names(ids)}: friction of {len(leads)} configurations ({where}) {how} the lead screw (rank correlation "
            f"{tau:.2f}) although it varies by {100 * spread / float(np.mean(f)):.0f} %; files or lead labels are probably shuffled",
            mend,
        )  # fmt: skip
        return
    slope, middle, _, _ = theilslopes(f, x)
    away = np.abs(f - middle - slope * x)
    usual = 1.4826 * float(np.median(away))
    limit = max(SPREADS * usual, OFF_TREND * float(np.ptp(f)), 4.0 * error)
    out = np.flatnonzero(away > limit)
    if 0 < len(out) <= len(leads) // 3 + 1:
        ids = tuple(e.run_id for i in out for e in runs[i])
        shown = ", ".join(f"{leads[i]:g}" for i in out[:4])
        yield Remark(
            ids, RULE, "remark", float(away[out].max()), "1",
            f"{names(ids)}: friction at lead {shown} mm ({where}) is {float(away[out].max()):.2f} off the trend of the others, "
            f"which scatter by {usual:.2f}; lead or configuration labels are probably exchanged",
            mend,
        )  # fmt: skip
