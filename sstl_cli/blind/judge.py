"""What a verdict is worth against the truth of one case."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from math import sqrt

from sstl_cli.blind.result import Result
from sstl_cli.blind.truth import CaseTruth
from sstl_cli.core.documents.blind import Share
from sstl_cli.core.groups import spelled_out
from sstl_cli.diagnosis import verdict
from sstl_cli.diagnosis.features import Rows
from sstl_cli.diagnosis.weights import Weights

COMMITTED, NAMED = ("identified",), ("identified", "ambiguous")


@dataclass(frozen=True)
class Judged:
    """One case with its verdict; ``band`` is the nominal strength (0.4, 1.2, 4), None where nothing shows."""

    case: str
    truth: CaseTruth
    status: str
    effects: tuple[str, ...]
    group: tuple[str, ...]
    confidence: float | None
    seconds: float
    baselines: Mapping[str, str | None]
    predicted_pct: float | None
    realised_pct: float | None
    samples: int = 0

    @property
    def kind(self) -> str:
        """``none``, ``single``, ``pair``, ``outside`` or ``poor``: what the scores tell apart."""
        if self.truth.poor:
            return "poor"
        if self.truth.excluded or self.truth.unlisted:
            return "outside"
        return ("none", "single", "pair")[min(len(self.withheld), 2)]

    @property
    def withheld(self) -> frozenset[str]:
        return frozenset(self.truth.effects)

    @property
    def also(self) -> frozenset[str]:
        """What a disturbance from no list is by the catalogue's own words all the same: a reading that sticks is a fault of the recorder."""
        return frozenset(self.truth.also)

    @property
    def true(self) -> frozenset[str]:
        """The names that are right: what was withheld, as far as a candidate or the catalogue has a name for it."""
        return {"outside": self.also, "none": frozenset[str]()}.get(self.kind, self.withheld)

    @property
    def band(self) -> float | None:
        return self.truth.band

    @property
    def named(self) -> frozenset[str]:
        return frozenset(self.effects) if self.status in NAMED else frozenset()

    @property
    def exact(self) -> bool:
        """The verdict commits itself to exactly what was withheld."""
        return self.status == "identified" and self.named == self.withheld

    @property
    def wrong_commit(self) -> bool:
        """The verdict commits itself to a name that was not withheld (or could not be seen as a candidate)."""
        return self.status in COMMITTED and not self.named <= self.true

    @property
    def covered(self) -> bool:
        """Everything withheld is in the ambiguity group."""
        return self.withheld <= set(self.group) | set(self.effects)

    @property
    def recalled(self) -> bool:
        """What no candidate explains is told as unknown, or by the name that it has all the same."""
        return self.status == "unknown" or (self.status in COMMITTED and bool(self.also) and self.named == self.also)

    @property
    def right(self) -> bool:
        """What the stated confidence is about: a group that holds the truth, or the right kind of no."""
        if self.status in NAMED:
            return bool(self.true) and self.true <= set(self.group) | set(self.effects)
        if self.kind == "poor" and self.band is None:
            # nothing shows on such a movement: to say so, in either way, is right
            return self.status in ("none", "unknown")
        return self.kind == {"none": "none", "unknown": "outside"}.get(self.status)

    def answer(self) -> str:
        """Return the verdict as a label: an effect, several, ``ambiguous``, ``unknown`` or ``none``."""
        if self.status == "identified":
            return " + ".join(sorted(self.effects))
        return self.status


def judge(case: str, truth: CaseTruth, result: Result, realised_pct: float | None) -> Judged:
    """Return a case with its verdict, from a result file of ``blind run``."""
    found, said = result.diagnosis, result.diagnosis.verdict
    named = said.status in NAMED
    return Judged(
        case,
        truth,
        said.status,
        tuple(said.effects),
        spelled_out(said.ambiguity_group, said.members),
        said.confidence,
        result.seconds,
        found.baselines,
        found.gap.shrink_pct if named else None,
        realised_pct if named else None,
        found.analysis.samples if found.analysis is not None else 0,
    )


def by_others(case: Judged, rows: Rows, weights: Weights) -> Judged:
    """Return a case as other weights judge the rows that were kept of it."""
    said = verdict.verdict(rows, weights)
    group = tuple(dict.fromkeys(i for ids in said.group for i in ids))
    return replace(case, status=said.status, effects=said.effects, group=group, confidence=said.confidence)


def wilson(k: int, n: int, z: float = 1.959964) -> tuple[float, float]:
    """Return the Wilson interval of a share of k in n (Wilson 1927).

    Examples
    --------
    >>> low, high = wilson(8, 10)
    >>> round(low, 3), round(high, 3)
    (0.49, 0.943)
    """
    if n == 0:
        return float("nan"), float("nan")
    p = k / n
    middle, half = p + z * z / (2 * n), z * sqrt(p * (1 - p) / n + z * z / (4 * n * n))
    return max(0.0, (middle - half) / (1 + z * z / n)), min(1.0, (middle + half) / (1 + z * z / n))


def share(hits: Iterable[bool]) -> Share | None:
    """Return a proportion with its interval; None where there is no case."""
    found = list(hits)
    if not found:
        return None
    k, n = sum(found), len(found)
    low, high = wilson(k, n)
    return Share(k=k, n=n, share=k / n, low=low, high=high)


def of(cases: Sequence[Judged], *kinds: str) -> list[Judged]:
    """Return the cases of some kinds."""
    return [c for c in cases if c.kind in kinds]
