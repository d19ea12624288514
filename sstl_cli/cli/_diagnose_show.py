"""How a diagnosis looks on a terminal below its sentence: candidates, what to record next, stages of a controller."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from sstl_cli.cli.render import Screen
from sstl_cli.core.groups import of_samples
from sstl_cli.core.numbers import quantity, small

if TYPE_CHECKING:
    from sstl_cli.core.documents.control import StagesDocument
    from sstl_cli.core.documents.diagnosis import DiagnosisDocument, Parameter, PlanDocument

SHOWN = 6
PARAMETERS = 3
# within this of 1 the difference is what a factor says
NEAR = 0.1


def answer(screen: Screen, document: DiagnosisDocument) -> None:
    """Print the sentence, then the gap in numbers, where it lies, and what a change would be worth or would have shown."""
    from sstl_cli.diagnosis.sentence import lines
    from sstl_cli.steps.diagnose_tendons import lines as tendons

    screen.say(document.sentence or document.verdict.why)
    for line in [*lines(document), *tendons(document)]:
        screen.say(line)
    for remark in document.remarks or ():
        screen.say(f"Physics ({remark.rule}): {remark.sentence}. Mend: {remark.mend}")


def diagnosis(screen: Screen, document: DiagnosisDocument) -> None:
    """Print the sentence, what bears on it, what physics says of the recording, and the tables."""
    answer(screen, document)
    tables(screen, document)


def aside(document: DiagnosisDocument, own_odds: bool = False) -> list[str]:
    """Return what was set aside: runs, and all that could not be judged, as where nothing propagates.

    Under a user's ``own_odds`` no verdict has a confidence; without them only what could not be judged has none.
    """
    runs = document.analysis.set_aside if document.analysis else {}
    verdicts = [(f"tendon {b.tendon or '(no name)'}", b.verdict) for b in document.tendons or ()] or [("all runs", document.verdict)]
    unjudged = [(whose, v.why) for whose, v in verdicts if v.status == "unknown" and v.confidence is None and not own_odds]
    # of a tendon that could not be diagnosed every run says so
    said = [f"{whose}: {why}" for whose, why in unjudged if why not in runs.values()]
    return [*(f"run {run_id}: {reason}" for run_id, reason in runs.items()), *said]


def tables(screen: Screen, document: DiagnosisDocument) -> None:
    """Print the candidates (none where nothing is missing) and the recording that would tell the first two apart."""
    unit = document.unit or "N"
    if document.verdict.status != "none":
        rows = [
            (c.id, small(c.probability), c.rmse_held_out_n, c.shrink_pct, _parameters(c.parameters)) for c in document.candidates[:SHOWN]
        ]
        screen.table("candidates", ("effect", "p", f"RMSE {unit}", "shrink %", "parameters"), rows)
        # numbers of different samples do not compare
        for samples, ids in sorted(of_samples(document.candidates[:SHOWN]), key=lambda found: len(found[1]))[:-1]:
            screen.line(f"RMSE and shrink of {', '.join(ids)} are of other samples: {samples}")
        if len(document.candidates) > SHOWN:
            screen.line(f"and {len(document.candidates) - SHOWN} more; --json has all")
    following = document.next_experiment
    if following and document.verdict.status != "none":
        apart = " from ".join(following.separates)
        if following.settles is False:
            most = f" (most by a {following.trajectory})" if round(following.d2 or 0.0, 1) > 0.0 else ""
            screen.say(f"to tell {apart}: {following.why}{most}")
        else:
            screen.say(f"record next: {following.trajectory}, to tell {apart}; {following.why}")


def plan(screen: Screen, document: PlanDocument) -> None:
    """Say what a movement could tell, then how small a gap of each effect would show."""
    screen.say(document.sentence)
    rows = [
        (
            r.effect, f"{r.parameter} {quantity(r.least_size, r.unit)}", f"{r.gap_n:.2g}", "yes" if r.shows else "no",
            "-" if r.told_size is None else f"{r.told_size:.2g}", r.rival or "-",
        )
        for r in document.effects
    ]  # fmt: skip
    header = ("effect", "would show from", "gap N", "in range", "told from", "its rival")
    screen.table(f"what this movement could tell (its rival apart: D^2 of {document.decidable_d2:.0f})", header, rows, most=40)
    for run_id, reason in document.set_aside.items():
        screen.note(f"set aside: run {run_id}: {reason}")


def stages(screen: Screen, document: StagesDocument) -> None:
    """Say which stage of the controller makes most of the error, then the shares of every stream."""
    names = list(document.streams[0].share_pct)
    worst = max(document.streams, key=lambda s: s.rmse_n)
    stage = max(names, key=lambda n: worst.share_pct[n])
    screen.say(
        f"Most of the largest tracking error ({worst.run_id}, {worst.rmse_n:.2g} N) comes from the {stage}: {worst.share_pct[stage]:.0f} %."
    )
    rows = [(s.run_id, small(s.rmse_n), *(round(s.share_pct[n], 1) + 0.0 for n in names)) for s in document.streams]
    against = (
        "A share below 0 cancels a part of the others."
        if any(round(v, 1) < 0 for s in document.streams for v in s.share_pct.values())
        else ""
    )
    screen.table("share of the squared tracking error by stage / %", ("stream", "RMSE N", *names), rows, against, most=20)


def _parameters(found: Sequence[Parameter]) -> str:
    """Return the first parameters as text; a dimensionless one has no unit."""
    shown = [f"{p.name} {_decimal(p.estimate)}" + ("" if p.unit == "1" else f" {p.unit}") for p in found[:PARAMETERS]]
    return ", ".join(shown) + (", ..." if len(found) > PARAMETERS else "")


def _decimal(value: float | None) -> str:
    """Return three digits, of a factor near 1 those by which it differs, or six places of what is next to nothing (no exponent)."""
    if value is None:
        return "-"
    if 0.0 < abs(value - 1.0) < NEAR:
        return f"{value:.4f}"
    return f"{value:.3g}" if abs(value) >= 1e-3 else f"{value:.6f}".rstrip("0").rstrip(".")
