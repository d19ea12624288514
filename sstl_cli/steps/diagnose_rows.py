"""The candidates of a diagnosis as rows of its document: of the output, of the recorder, of the channels beside."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from sstl_cli.core.documents.diagnosis import Beside, Candidate, Gap, Parameter
from sstl_cli.core.groups import ANALYSED, RECORDED
from sstl_cli.core.numbers import quantity, small
from sstl_cli.diagnosis import limit, scaling, shrink
from sstl_cli.diagnosis.channels import ChannelGap
from sstl_cli.diagnosis.evidence import Weighed
from sstl_cli.diagnosis.faults import RecorderEffect
from sstl_cli.diagnosis.fit import Fit
from sstl_cli.physics.effect import INSTRUMENT
from sstl_cli.physics.effects import get
from sstl_cli.steps.diagnose_given import Errors, Given, name

# rivals whose distance from the winner is worked out
RIVALS = 5
UNTOLD = "no interval is worked out for the channels beside"


def fitted(g: Given, errors: Errors) -> list[Candidate]:
    """Return single effects, the most probable and the most evident combinations, what is named, and faults of the recorder; the most probable first."""
    ranked = g.search.ranked()

    def probability(w: Weighed) -> float:
        return g.verdict.probabilities.get(tuple(sorted(w.ids)), 0.0)

    near = sorted(ranked, key=lambda w: -probability(w))[: RIVALS + 1]
    named = (g.verdict.effects, *g.verdict.group)
    # what has the evidence and is not believed is shown as well: whoever reads the table may know better
    shown = [w for w in ranked if len(w.ids) == 1 or w in near or w in ranked[:RIVALS] or w.ids in named or tuple(sorted(w.ids)) in named]
    lead = next((w for w in ranked if w.fit is g.accepted), ranked[0] if ranked else None)
    rows = [_row(g, errors, w, lead if w in near else None) for w in shown]
    return sorted([*rows, *(_recorder_row(g, r) for r in g.recorder)], key=_improbable)


def only_beside(g: Given, rows: Sequence[Candidate]) -> list[ChannelGap]:
    """Return what the channels beside the output show and no other candidate does, one an effect."""
    found: dict[str, ChannelGap] = {}
    for gap in g.beside:
        found.setdefault(gap.effect, gap)
    return [gap for effect, gap in found.items() if all(row.id != effect for row in rows)]


def candidates(g: Given, rows: Sequence[Candidate], only: Sequence[ChannelGap]) -> list[Candidate]:
    """Return all candidates, the most probable first."""
    return sorted([*rows, *(_beside_row(g, gap) for gap in only)], key=_improbable)


def _improbable(row: Candidate) -> float:
    return -(row.probability or 0.0)


def _row(g: Given, errors: Errors, w: Weighed, lead: Weighed | None) -> Candidate:
    sim, f = g.search.sim, w.fit
    held = errors.accepted if f is g.accepted else errors.known + g.search.held_out.residual(f)
    intervals = shrink.parameter_intervals(sim, f)
    labels = [shrink.identifiability(f, i, x) for i, x in enumerate(intervals)]
    strengths = [s for s, x in zip(labels, f.free, strict=True) if not x.parameter.shape]
    base = errors.rms(errors.base)
    best = next((s for s in ("identifiable", "weak") if s in strengths), "not_identifiable")
    instrument = all(get(i).stage == INSTRUMENT for i in w.ids)
    return Candidate(
        id=name(w.ids),
        probability=g.verdict.probabilities.get(tuple(sorted(w.ids)), 0.0),
        rmse_held_out_n=errors.rms(held),
        shrink_pct=100.0 * (1.0 - errors.rms(held) / base) if base > 0.0 else 0.0,
        samples=ANALYSED,
        evidence_nats=w.evidence,
        gain_nats=w.gain,
        discrepancy=f.discrepancy,
        d2=None if lead is None or lead is w else limit.distance2(sim, lead.fit, f),
        change=_change(g, f),
        sensor=[x.parameter.name for x in f.hypothesis.strengths] if instrument else None,
        parameters=[
            Parameter(
                name=x.parameter.name,
                effect=x.effect.id,
                unit=x.parameter.unit,
                estimate=float(v),
                # a strength that cannot be negative is not there at the least
                ci95=None if ci is None else (max(ci.low, x.parameter.least), min(ci.high, x.parameter.most)),
                why="the data do not hold it" if ci is None else None,
                at_bound=f.at_bound(i),
                identifiability=labels[i],
            )
            for i, (x, v, ci) in enumerate(zip(f.free, f.values, intervals, strict=True))
        ],
        identifiability=best,
    )


def _change(g: Given, f: Fit) -> dict[str, float] | None:
    """Return by how much the parameters of effects that the simulator contains differ from what it says, if any do."""
    there = g.search.sim.fixed
    moved = {
        x.parameter.name: scaling.parameter(float(v) - x.parameter.neutral, x.parameter.unit, g.problem.unit_n)
        for x, v in zip(f.free, f.values, strict=True)
        if x.effect.id in there and not x.parameter.shape
    }
    return moved or None


def _recorder_row(g: Given, r: RecorderEffect) -> Candidate:
    return Candidate(
        id=r.id,
        probability=g.verdict.probabilities.get((r.id,), 0.0),
        rmse_held_out_n=None,
        shrink_pct=100.0 * (1.0 - float(np.sqrt(max(1.0 - r.removed_n2 / max(r.total_n2, 1e-300), 0.0)))),
        samples=RECORDED,
        d2=None,
        sensor=None,
        parameters=_counted(r.id, r.parameters, "counted in this record, not estimated"),
        identifiability="identifiable",
    )


def _beside_row(g: Given, gap: ChannelGap) -> Candidate:
    return Candidate(
        id=gap.effect,
        probability=g.verdict.probabilities.get((gap.effect,), 0.0),
        rmse_held_out_n=gap.rmse_with if gap.unit == "N" else None,
        shrink_pct=_fall_pct(gap),
        samples=f"{gap.channel} beside",
        d2=None,
        sensor=gap.channel,
        parameters=_counted(gap.effect, gap.values, UNTOLD),
        identifiability="identifiable",
    )


def _counted(effect_id: str, values: Mapping[str, float], why: str) -> list[Parameter]:
    """Return parameters that have no interval, and why."""
    return [
        Parameter(
            name=k,
            effect=effect_id,
            unit=get(effect_id).parameter(k).unit,
            estimate=v,
            ci95=None,
            why=why,
            at_bound=False,
            identifiability="identifiable",
        )
        for k, v in values.items()
    ]


def _fall_pct(gap: ChannelGap) -> float:
    return 100.0 * (1.0 - gap.rmse_with / max(gap.rmse_base, 1e-300))


def beside(g: Given) -> Beside | None:
    """Return what the likeliest effect beside the output does to its channel, where there is any."""
    if not g.beside:
        return None
    best = max(g.beside, key=lambda x: x.gain)
    return Beside(
        channel=best.channel,
        unit=best.unit,
        effects=[best.effect],
        rmse_base=best.rmse_base,
        rmse_with_effect=best.rmse_with,
        shrink_pct=_fall_pct(best),
        parameters=best.values,
    )


def _told_beside(g: Given, only: Sequence[ChannelGap]) -> ChannelGap | None:
    return next((x for x in only if (x.effect,) == g.verdict.effects), None)


def notes_beside(g: Given, only: Sequence[ChannelGap]) -> list[str]:
    """Return what to know of a verdict on what only a channel beside the output shows."""
    own = _told_beside(g, only)
    if own is None:
        return []
    if own.unit == "N":
        return [f"the error is that of channel {own.channel}; where it lies is told of the output"]
    before, after = quantity(small(own.rmse_base), own.unit), quantity(small(own.rmse_with), own.unit)
    return [
        f"the error of channel {own.channel} falls from {before} to {after}; errors in newtons are of the output, which the effect does not change"
    ]


def gap_beside(g: Given, gap: Gap, only: Sequence[ChannelGap]) -> Gap:
    """Return the gap in numbers: of the channel beside the output where the verdict is about what only that shows.

    One that is no tension falls by its own percentage; errors of it are no newtons and stand in ``beside``.
    """
    own = _told_beside(g, only)
    if own is None:
        return gap
    changed: dict[str, object] = {
        "samples": f"channel {own.channel} ({own.unit})",
        "held_out": False,
        "shrink_ci95_pct": None,
        "shrink_why": UNTOLD,
        "shrink_pct": _fall_pct(own),
        "explained_of_reducible_pct": None,
        "noise_floor_low_n": None,
        "noise_floor_high_n": None,
    }
    if own.unit == "N":
        changed |= {
            "rmse_base_n": own.rmse_base,
            "rmse_retuned_n": own.rmse_base,
            "rmse_with_effect_n": own.rmse_with,
            "noise_floor_n": own.noise,
        }
    return gap.model_copy(update=changed)
