"""Configurations whose friction contradicts the lead screw: more lead, more bend, more wrap, to one side or to both."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from sstl_cli.identification.gate.evidence import Evidence
from sstl_cli.identification.gate.remark import Remark, names
from sstl_cli.identification.gate.rules.lead_mm import contradicting
from sstl_cli.identification.gate.scatter import friction_errors

Array = NDArray[np.float64]
RULE, RANK = "lead_order", 57
# settings that can be out of order, and those from which on reverse order, or disorder as a share of all variation, is no chance
FEW, MANY = 4, 5
# rank correlation of a list in reverse, and scatter about the best curve as a share of all variation
REVERSED, UNORDERED = 0.75, 0.4
# errors of friction by which one setting lies off the best curve, and the part of friction that bends of one lead may differ by
BEYOND, OFF = 6.0, 0.1
# and what is left of the variation where one wrong lead is left out
ORDERED = 0.15
# variation of n theta that counts
VARIES = 0.04


def look(log: Sequence[Evidence]) -> Iterator[Remark]:
    """Yield configurations out of the order of their lead."""
    groups: dict[object, list[Evidence]] = {}
    doubtful = contradicting(log)
    for e in log:
        if e.slopes.known and e.lead_mm is not None and e.run_id not in doubtful:
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
    error = _error(group, runs, f)
    spread = float(np.std(f))
    if spread < max(VARIES * float(np.mean(f)), 4.0 * error):
        return
    # a third of the start-up of a command, for a rule that few logs come to
    from scipy.stats import kendalltau

    tau = float(kendalltau(x, f).statistic)
    where = f"{group[0].location or 'all'}, {group[0].system}"
    away = _away(f, range(len(f) + 1))
    left = float(np.sqrt(np.mean(away**2))) / spread
    why = "a lead is probably wrong, or files or lead labels are shuffled"
    off = float(np.max(away)) > max(BEYOND * error, OFF * float(np.mean(f)))
    if off or (len(leads) >= MANY and left > UNORDERED):
        rests = [np.delete(f, k) for k in range(len(f))]
        # a curve that turns goes through nearly any few points
        turn = (0,) if tau >= 0.0 else (len(f) - 1,)
        alone = [k for k, rest in enumerate(rests) if float(np.sqrt(np.mean(_away(rest, turn) ** 2))) < ORDERED * float(np.std(rest))]
        out = np.flatnonzero(away > 0.5 * float(away.max()))
        if len(alone) == 1:
            out, why = np.array(alone), f"without {leads[alone[0]]:.4g} mm all others do, so that this lead (or its file) is probably wrong"
        how = (
            f"does not follow the lead screw (it varies by {100 * spread / float(np.mean(f)):.0f} %, {100 * left:.0f} % of it out of order)"
        )
        number, unit = 100.0 * left, "%"
    elif tau < -REVERSED and len(leads) >= MANY and leads[-1] > 0.0:
        out = np.arange(len(leads))
        how, number, unit = f"falls as the lead grows (rank correlation {tau:.2f})", tau, "1"
    else:
        return
    ids = tuple(e.run_id for i in out for e in runs[i])
    yield Remark(
        ids, RULE, "remark", number, unit,
        f"{names(ids)}: friction of {len(leads)} configurations ({where}) {how}; {why}",
        "lead_mm from file_name = '(pattern)', or a manifest with the right lead_mm",
    )  # fmt: skip


def _error(group: list[Evidence], runs: list[list[Evidence]], f: Array) -> float:
    """Return the error of friction at one lead: that of the slopes, or what the runs of one lead differ by, if that is more."""
    own = float(np.median(list(friction_errors(group).values())))
    apart = [e.slopes.friction - at for r, at in zip(runs, f, strict=True) if len(r) > 1 for e in r]
    return max(own, float(np.sqrt(np.mean(np.square(apart))))) if apart else own


def _away(f: Array, turns: Sequence[int]) -> Array:
    """Return how far friction in the order of its leads is from the nearest curve that falls up to one of these leads and rises from there on.

    A screw that bends the sheath to both sides goes through the straight sheath, where friction is lowest.
    """
    from scipy.optimize import isotonic_regression

    def curve(turn: int) -> Array:
        sides = ((f[:turn], False), (f[turn:], True))
        return np.concatenate([isotonic_regression(side, increasing=rising).x for side, rising in sides if len(side)])

    return min((np.abs(f - curve(turn)) for turn in turns), key=lambda a: float(np.mean(a**2)))
