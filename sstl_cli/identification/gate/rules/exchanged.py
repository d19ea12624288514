"""Configuration labels exchanged within one system: then act and sstl agree in every bend, and labels of systems stay as they are."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Sequence

import numpy as np

from sstl_cli.identification.gate.evidence import Evidence
from sstl_cli.identification.gate.remark import Remark, names
from sstl_cli.identification.gate.rules.two_rigs import recorders_differ, second_rig

RULE, RANK = "exchanged", 49
# of the logarithm: how far two passes may be from twice one pass, and from where on a bend does not fit its labels
FITS, ODD = 0.25, 0.45
# two passes over twice one pass, bend by bend (a pulley in the loop makes it more than 1 in all): how alike it is in sound bends, how far two bends
# stand off, also over the scatter, whose labels are exchanged, and how many others must agree
ALIKE, OFF, SCATTERS, OTHERS = 0.1, 0.15, 3.0, 2
# bends that must match whatever their labels, and what a label of its own is worth (logarithm)
MATCHED, LABELLED = 3, 0.01


def look(log: Sequence[Evidence]) -> Iterator[Remark]:
    """Yield runs whose configurations must be exchanged for every bend to make sense."""
    places: dict[object, dict[str, dict[str, list[Evidence]]]] = {}
    for e in log:
        if e.config_id is not None and e.wrap_about > 0.0:
            places.setdefault((e.location, e.tendon), {}).setdefault(str(e.config_id), {}).setdefault(e.system, []).append(e)
    if second_rig(log)[0]:
        return
    whole = {where: {k: b for k, b in bends.items() if len(b) == 2} for where, bends in places.items()}
    for where, bends in whole.items():
        # the pulley is that of the rig, wherever the bend
        elsewhere = [_apart(*_wraps(b)) for w, others in whole.items() if w != where for b in others.values()]
        told = list(_place(bends, elsewhere))
        yield from told or _matched(places[where])


def _wraps(systems: dict[str, list[Evidence]]) -> tuple[float, float]:
    """Return n theta of one pass and of two in a bend."""
    return _middle(systems["act"]), _middle(systems["sstl"])


def _place(bends: dict[str, dict[str, list[Evidence]]], elsewhere: Sequence[float]) -> Iterator[Remark]:
    """Compare the labels of one place: what remains once the loops are put in the order of actuation."""
    wraps = {k: _wraps(b) for k, b in bends.items()}
    # one pass and two rub most in the same bend, whatever the law: sorted alike they fit, or no exchange explains them
    sorts = [sorted(wraps, key=lambda k: wraps[k][i]) for i in (0, 1)]
    moved = [(k, o) for k, o in zip(*sorts, strict=True) if k != o]
    odd = [k for k, _ in moved]
    beyond = _beyond(wraps, moved, elsewhere)
    if beyond > 0.0:
        yield _said(bends, odd, beyond, "stands off that of the other bends")
        return
    # of labels that went round in a circle one may be far off and all others near
    if not any(abs(_apart(*wraps[k])) > ODD for k in odd):
        return
    left = [abs(_apart(wraps[k][0], wraps[o][1])) for k, o in moved]
    # where exchanged systems explain the bends as well there is nothing to choose: fewer labels are wrong then
    flipped = [abs(_apart(wraps[k][1], wraps[k][0])) for k in odd]
    if max(left) > FITS or max(flipped) < ODD or all(_allowed(bends[k]) for k in odd):
        return
    worst = max(abs(_apart(*wraps[k])) for k in odd)
    yield _said(bends, odd, worst, "is off")


def _matched(bends: dict[str, dict[str, list[Evidence]]]) -> Iterator[Remark]:
    """Match the friction of one pass and of two whatever their labels, where that of some bends is known in one system alone: most fit another label than their own."""
    single, double = ({k: _middle(b[system]) for k, b in bends.items() if system in b} for system in ("act", "sstl"))
    both = {k: _apart(single[k], double[k]) for k in single if k in double}
    own = [k for k, off in both.items() if abs(off) <= FITS]
    bad = [k for k, off in both.items() if abs(off) > ODD and not _allowed(bends[k])]
    if not bad or min(len(single), len(double)) < MATCHED:
        return
    # a third of the start-up of a command, for what few logs come to
    from scipy.optimize import linear_sum_assignment

    rows, columns = list(single), list(double)
    off = np.array([[abs(_apart(single[k], double[o])) for o in columns] for k in rows])
    # as labelled, all else being alike
    cost = np.minimum(off, 2.0 * FITS) + np.array([[0.0 if k == o else LABELLED for o in columns] for k in rows])
    pairs = [(rows[i], columns[j]) for i, j in zip(*linear_sum_assignment(cost), strict=True) if off[i, j] <= FITS]
    moved = [k for k, o in pairs if k != o]
    # where exchanged systems explain the bends as well there is nothing to choose
    flipped = max(abs(_apart(double[k], single[k])) for k in bad)
    if len(pairs) < max(MATCHED, len(own) + 2) or len(moved) < 2 or flipped < ODD:
        return
    odd = sorted({*moved, *bad, *(o for k, o in pairs if k != o)})
    yield _said({k: {s: bends[k].get(s, []) for s in ("act", "sstl")} for k in bends}, odd, max(abs(both[k]) for k in bad), "is off")


def _beyond(wraps: dict[str, tuple[float, float]], moved: list[tuple[str, str]], elsewhere: Sequence[float]) -> float:
    """Return how far (logarithm) two bends stand off the others, all of which are alike once the two are exchanged; 0 where they are not."""
    rest = [*elsewhere, *(_apart(*w) for k, w in wraps.items() if k not in {k for k, _ in moved})]
    if len(moved) != 2 or len(rest) < OTHERS:
        return 0.0
    every = [*rest, *(_apart(wraps[k][0], wraps[o][1]) for k, o in moved)]
    scatter = max(every) - min(every)
    off = sorted(_apart(*wraps[k]) - float(np.median(rest)) for k, _ in moved)
    least = min(-off[0], off[1])
    return max(-off[0], off[1]) if scatter < ALIKE and least > max(OFF, SCATTERS * scatter) else 0.0


def _said(bends: dict[str, dict[str, list[Evidence]]], odd: list[str], worst: float, how: str) -> Remark:
    """Return what is said of the bends whose labels are exchanged, ``worst`` (logarithm) of which is off."""
    systems = _out_of_order(bends)
    hit = [e for k in odd for s in systems for e in bends[k][s]]
    which = f"the {systems[0]} runs" if len(systems) == 1 else "the act runs or of the sstl runs"
    act, sstl = ([e for b in bends.values() for e in b[system]] for system in ("act", "sstl"))
    differ = recorders_differ(act, sstl)
    # one rig has one recorder, whatever it pulls
    rigs = f", or act and loop come from two rigs: they differ in {' and '.join(differ)}" if differ else ""
    return Remark(
        tuple(e.run_id for e in hit), RULE, "failure", 100.0 * math.expm1(worst), "%",
        f"{names([e.run_id for e in hit])}: friction of the loop over twice that of actuation {how} by a factor of {math.exp(worst):.3g} in "
        f"configurations {', '.join(odd)}, and fits in all of them once the configurations of {which} are exchanged; these labels are "
        f"probably shuffled, those of the systems are right{rigs}",
        f"file_name = '(pattern that reads config_id from the name)', or a manifest with the right config_id{', or a log for each rig' if differ else ''}",
    )  # fmt: skip


def _out_of_order(bends: dict[str, dict[str, list[Evidence]]]) -> list[str]:
    """Return the system whose friction leaves the order of the bends (by lead, or by name) that the other one keeps; both where none tells."""
    leads = {k: {e.lead_mm for runs in b.values() for e in runs} for k, b in bends.items()}
    # a lead that went with its run tells nothing of the label
    known = all(len(v) == 1 and None not in v for v in leads.values())
    order = sorted(bends, key=lambda k: next(iter(leads[k])) or 0.0) if known else sorted(bends, key=_by_number)
    broken = {s: int(np.sum(np.diff([_middle(bends[k][s]) for k in order if bends[k][s]]) < 0.0)) for s in ("act", "sstl")}
    away = {s: min(n, len(order) - 1 - n) for s, n in broken.items()}
    if len(order) > 2 and 0 in away.values() and away["act"] != away["sstl"]:
        return ["act"] if away["sstl"] == 0 else ["sstl"]
    return ["act", "sstl"]


def _by_number(name: str) -> list[tuple[int, str]]:
    """Return a key that puts names in the order of the numbers in them."""
    return [(int(part), "") if part.isdigit() else (-1, part) for part in re.split(r"(\d+)", name) if part]


def _allowed(systems: dict[str, list[Evidence]]) -> bool:
    """Whether sound laws of friction make two passes of a bend about twice one pass, whatever its lines tell."""
    (low, high), (least, most) = ([float(np.median([e.wraps[i] for e in systems[s]])) for i in (0, 1)] for s in ("act", "sstl"))
    return _apart(high, least) < FITS and _apart(low, most) > -FITS


def _middle(runs: list[Evidence]) -> float:
    return float(np.median([e.wrap_about for e in runs]))


def _apart(single: float, double: float) -> float:
    return math.log(double / (2.0 * single))
