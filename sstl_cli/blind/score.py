"""Scores of a set of judged cases: by strength, by effect, beside simple rules, against the targets."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from sstl_cli.blind.calibration import calibrated, reliability
from sstl_cli.blind.judge import NAMED, Judged, of, share
from sstl_cli.blind.strength import STRENGTHS
from sstl_cli.blind.targets import targets
from sstl_cli.core.documents.blind import (
    AgainstLimit,
    BlindScoreDocument,
    CalibrationRow,
    CaseLine,
    Confusion,
    DistanceRow,
    EffectRow,
    GroupSize,
    NothingRow,
    PoorRates,
    RuleRow,
    Scores,
    Seconds,
    ShrunkCase,
    SimulatorRow,
    StrengthRow,
    WrongNominal,
)

# a case as long as the one of which a target says how many seconds it may take
LONG_SAMPLES = 50_000


@dataclass(frozen=True)
class Sides:
    """The rates by simulator, by weights that have not seen it where rows were kept; decidable cases and by distance where that is known."""

    by_simulator: list[SimulatorRow]
    decidable: list[SimulatorRow] | None = None
    by_d2: list[DistanceRow] | None = None
    against_limit: AgainstLimit | None = None
    left_out: list[SimulatorRow] | None = None


@dataclass(frozen=True)
class Set:
    """The set that is scored: cases without a result, whether it is a quick one, its seal, and what was learned from."""

    missing_results: int = 0
    quick: bool = False
    seal: str = ""
    learned_from: Sequence[tuple[int, int]] = ()


def document(cases: Sequence[Judged], sides: Sides, of_set: Set) -> BlindScoreDocument:
    """Return the score of a set, before any gate."""
    cases = sorted(cases, key=lambda c: c.case)
    shrunk = [(c.case, c.predicted_pct, c.realised_pct) for c in cases if c.predicted_pct is not None and c.realised_pct is not None]
    stated = calibrated("all", cases)
    measured = scores(cases, stated)
    calibration = [
        stated,
        calibrated("something missing", [c for c in cases if c.kind != "none"]),
        calibrated("nothing missing", of(cases, "none")),
    ]
    nominal = [c for c in cases if c.truth.wrong_nominal]
    return BlindScoreDocument(
        schema="sstl.blind.score/1",
        cases=len(cases),
        kinds=dict(sorted(Counter(c.kind for c in cases).items())),
        confusion=confusion(cases),
        by_strength=[*(_row(cases, s) for s in STRENGTHS), _nothing(cases)],
        by_effect=by_effect(cases),
        baselines=baselines(cases),
        reliability=reliability(cases)[0],
        ece=stated.ece,
        group=group(cases),
        shrink=[ShrunkCase(case=c, predicted_pct=p, realised_pct=r) for c, p, r in shrunk],
        shrink_mean_difference_pct=_mean(abs(p - r) for _, p, r in shrunk),
        poor=_poor(cases),
        wrong_nominal=WrongNominal(
            false_alarm=share(c.status != "none" for c in of(nominal, "none")), isolation=share(c.exact for c in of(nominal, "single"))
        ),
        seconds=_seconds(cases),
        verdicts=[_line(c) for c in cases],
        scores=measured,
        targets=targets(measured, stated, sides.against_limit),
        by_simulator=sides.by_simulator,
        left_out=sides.left_out,
        decidable=sides.decidable,
        by_d2=sides.by_d2,
        against_limit=sides.against_limit,
        calibration=calibration,
        missing_results=of_set.missing_results,
        quick=of_set.quick,
        seal=of_set.seal,
        learned_from=[list(seeds) for seeds in of_set.learned_from],
        gates_missed=[],
    )


def scores(cases: Sequence[Judged], stated: CalibrationRow) -> Scores:
    """Return every rate of a set of cases with its Wilson interval, and their calibration; None where no case bears on it."""
    single = of(cases, "single")
    return Scores(
        false_alarm=share(c.status != "none" for c in of(cases, "none")),
        isolation=share(c.exact for c in single if c.band in STRENGTHS[1:]),
        isolation_weak=share(c.exact for c in single if c.band == STRENGTHS[0]),
        wrong_commits=share(c.wrong_commit for c in cases if c.kind != "none"),
        unknown_recall=share(c.recalled for c in of(cases, "outside")),
        both_of_a_pair=share(c.withheld <= c.named for c in of(cases, "pair")),
        ece=stated.ece,
        ece_chance=stated.ece_chance_95,
        slope=stated.slope,
        coverage=share(c.covered for c in of(cases, "single", "pair") if c.status in NAMED),
    )


def _row(cases: Sequence[Judged], strength: float) -> StrengthRow:
    at = [c for c in cases if c.band == strength and c.kind != "none"]
    single = of(at, "single")
    return StrengthRow(
        strength=strength,
        isolation=share(c.exact for c in single),
        first_named=share(c.status in NAMED and c.named == c.withheld for c in single),
        in_group=share(c.status in NAMED and c.covered for c in single),
        said_none=share(c.status == "none" for c in single),
        wrong_commits=share(c.wrong_commit for c in at if c.kind != "poor"),
        unknown_recall=share(c.recalled for c in of(at, "outside")),
        both_of_a_pair=share(c.withheld <= c.named for c in of(at, "pair")),
        coverage=share(c.covered for c in of(at, "single", "pair") if c.status in NAMED),
        group_size=_mean(len(c.group) for c in at if c.status in NAMED),
    )


def _nothing(cases: Sequence[Judged]) -> NothingRow:
    nothing = of(cases, "none")
    return NothingRow(
        strength=None,
        nothing_missing=True,
        false_alarm=share(c.status != "none" for c in nothing),
        named=share(c.status in NAMED for c in nothing),
        said_unknown=share(c.status == "unknown" for c in nothing),
    )


def _seconds(cases: Sequence[Judged]) -> Seconds:
    long = [c.seconds for c in cases if c.samples >= LONG_SAMPLES]
    return Seconds(
        mean=_mean(c.seconds for c in cases), max=max((c.seconds for c in cases), default=None), long_mean=_mean(long), long_cases=len(long)
    )


def _poor(cases: Sequence[Judged]) -> PoorRates:
    poor = of(cases, "poor")
    return PoorRates(
        wrong_commits=share(c.wrong_commit for c in poor),
        abstained=share(c.status in ("none", "unknown", "ambiguous") for c in poor),
        coverage=share(c.covered for c in poor if c.status in NAMED),
    )


def group(cases: Sequence[Judged]) -> GroupSize:
    """Return size and coverage of the ambiguity set where a verdict names something that was withheld."""
    named = [c for c in of(cases, "single", "pair") if c.status in NAMED]
    return GroupSize(
        mean_size=_mean(len(c.group) for c in named),
        largest=max((len(c.group) for c in named), default=None),
        coverage=share(c.covered for c in named),
    )


def confusion(cases: Sequence[Judged]) -> Confusion:
    """Return counts of truth (rows) against verdict (columns).

    Rows are single effects, ``pair``, ``unknown`` (nothing in the list of candidates explains it) and ``none``. An
    ambiguous verdict counts under the effect it puts first if that is the true one, else under ``ambiguous``; several
    named effects count under ``pair`` where they are the withheld ones, else under ``other pair``.
    """
    counts: Counter[tuple[str, str]] = Counter()
    for c in cases:
        row = _truth_label(c)
        if row is not None:
            counts[row, _answer_label(c)] += 1
    last = ["pair", "unknown", "none"]
    effects = sorted(({r for r, _ in counts} | {a for _, a in counts}) - {*last, "other pair", "ambiguous"})
    rows = [e for e in [*effects, *last] if any(r == e for r, _ in counts)]
    columns = [*effects, *last, "other pair", "ambiguous"]
    return Confusion(labels=rows, columns=columns, matrix=[[counts[r, a] for a in columns] for r in rows])


def _truth_label(c: Judged) -> str | None:
    if c.kind == "poor":
        return None
    return {"none": "none", "outside": "unknown", "pair": "pair"}.get(c.kind) or next(iter(c.withheld))


def _answer_label(c: Judged) -> str:
    if c.status not in NAMED:
        return c.status
    if c.status == "ambiguous" and c.named != c.withheld:
        return "ambiguous"
    if len(c.named) > 1:
        return "pair" if c.kind == "pair" and c.named == c.withheld else "other pair"
    return next(iter(c.named), "ambiguous")


def by_effect(cases: Sequence[Judged]) -> list[EffectRow]:
    """Return isolation of each effect at each strength, and its misses."""
    rows = []
    single = of(cases, "single")
    for effect in sorted({e for c in single for e in c.withheld}):
        own = [c for c in single if effect in c.withheld]
        rows.append(
            EffectRow(
                effect=effect,
                isolation={f"{s:g}": share(c.exact for c in own if c.band == s) for s in STRENGTHS},
                **{"below_0.1": sum(c.band is None for c in own)},
                misses=[_line(c) for c in own if not c.exact],
                reason=_reason([c for c in own if not c.exact]),
            )
        )
    return rows


def _reason(misses: Sequence[Judged]) -> str:
    """Return why cases of one effect were likely missed, the most frequent reason first."""
    kinds = [(_kind_of_miss(c), c) for c in misses]
    mates = Counter(e for kind, c in kinds if kind == "group" for e in set(c.group) - c.withheld)
    names = Counter(e for kind, c in kinds if kind == "name" for e in c.named | set(c.group))
    said = {
        "none": "below what noise lets be seen",
        "unknown": "seen, but the fitted model leaves too much to name it",
        "failed": "the diagnosis ended with an error",
        "group": f"as well explained by {_first(mates)}",
        "alone": "named alone, but not surely",
        "name": f"taken for {_first(names)}",
    }
    return "; ".join(f"{n} {said[kind]}" for kind, n in Counter(kind for kind, _ in kinds).most_common())


def _kind_of_miss(c: Judged) -> str:
    if c.status not in NAMED:
        return c.status
    if not c.covered:
        return "name"
    return "group" if set(c.group) - c.withheld else "alone"


def _first(names: Counter[str]) -> str:
    # sets have no order of their own: ties go by name, or the text would differ from run to run
    return ", ".join(sorted(names, key=lambda name: (-names[name], name))[:3])


def baselines(cases: Sequence[Judged]) -> list[RuleRow]:
    """Return what simpler rules answer on the same cases, strength by strength; None stands for "none"."""
    rules: dict[str, Callable[[Judged], str | None]] = {
        "always none": lambda c: None,
        "smallest RMSE": lambda c: c.baselines.get("smallest_rmse"),
        "iid BIC": lambda c: c.baselines.get("iid_bic"),
    }
    rows = []
    for strength in STRENGTHS:
        at = [c for c in cases if c.band == strength]
        single, outside = of(at, "single"), of(at, "outside")
        something = of(at, "single", "pair", "outside")
        if not something:
            continue
        nothing = of(cases, "none")
        rows.append(
            RuleRow(
                name=f"sstl diagnose at {strength:g}",
                strength=strength,
                isolation=share(c.exact for c in single),
                false_alarm=share(c.status != "none" for c in nothing),
                wrong_commits=share(c.wrong_commit for c in something),
                unknown_recall=share(c.recalled for c in outside),
            )
        )
        for name, rule in rules.items():
            rows.append(
                RuleRow(
                    name=f"{name} at {strength:g}",
                    strength=strength,
                    isolation=share({rule(c)} == c.withheld for c in single),
                    false_alarm=share(rule(c) is not None for c in nothing),
                    wrong_commits=share(rule(c) is not None and (c.kind == "outside" or rule(c) not in c.withheld) for c in something),
                    unknown_recall=share(False for _ in outside),
                )
            )
    return rows


def _line(c: Judged) -> CaseLine:
    return CaseLine(
        case=c.case,
        kind=c.kind,
        withheld=sorted(c.withheld),
        strength=c.truth.strength,
        status=c.status,
        effects=list(c.effects),
        ambiguity_group=list(c.group),
        confidence=c.confidence,
        right=c.right,
        wrong_commit=c.wrong_commit,
    )


def _mean(values: Any) -> float | None:
    found = [float(v) for v in values]
    return float(np.mean(found)) if found else None
