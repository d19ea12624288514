"""One position in two runs, reading by reading: an encoder follows the drive of its own run, and no drive goes the same way twice to the last digit.

A position that is commanded does, and so it is told only where the position of a movement is another one in other runs.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import combinations

import numpy as np

from sstl_cli.identification.gate.evidence import Evidence
from sstl_cli.identification.gate.movement import POINTS, Movement, unlike
from sstl_cli.identification.gate.remark import Remark, names

RULE = "position"
ITS_OWN = "position_in_mm = { column = ..., file = (the file of this run) }"
# means by which a position is the same, within the rounding of their sums
LEAST, ROUNDING = POINTS // 4, 1e-12
# what one input may leave of another one of the same movement
ALIKE = 0.3
# how many times more of a position must be left by its own input than by that of the other run for its own to be the foreign one
CLEARLY = 2.0


def copied_of(log: Sequence[Evidence]) -> Iterator[Remark]:
    """Yield the two runs of a log that hold one position while their tensions differ."""
    known = [e for e in log if len(e.position_movement.means) >= LEAST]
    pairs = [(a, b) for a, b in combinations(known, 2) if _same(a.position_movement, b.position_movement)]
    if len(pairs) != 1:
        return
    a, b = pairs[0]
    if _same(a.movement, b.movement) or (_alike(a, b) and not any(_tells(o, a, b) for o in known if o is not a and o is not b)):
        return
    left = {e.run_id: unlike(e.position_movement, e.movement) for e in (a, b)}
    worse, better = sorted((a, b), key=lambda e: -left[e.run_id])
    said = f"{names([a.run_id, b.run_id])}: both hold the same position, reading by reading, while their tensions differ"
    if left[worse.run_id] > CLEARLY * left[better.run_id]:
        ids: tuple[str, ...] = (worse.run_id,)
        said += (
            f"; the input of {better.run_id} leaves {100.0 * left[better.run_id]:.2g} % of its movement unexplained and that of {worse.run_id} "
            f"{100.0 * left[worse.run_id]:.2g} %, so that {worse.run_id} probably has the position of another run"
        )
    else:
        ids, said = (a.run_id, b.run_id), f"{said}; one of them probably has the position of another run"
    yield Remark(
        ids, RULE, "remark", 100.0 * left[worse.run_id], "%",
        said,
        ITS_OWN,
    )  # fmt: skip


def _same(a: Movement, b: Movement) -> bool:
    """Whether two columns are the same numbers as far as both go."""
    if not a.means or not b.means:
        return False
    block = max(a.block, b.block)
    if a.block == b.block and a.means[0] != b.means[0]:
        return False
    first, second = a.over(block), b.over(block)
    n = min(len(first), len(second))
    if n < LEAST:
        return False
    span = float(np.ptp(first[:n]))
    return span > 0.0 and bool(np.all(np.abs(first[:n] - second[:n]) <= ROUNDING * max(span, math.fabs(float(first[0])))))


def _alike(a: Evidence, b: Evidence) -> bool:
    return unlike(a.movement, b.movement) < ALIKE


def _tells(o: Evidence, a: Evidence, b: Evidence) -> bool:
    """Whether another run shows that positions of this movement do not repeat by themselves: one of the same configuration where the two are of one, or beside either of them."""
    bends = {a.config_id, b.config_id}
    return _alike(o, a) and (len(bends) > 1 or o.config_id in bends)
