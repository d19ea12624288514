"""The same rates side by side: each simulator and all together, and the cases that the recordings could decide."""

from __future__ import annotations

from collections.abc import Mapping, Sequence, Set
from statistics import median

from sstl_cli.blind.calibration import calibrated
from sstl_cli.blind.judge import NAMED, Judged, of, share
from sstl_cli.blind.score import Sides, scores
from sstl_cli.blind.strength import STRENGTHS
from sstl_cli.core.documents.blind import AgainstLimit, CaseDistance, DistanceRow, SimulatorRow
from sstl_cli.core.observer import ideal
from sstl_cli.diagnosis.constants import DECIDABLE

ALL = "all"
# strata of the smaller of the distances to base and nearest rival
STRATA = (0.0, 6.0, 24.0, 100.0, 400.0, 1600.0)


def compared(cases: Sequence[Judged], distances: Mapping[str, CaseDistance] | None = None) -> Sides:
    """Return the rates by simulator and, where distances are known, of decidable cases and by distance; all cases last."""
    if distances is None:
        return Sides(rows(cases))
    decidable = {c for c, row in distances.items() if row.decidable}
    # where nothing is missing there is nothing to decide between: those cases stay
    left = [c for c in cases if c.kind == "none" or c.case in decidable]
    d2 = {c: d for c, row in distances.items() if (d := smallest(row)) is not None}
    combined = {c for c, row in distances.items() if row.d2_joined is not None and row.d2_joined < DECIDABLE}
    return Sides(rows(cases), rows(left), by_d2(cases, d2), against_limit(cases, decidable, d2, combined))


def against_limit(cases: Sequence[Judged], decidable: Set[str], d2: Mapping[str, float], combined: Set[str] = frozenset()) -> AgainstLimit:
    """Return what the targets ask of the cases that their recordings could decide, and of those that they could not.

    Parameters
    ----------
    combined : set of str
        Cases that a pair or triple of candidates shows as well, though no single candidate does.
    """
    told = [c for c in cases if c.case in decidable]
    single = of(told, "single")
    return AgainstLimit(
        isolation=share(c.exact for c in single),
        unknown_recall=share(c.recalled for c in of(told, "outside")),
        unknown_recall_joined=share(c.recalled for c in of(told, "outside") if c.case not in combined),
        both_of_a_pair=share(c.withheld <= c.named for c in of(told, "pair")),
        ideal=_ideal([d2[c.case] for c in single if c.case in d2]),
        undecidable_in_set=share(
            c.status in NAMED and c.covered for c in of(cases, "single", "pair") if c.case in d2 and c.case not in decidable
        ),
    )


def _ideal(d2: Sequence[float]) -> float | None:
    return sum(map(ideal, d2)) / len(d2) if d2 else None


def smallest(row: CaseDistance) -> float | None:
    """Return the smaller of a case's distances to the base and to the nearest rival, None where it has none."""
    found = [d2 for d2 in (row.d2_base, row.d2_rival) if d2 is not None]
    return min(found) if found else None


def by_d2(cases: Sequence[Judged], d2: Mapping[str, float]) -> list[DistanceRow]:
    """Return rates in strata of the distance, with the mean of what an ideal observer would reach on the same cases."""
    found = []
    for low, high in zip(STRATA, (*STRATA[1:], float("inf")), strict=True):
        inside = [c for c in cases if c.kind != "poor" and c.case in d2 and low <= d2[c.case] < high]
        single, pair, outside = of(inside, "single"), of(inside, "pair"), of(inside, "outside")
        at = [d2[c.case] for c in single]
        found.append(
            DistanceRow(
                d2_low=low,
                d2_high=None if high == float("inf") else high,
                cases=len(inside),
                d2_median=median(at) if at else None,
                isolation=share(c.exact for c in single),
                in_group=share(c.status in NAMED and c.covered for c in single),
                ideal=_ideal(at),
                unknown_recall=share(c.recalled for c in outside),
                both_of_a_pair=share(c.withheld <= c.named for c in pair),
            )
        )
    return found


def rows(cases: Sequence[Judged]) -> list[SimulatorRow]:
    """Return the rates of each simulator, and of all together in the last row."""
    names = sorted({c.truth.simulator for c in cases})
    found = [_row(n, [c for c in cases if c.truth.simulator == n]) for n in names]
    return [*found, _row(ALL, list(cases))]


def _row(name: str, cases: Sequence[Judged]) -> SimulatorRow:
    single = of(cases, "single")
    by_strength = {f"{s:g}": share(c.exact for c in single if c.band == s) for s in STRENGTHS}
    in_group = {f"{s:g}": share(c.status in NAMED and c.covered for c in single if c.band == s) for s in STRENGTHS}
    return SimulatorRow(
        simulator=name, cases=len(cases), scores=scores(cases, calibrated(ALL, cases)), isolation=by_strength, in_group=in_group
    )
