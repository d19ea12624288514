"""The candidates of a diagnosis as rows of its document: of the output, of the recorder, of the channels beside."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from sstl_cli.core.documents.diagnosis import Beside, Candidate, DiagnosisDocument, Gap, Parameter
from sstl_cli.core.groups import ANALYSED, RECORDED
from sstl_cli.core.numbers import quantity, small
from sstl_cli.diagnosis import scaling
from sstl_cli.diagnosis.channels import ChannelGap
from sstl_cli.diagnosis.compared import Compared
from sstl_cli.diagnosis.faults import RecorderEffect
from sstl_cli.physics.effect import INSTRUMENT
from sstl_cli.physics.effects import get
from sstl_cli.steps.diagnose_given import Given, name

UNTOLD = "no interval is worked out for the channels beside"


def candidates(g: Given, fitted: Sequence[Compared]) -> list[Candidate]:
    """Return those of the output and faults of the recorder, the most probable first."""
    return _ordered([*(_row(c) for c in fitted), *(_recorder_row(g, r) for r in g.recorder)])


def with_beside(g: Given, document: DiagnosisDocument, only: Sequence[ChannelGap]) -> DiagnosisDocument:
    """Return a diagnosis in the units of the recording with what the channels beside the output show; ``only`` they show the last."""
    if not g.beside:
        return document
    own = [_in_recording(x, g.problem.unit_n) for x in only]
    return document.model_copy(
        update={
            "gap": gap_beside(g, document.gap, own),
            "candidates": _ordered([*document.candidates, *(_beside_row(g, x) for x in own)]),
            "beside": _beside(_in_recording(max(g.beside, key=lambda x: x.gain), g.problem.unit_n)),
        }
    )


def _ordered(rows: Sequence[Candidate]) -> list[Candidate]:
    return sorted(rows, key=lambda row: -(row.probability or 0.0))


def _in_recording(x: ChannelGap, unit_n: float) -> ChannelGap:
    """Return what an effect makes of a channel in the units of the recording."""

    def own(error: float) -> float:
        return scaling.parameter(error, x.unit, unit_n)

    values = scaling.in_recording(x.effect, x.values, unit_n)
    return replace(x, values=values, rmse_base=own(x.rmse_base), rmse_with=own(x.rmse_with), noise=own(x.noise))


def _row(c: Compared) -> Candidate:
    w, f = c.model, c.model.fit
    instrument = all(get(i).stage == INSTRUMENT for i in w.ids)
    return Candidate(
        id=name(w.ids),
        probability=c.probability,
        rmse_held_out_n=c.rmse_n,
        shrink_pct=c.fall_pct,
        samples=ANALYSED,
        evidence_nats=w.evidence,
        gain_nats=w.gain,
        discrepancy=f.discrepancy,
        d2=c.d2,
        change=c.change,
        sensor=[x.parameter.name for x in f.hypothesis.strengths] if instrument else None,
        parameters=[
            Parameter(
                name=x.parameter.name,
                effect=x.effect.id,
                unit=x.parameter.unit,
                estimate=float(v),
                ci95=ci,
                why="the data do not hold it" if ci is None else None,
                at_bound=f.at_bound(i),
                identifiability=c.labels[i],
            )
            for i, (x, v, ci) in enumerate(zip(f.free, f.values, c.intervals, strict=True))
        ],
        alternatives=list(c.alternatives) or None,
        identifiability=c.best,
    )


def _recorder_row(g: Given, r: RecorderEffect) -> Candidate:
    return Candidate(
        id=r.id,
        probability=g.verdict.probabilities.get((r.id,), 0.0),
        rmse_held_out_n=None,
        shrink_pct=r.fall_pct,
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
        shrink_pct=gap.fall_pct,
        samples=f"{gap.channel} beside",
        d2=None,
        change=_change(g, gap),
        sensor=gap.channel,
        parameters=_counted(gap.effect, gap.values, UNTOLD),
        identifiability="identifiable",
    )


def _change(g: Given, gap: ChannelGap) -> dict[str, float] | None:
    """Return by how much the parameters of an effect that the simulator contains differ from what it says."""
    there = scaling.in_recording(gap.effect, g.search.sim.fixed.get(gap.effect, {}), g.problem.unit_n)
    return {k: v - there[k] for k, v in gap.values.items()} if there else None


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


def _beside(best: ChannelGap) -> Beside:
    """Return what an effect beside the output does to its channel."""
    return Beside(
        channel=best.channel,
        unit=best.unit,
        effects=[best.effect],
        rmse_base=best.rmse_base,
        rmse_with_effect=best.rmse_with,
        shrink_pct=best.fall_pct,
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
        "shrink_pct": own.fall_pct,
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
