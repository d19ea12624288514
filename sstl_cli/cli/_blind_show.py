"""How the withheld-effect check looks on a terminal, and its gates."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Annotated, Any

import typer

from sstl_cli.cli.render import Screen

if TYPE_CHECKING:
    from sstl_cli.core.documents.blind import (
        BlindLearnDocument,
        BlindScoreDocument,
        CaseLine,
        DistanceRow,
        Scores,
        Share,
        SimulatorRow,
        TargetRow,
    )
    from sstl_cli.core.documents.blind_real import BlindInjectDocument, BlindRealDocument

# option -> (score, whether it is an upper bound)
GATES = {
    "max_false_alarm": ("false_alarm", True),
    "min_isolation": ("isolation", False),
    "min_isolation_weak": ("isolation_weak", False),
    "max_wrong_commits": ("wrong_commits", True),
    "min_unknown_recall": ("unknown_recall", False),
    "min_pairs": ("both_of_a_pair", False),
    "max_ece": ("ece", True),
}
MISSES_SHOWN = 12


def _gate(name: str) -> Any:
    """Return the option of a gate."""
    score, upper = GATES[name]
    what = score.replace("_", " ").replace(" weak", " below 0.6 x noise").replace("ece", "ECE")
    help_text = f"Gate: {what} at {'most' if upper else 'least'} this share (exit 4 if missed)."
    return typer.Option("--" + name.replace("_", "-"), min=0, max=1, help=help_text)


@dataclass(frozen=True, kw_only=True)
class Gates:
    """Bounds on the scores, as far as a call gives them."""

    max_false_alarm: Annotated[float | None, _gate("max_false_alarm")] = None
    min_isolation: Annotated[float | None, _gate("min_isolation")] = None
    min_isolation_weak: Annotated[float | None, _gate("min_isolation_weak")] = None
    max_wrong_commits: Annotated[float | None, _gate("max_wrong_commits")] = None
    min_unknown_recall: Annotated[float | None, _gate("min_unknown_recall")] = None
    min_pairs: Annotated[float | None, _gate("min_pairs")] = None
    max_ece: Annotated[float | None, _gate("max_ece")] = None


def missed(scores: Scores, gates: Gates) -> list[str]:
    """Return the gates that a score misses, each as a sentence; no case at all misses a gate, too."""
    texts = []
    for name, bound in asdict(gates).items():
        if bound is None:
            continue
        score, upper = GATES[name]
        value, _ = scores.of(score)
        said = score.replace("_", " ")
        if value is None:
            texts.append(f"{said}: no case of the set bears on it")
        elif (value > bound) if upper else (value < bound):
            texts.append(f"{said} {value:.3g} is {'above' if upper else 'below'} {bound:g}")
    return texts


def score(screen: Screen, document: BlindScoreDocument) -> None:
    """Print targets, scores by strength and effect, baselines, misses and wrong names."""
    _targets(screen, document.targets)
    sides(screen, "by simulator", document.by_simulator)
    if document.left_out is not None:
        sides(screen, "by simulator, judged by weights that were learned without it", document.left_out)
    if document.decidable is not None:
        sides(screen, "decidable cases only (D^2 of at least 24 to base and nearest rival)", document.decidable)
        by_d2(screen, document.by_d2 or [])
    _strengths(screen, document)
    _misses(screen, [v for e in document.by_effect for v in e.misses])
    _wrong(screen, [v for v in document.verdicts if v.wrong_commit])
    size, off = document.group.mean_size, document.shrink_mean_difference_pct
    if size is not None:
        screen.say(f"ambiguity set: {size:.2f} members on average")
    if off is not None:
        screen.say(f"shrinkage: predicted and realised differ by {off:.1f} percentage points on average")
    seconds = document.seconds
    screen.say(f"time a case: {seconds.mean or 0.0:.1f} s on average, {seconds.max or 0.0:.1f} s at most")


def _targets(screen: Screen, targets: Sequence[TargetRow]) -> None:
    from sstl_cli.blind.targets import WITHIN

    rows: list[tuple[object, ...]] = []
    for t in targets:
        sign = {"max": "<=", "min": ">=", "within": f"+-{WITHIN.get(t.id, 0.0):g} of"}[t.rule]
        by_chance = f", chance {t.chance:.3f}" if t.chance is not None else ""
        value = f"{t.value:.3f}" if t.k is None and t.value is not None else _pct(t.value)
        count = f"{t.k}/{t.n}" if t.k is not None else ""
        spread = f"{t.low:.2f}-{t.high:.2f}" if t.low is not None and t.high is not None else ""
        verdict = {True: "met", False: "MISSED", None: "no case"}[t.met]
        rows.append((t.name, value, count, spread, f"{sign} {t.target:g}{by_chance}", verdict))
    screen.table("targets", ("score", "value", "cases", "95 %", "target", ""), rows)


def _strengths(screen: Screen, document: BlindScoreDocument) -> None:
    """Print the scores by strength, beside simple rules, and by effect."""
    from sstl_cli.blind.strength import STRENGTHS
    from sstl_cli.core.documents.blind import StrengthRow

    header = ("strength", "isolation", "in group", "wrong commits", "unknown recall", "pairs", "coverage")
    fields = ("isolation", "in_group", "wrong_commits", "unknown_recall", "both_of_a_pair", "coverage")
    strengths: list[tuple[object, ...]] = [
        (f"{r.strength:g} x noise", *(_share(getattr(r, f)) for f in fields)) for r in document.by_strength if isinstance(r, StrengthRow)
    ]
    screen.table("by strength (right of all)", header, strengths)
    compared = ("isolation", "false_alarm", "wrong_commits", "unknown_recall")
    screen.table(
        "beside simple rules",
        ("rule", *(f.replace("_", " ") for f in compared)),
        [(b.name, *(_share(getattr(b, f)) for f in compared)) for b in document.baselines],
    )
    screen.table(
        "isolation by effect, and why the others were likely missed",
        ("effect", *(f"{s:g}" for s in STRENGTHS), "misses"),
        [(e.effect, *map(_share, e.isolation.values()), e.reason) for e in document.by_effect],
    )


def _misses(screen: Screen, misses: Sequence[CaseLine]) -> None:
    if not misses:
        return
    screen.table(
        "missed single effects",
        ("case", "withheld", "strength", "verdict", "named or grouped"),
        [(m.case, "+".join(m.withheld), m.strength, m.status, ", ".join(m.ambiguity_group)) for m in misses[:MISSES_SHOWN]],
        f"and {len(misses) - MISSES_SHOWN} more in --json" if len(misses) > MISSES_SHOWN else "",
    )


def _wrong(screen: Screen, wrong: Sequence[CaseLine]) -> None:
    if not wrong:
        return
    screen.table(
        "wrong names",
        ("case", "kind", "withheld", "strength", "named", "confidence"),
        [(w.case, w.kind, "+".join(w.withheld), w.strength, "+".join(w.effects), w.confidence) for w in wrong[:MISSES_SHOWN]],
    )


def by_d2(screen: Screen, rows: Sequence[DistanceRow]) -> None:
    """Print rates in strata of the distance, beside an ideal observer's."""
    said = [
        (
            f"{r.d2_low:g}-{r.d2_high:g}" if r.d2_high is not None else f"{r.d2_low:g} and more",
            _share(r.isolation), _pct(r.ideal), _share(r.in_group), _share(r.unknown_recall), _share(r.both_of_a_pair),
        )
        for r in rows
    ]  # fmt: skip
    header = ("D^2", "isolation", "ideal observer", "in group", "unknown recall", "pairs")
    screen.table("by the distance to base and nearest rival", header, said)


def real(screen: Screen, document: BlindRealDocument) -> None:
    """Print what was taken out and what was named."""
    screen.table(
        "taken out of the accepted model and diagnosed back",
        ("taken out", "from", "verdict", "named", "shrink %"),
        [(r.taken_out or "nothing", r.origin, r.status, ", ".join(r.ambiguity_group), r.shrink_pct) for r in document.trials],
    )
    screen.say(
        f"{document.named} of {document.of} named, {document.in_group} in the ambiguity group, "
        f"{document.wrong} wrong; with nothing taken out: {'an alarm' if document.false_alarm else 'none'}"
    )
    if document.false_alarm:
        screen.note("the model does not explain these recordings: what it leaves is more than noise and hides its terms")


def injected(screen: Screen, document: BlindInjectDocument) -> None:
    """Print what was put into recordings and what was said."""
    screen.table(
        "put into the second half of each log",
        ("log", "model", "put in", "size", "verdict", "named", "estimate", "decidable"),
        [
            (
                r.log,
                "rig's" if r.with_model else "none",
                r.effect or "nothing",
                r.size,
                r.status,
                " + ".join(r.effects),
                r.estimate,
                {True: "yes", False: "no", None: ""}[r.decidable],
            )
            for r in document.rows
        ],
    )
    for key, said in (("with_model", "with the rig's model"), ("without_model", "without it")):
        if (s := getattr(document, key)) is not None:
            screen.say(
                f"{said}: {s.named} of {s.of} named ({s.decidable_named} of {s.decidable} that the record can tell), {s.in_group} in "
                f"the ambiguity group, {s.wrong} wrong, {s.close} of those named within 20 %; untouched halves: {s.untouched_none} of {s.untouched} none"
            )


def _share(found: Share | None) -> str:
    return "-" if found is None else f"{found.k}/{found.n}"


def _pct(value: float | None) -> str:
    return "-" if value is None else f"{100 * value:.1f} %"


def sides(screen: Screen, title: str, rows: Sequence[SimulatorRow]) -> None:
    """Print every rate with one column a simulator and one for all, with Wilson intervals."""
    from sstl_cli.blind.strength import STRENGTHS
    from sstl_cli.blind.targets import SAID

    lines: list[tuple[object, ...]] = [("cases", *(r.cases for r in rows))]
    for s in STRENGTHS:
        lines.append((f"isolation at {s:g} x noise", *(_interval(r.isolation[f"{s:g}"]) for r in rows)))
    for s in STRENGTHS:
        lines.append((f"in group at {s:g} x noise", *(_interval(r.in_group[f"{s:g}"]) for r in rows)))
    for name, said in SAID.items():
        lines.append((said, *(_interval(getattr(r.scores, name)) for r in rows)))
    screen.table(title, ("rate (right of all, 95 %)", *(r.simulator for r in rows)), lines)


def learned(screen: Screen, document: BlindLearnDocument) -> None:
    """Print how weights learned on the other simulators do on each one."""
    from sstl_cli.blind.strength import STRENGTHS

    names = ("both_of_a_pair", "covered", "false_alarm", "wrong_commits", "wrong_as_drawn", "unknown_recall", "right")
    header = ("left out", "cases", *(f"exact at {s:g}" for s in STRENGTHS), *(n.replace("_", " ") for n in names))
    titles = {"left_out": "weights learned on the other simulators", "accepted": "the same, of what has changed since a model was accepted"}
    for part, found in (("left_out", document.left_out), ("accepted", document.accepted)):
        if found is None:
            continue
        rows: list[tuple[object, ...]] = [
            (r.simulator, r.cases, *map(_share, r.exact.values()), *(_share(getattr(r, n)) for n in names)) for r in found
        ]
        screen.table(titles[part], header, rows)
    screen.say(f"commits from a probability of {document.commit:.3f}, sets hold {100 * document.cover:.1f} % of what is named")


def _interval(found: Share | float | None) -> str:
    if found is None or isinstance(found, float):
        return "-" if found is None else f"{found:.3f}"
    return f"{found.k}/{found.n} ({100 * found.low:.0f}-{100 * found.high:.0f} %)"
