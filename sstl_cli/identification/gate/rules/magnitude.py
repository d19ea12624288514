"""Tensions that no tendon bears, or so small that nobody would measure them: another unit than N."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from sstl_cli.identification.gate.evidence import Evidence
from sstl_cli.identification.gate.remark import Remark, Severity, names
from sstl_cli.identification.gate.units import WORDS, plausible_units, stated

RULE, RANK = "magnitude", 12
# a 1 mm steel cable breaks at 0.6 to 0.9 kN, a 2 mm one at 2 to 3 kN, which no sheath of a hand's size carries
STRONG_N, IMPOSSIBLE_N = 700.0, 2000.0
# the finest tendons known, in catheters for eye and vessel, are pulled with tenths of a newton
WEAK_N, NOTHING_N = 0.1, 0.05
# what is told of a run beyond each (1 above, -1 below), the worst first
LIMITS: tuple[tuple[float, int, Severity], ...] = (
    (IMPOSSIBLE_N, 1, "failure"), (STRONG_N, 1, "remark"), (NOTHING_N, -1, "failure"), (WEAK_N, -1, "remark"),
)  # fmt: skip
# a tension that is plainly one (N), and how many times it the other channel must read
FEW_N, APART = 2.0, 20.0
# part of the samples that may be no tensions among tensions
FEW_SHARE = 0.02
# step of readings in mN with three digits behind the mark, and the part of it that a step may be off
THOUSANDTH_N, ROUNDED = 1e-6, 0.01
AS_THOUSANDS = "mN with marks between thousands that were read as decimal ones (5.123 for 5123)"


def look(log: Sequence[Evidence]) -> Iterator[Remark]:
    """Yield runs whose larger tension lies outside what tendons carry."""
    groups: dict[tuple[Severity, str], list[Evidence]] = {}
    # loops between tensions that pull: a rod or a brake band may carry more
    loops = [e for e in log if e.tendon_like and not e.correlation < 0.2]
    for e in loops if 2 * len(loops) < len(log) else [e for e in log if e.tendon_like]:
        largest = max(r.largest for r in e.ranges)
        for limit, beyond, severity in LIMITS:
            if beyond * (largest - limit) > 0:
                groups.setdefault((severity, "large" if beyond > 0 else "small"), []).append(e)
                break
    for (severity, kind), hit in groups.items():
        largest = (max if kind == "large" else min)(max(r.largest for r in e.ranges) for e in hit)
        units = plausible_units(largest)
        which = [i for i in (0, 1) if any(_beyond(e.ranges[i].largest, kind) for e in hit)]
        other = max(e.ranges[1 - which[0]].largest for e in hit) if len(which) == 1 else largest
        # friction never makes a hundredth: the other channel is in N where its tension is one
        which = which if len(which) == 1 and FEW_N < other < STRONG_N and max(other / largest, largest / other) > APART else [0, 1]
        guess = " or ".join([*units, "raw counts" if kind == "large" else "volts"])
        said = "tension" if len(which) == 2 else f"the {WORDS[which[0]]} goes"
        holds = "the file" if len(which) == 2 else "its column"
        why = "more than a tendon bears" if kind == "large" else "less than a tendon rig measures"
        mend = "; ".join(stated(i, units[0] if units else "counts") for i in which)
        if kind == "small" and _thousandths(hit):
            guess = f"volts, or {AS_THOUSANDS}"
            mend = "in the recording write numbers without marks between thousands, then import it again"
        yield Remark(
            tuple(e.run_id for e in hit), RULE, severity, largest, "N",
            f"{names([e.run_id for e in hit])}: {said} up to {largest:.4g} N, {why}; {holds} probably holds {guess}, "
            f"not N (N, where the mapping says {'kN' if kind == 'large' else 'mN'})",
            mend,
        )  # fmt: skip


def impossible(values: NDArray[np.float64]) -> int:
    """Return how many readings (N) no tendon bears, 0 where they are many or not far beyond all others: then the channel is in another unit."""
    size = np.abs(values)
    wild = size > IMPOSSIBLE_N
    count = int(np.count_nonzero(wild))
    return count if 0 < count < FEW_SHARE * len(values) and APART * float(size[~wild].max()) < float(size[wild].min()) else 0


def _thousandths(hit: Sequence[Evidence]) -> bool:
    """Return whether readings step by a thousandth of a mN, as numbers with marks between thousands become when the marks are read as decimal ones."""
    steps = [s.step_n for e in hit for s in e.sensors if s.step_n]
    return bool(steps) and all(abs(s / THOUSANDTH_N - 1.0) < ROUNDED for s in steps)


def _beyond(largest: float, kind: str) -> bool:
    return largest > STRONG_N if kind == "large" else largest < WEAK_N
