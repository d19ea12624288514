"""Which of two bends rubs more, by all that sound laws allow of the friction of runs that show no line: it is the same one in every system and movement."""

from __future__ import annotations

import math
from itertools import combinations

from sstl_cli.identification.gate.evidence import Evidence

# how far (logarithm) the friction of one bend must be above all that laws allow of another one's
ABOVE = 0.1
# least friction that is compared
RUBS = 0.05
Column = tuple[str, str | None]
Bounds = tuple[float, float]


def bounds(e: Evidence) -> Bounds:
    """Return the least and the largest n theta of a run; of one that never leaves its backlash only the least is known.

    Of a run that shows one line laws, gains and zeros are that line, and what it passes on is its friction as well.
    """
    told = [v for v in (*e.wraps, e.slopes.friction if e.slopes.known else math.nan, -e.passed if e.one_way else math.nan) if v > RUBS]
    if not told:
        return math.nan, math.nan
    a = e.ranges[0]
    most = 0.5 * math.log(a.high / a.low) if a.low > 0.0 else math.inf
    return min(*told, most), max(told) if max(told) < most else math.inf


def widest(runs: list[Bounds]) -> Bounds:
    """Return what several runs of one bend allow together."""
    return min(b[0] for b in runs), max(b[1] for b in runs)


def turned(cells: dict[tuple[str, Column], Bounds], above: float) -> list[tuple[str, str, float, list[Column], list[Column]]]:
    """Return pairs of bends of which one rubs more in some columns and the other one in others, by how much (logarithm) at the least, and these columns."""
    bends, columns = sorted({k for k, _ in cells}), sorted({c for _, c in cells}, key=str)
    found = []
    for a, b in combinations(bends, 2):
        both = [c for c in columns if (a, c) in cells and (b, c) in cells]
        steps = {c: _above(cells[b, c], cells[a, c]) or -_above(cells[a, c], cells[b, c]) for c in both}
        ups, downs = [c for c in both if steps[c] > above], [c for c in both if steps[c] < -above]
        if ups and downs:
            found.append((a, b, min(max(steps[c] for c in ups), max(-steps[c] for c in downs)), ups, downs))
    return found


def _above(bend: Bounds, other: Bounds) -> float:
    """Return by how much (logarithm) the least friction of a bend is above the largest of another one, 0 where it is not."""
    return max(0.0, math.log(bend[0] / other[1])) if math.isfinite(other[1]) else 0.0


def flipped_fits(cells: dict[tuple[str, Column], Bounds]) -> bool:
    """Whether bends that rub less in two passes than in one have the systems exchanged, which is another slip: then two passes are nearer to twice one pass than in another order of the bends."""
    flipped, ordered = [0.0], [0.0]
    less = False
    for movement in {m for _, (_, m) in cells}:
        single, double = ({k: v for (k, c), v in cells.items() if c == (system, movement)} for system in ("act", "sstl"))
        both = [(single[k], double[k]) for k in single if k in double]
        less_in = [_above(one, two) > 0.0 for one, two in both]
        less = less or any(less_in)
        flipped += [_misses(*(pair[::-1] if t else pair)) for pair, t in zip(both, less_in, strict=True)]
        ordered += [_misses(one, two) for one, two in zip(*(sorted(p[i] for p in both) for i in (0, 1)), strict=True)]
    return less and max(flipped) < max(ordered) + ABOVE


def _misses(one: Bounds, two: Bounds) -> float:
    """Return how far (logarithm) two passes are from twice one pass at the least."""
    return max(0.0, _apart(one[1], two[0]) if math.isfinite(one[1]) else 0.0, -_apart(one[0], two[1]) if math.isfinite(two[1]) else 0.0)


def _apart(single: float, double: float) -> float:
    return math.log(double / (2.0 * single))
