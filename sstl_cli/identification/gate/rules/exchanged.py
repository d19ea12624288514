"""Configuration labels exchanged within one system: then act and sstl agree in every bend, and labels of systems stay as they are."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from sstl_cli.identification.gate.evidence import Evidence
from sstl_cli.identification.gate.remark import Remark, names
from sstl_cli.identification.gate.rules.two_rigs import second_rig

RULE, RANK = "exchanged", 49
# of the logarithm: how far two passes may be from twice one pass, and from where on a bend does not fit its labels
FITS, ODD = 0.25, 0.45


def look(log: Sequence[Evidence]) -> Iterator[Remark]:
    """Yield runs whose configurations must be exchanged for every bend to make sense."""
    places: dict[object, dict[str, dict[str, list[Evidence]]]] = {}
    for e in log:
        if e.config_id is not None and e.wrap > 0.0:
            places.setdefault((e.location, e.tendon), {}).setdefault(str(e.config_id), {}).setdefault(e.system, []).append(e)
    if second_rig(log)[0]:
        return
    for bends in places.values():
        yield from _place({k: b for k, b in bends.items() if len(b) == 2})


def _place(bends: dict[str, dict[str, list[Evidence]]]) -> Iterator[Remark]:
    """Compare the labels of one place: what remains once the loops are put in the order of actuation."""
    wraps = {k: tuple(_middle(b[s]) for s in ("act", "sstl")) for k, b in bends.items()}
    # one pass and two rub most in the same bend, whatever the law: sorted alike they fit, or no exchange explains them
    sorts = [sorted(wraps, key=lambda k: wraps[k][i]) for i in (0, 1)]
    moved = [(k, o) for k, o in zip(*sorts, strict=True) if k != o]
    odd = [k for k, _ in moved]
    # of labels that went round in a circle one may be far off and all others near
    if not any(abs(_apart(*wraps[k])) > ODD for k in odd):
        return
    left = [abs(_apart(wraps[k][0], wraps[o][1])) for k, o in moved]
    # where exchanged systems explain the bends as well there is nothing to choose: fewer labels are wrong then
    flipped = [abs(_apart(wraps[k][1], wraps[k][0])) for k in odd]
    if max(left) > FITS or max(flipped) < ODD:
        return
    worst = max(abs(_apart(*wraps[k])) for k in odd)
    systems = _out_of_order(bends)
    hit = [e for k in odd for s in systems for e in bends[k][s]]
    which = f"the {systems[0]} runs" if len(systems) == 1 else "the act runs or of the sstl runs"
    yield Remark(
        tuple(e.run_id for e in hit), RULE, "failure", 100.0 * math.expm1(worst), "%",
        f"{names([e.run_id for e in hit])}: friction of the loop is off from twice that of actuation by a factor of {math.exp(worst):.3g} in "
        f"configurations {', '.join(odd)}, and fits in all of them once the configurations of {which} are exchanged; these labels are "
        "probably shuffled, those of the systems are right",
        "file_name = '(pattern that reads config_id from the name)', or a manifest with the right config_id",
    )  # fmt: skip


def _out_of_order(bends: dict[str, dict[str, list[Evidence]]]) -> list[str]:
    """Return the system whose friction leaves the order of the bends (by lead, or by name) that the other one keeps; both where none tells."""
    leads = {k: next((e.lead_mm for s in b.values() for e in s if e.lead_mm is not None), None) for k, b in bends.items()}
    known = [v for v in leads.values() if v is not None]
    order = sorted(bends, key=lambda k: leads[k] or 0.0) if len(known) == len(bends) else sorted(bends)
    broken = {s: int(np.sum(np.diff([_middle(bends[k][s]) for k in order]) < 0.0)) for s in ("act", "sstl")}
    away = {s: min(n, len(order) - 1 - n) for s, n in broken.items()}
    if len(order) > 2 and 0 in away.values() and away["act"] != away["sstl"]:
        return ["act"] if away["sstl"] == 0 else ["sstl"]
    return ["act", "sstl"]


def _middle(runs: list[Evidence]) -> float:
    return float(np.median([e.wrap for e in runs]))


def _apart(single: float, double: float) -> float:
    return math.log(double / (2.0 * single))
