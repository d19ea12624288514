"""Two rigs under one set of labels: every bend has its runs twice, and the one kind rubs more than the other by the same factor."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from sstl_cli.identification.gate.evidence import Evidence
from sstl_cli.identification.gate.remark import Remark, names

Array = NDArray[np.float64]
RULE, RANK = "two_rigs", 48
# factor between the two kinds that friction of one rig does not reach from run to run, and how well the cells must agree on it (part of its logarithm)
FACTOR, AGREE = 1.25, 0.25
# in one system alone: the factor that counts
ALONE = 1.4
# of the logarithm: how far friction of two passes may be from twice that of one, by the errors of both and the sheath's ends; and what the
# friction of a pulley may leave of what a factor alone leaves
TWO, PULLEY = 0.07, 0.5
# cells (bend, system, movement) with both kinds that tell, and systems: a wrong label of the system makes a factor in one of them only
CELLS, SYSTEMS = 3, 2


def look(log: Sequence[Evidence]) -> Iterator[Remark]:
    """Yield the runs of the rig that rubs more."""
    hit, factor = second_rig(log)
    if hit:
        yield Remark(
            tuple(e.run_id for e in hit), RULE, "remark", factor, "1",
            f"{names([e.run_id for e in hit])}: friction is {factor:.3g} times that of the other runs of the same bend, system and movement, "
            f"in every bend{' and in both systems' if len({e.system for e in hit}) > 1 else ''}; two rigs (or two sheaths) are probably under one set "
            "of labels",
            "import the two groups into logs of their own",
        )  # fmt: skip


def second_rig(log: Sequence[Evidence]) -> tuple[list[Evidence], float]:
    """Return the runs that rub more than others of their cell by one factor, and the factor; none where the cells differ in it."""
    cells: dict[object, list[Evidence]] = {}
    for e in log:
        if e.config_id is not None and e.wrap > 0.0:
            cells.setdefault((e.config_id, e.location, e.system, e.trajectory, e.tendon), []).append(e)
    both = [sorted(c, key=lambda e: e.wrap) for c in cells.values() if len(c) > 1]
    alone = len({c[0].system for c in both}) < SYSTEMS
    if len(both) < CELLS:
        return [], math.nan
    hit, gaps = [], []
    for cell in both:
        logs = np.log([e.wrap for e in cell])
        at = 1 + int(np.argmax(np.diff(logs)))
        gaps.append(float(np.mean(logs[at:]) - np.mean(logs[:at])))
        hit += cell[at:]
    usual = float(np.median(gaps))
    apart = usual > math.log(ALONE if alone else FACTOR)
    if alone and apart:
        low, high = (np.exp([float(np.mean(np.log([e.wrap for e in c if (e in hit) == above]))) for c in both]) for above in (False, True))
        apart = not second_pass(low, high, np.zeros(len(both)))
    same = apart and max(abs(g - usual) for g in gaps) < AGREE * usual
    return (hit, math.exp(usual)) if same else ([], math.nan)


def second_pass(low: Array, high: Array, errors: Array) -> bool:
    """Return whether two kinds of runs differ by a second pass in every bend: twice the friction, and that of a pulley, alike in all bends.

    ``low`` and ``high`` are n theta of both kinds, ``errors`` those of the logarithm of their ratio, shape (n,). Of two rigs the one rubs more by
    a factor of its own.
    """
    ratios = np.log(high / low)
    if bool(np.all(np.abs(ratios - math.log(2.0)) < np.maximum(TWO, errors))):
        return True
    # what a pulley adds is told from a factor where bends differ
    added = high - 2.0 * low
    spread = float(np.ptp(added)) / float(np.max(high))
    return len(low) > 1 and float(np.min(added / high)) > -TWO and spread < TWO and spread < PULLEY * float(np.ptp(ratios))
