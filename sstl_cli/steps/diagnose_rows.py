"""The candidates of a diagnosis as rows of its document: of the output, of the recorder, of the channels beside."""

from __future__ import annotations

from typing import Any

import numpy as np

from sstl_cli.diagnosis import limit, scaling, shrink
from sstl_cli.diagnosis.evidence import Weighed
from sstl_cli.diagnosis.faults import RecorderEffect
from sstl_cli.diagnosis.fit import Fit
from sstl_cli.physics.effect import INSTRUMENT
from sstl_cli.physics.effects import get
from sstl_cli.steps.diagnose_given import Errors, Given, name

# rivals whose distance from the winner is worked out
RIVALS = 5


def candidates(g: Given, errors: Errors) -> list[dict[str, Any]]:
    """Return single effects, what is named or as probable as they are, and faults of the recorder, the most probable first."""
    ranked = g.search.ranked()

    def probability(w: Weighed) -> float:
        return g.verdict.probabilities.get(tuple(sorted(w.ids)), 0.0)

    near = sorted(ranked, key=lambda w: -probability(w))[: RIVALS + 1]
    named = (g.verdict.effects, *g.verdict.group)
    shown = [w for w in ranked if len(w.ids) == 1 or w in near or w.ids in named or tuple(sorted(w.ids)) in named]
    lead = next((w for w in ranked if w.fit is g.accepted), ranked[0] if ranked else None)
    rows = [_row(g, errors, w, lead if w in near else None) for w in shown]
    rows += [_recorder_row(g, r) for r in g.recorder]
    return sorted(rows, key=lambda row: -float(row["probability"]))


def _row(g: Given, errors: Errors, w: Weighed, lead: Weighed | None) -> dict[str, Any]:
    sim, f = g.search.sim, w.fit
    held = errors.accepted if f is g.accepted else errors.known + g.search.held_out.residual(f)
    intervals = shrink.parameter_intervals(sim, f)
    labels = [shrink.identifiability(f, i, x) for i, x in enumerate(intervals)]
    strengths = [s for s, x in zip(labels, f.free, strict=True) if not x.parameter.shape]
    base = errors.rms(errors.base)
    best = next((s for s in ("identifiable", "weak") if s in strengths), "not_identifiable")
    instrument = all(get(i).stage == INSTRUMENT for i in w.ids)
    return {
        "id": name(w.ids),
        "probability": g.verdict.probabilities.get(tuple(sorted(w.ids)), 0.0),
        "rmse_held_out_n": errors.rms(held),
        "shrink_pct": 100.0 * (1.0 - errors.rms(held) / base) if base > 0.0 else 0.0,
        "evidence_nats": w.evidence,
        "gain_nats": w.gain,
        "discrepancy": f.discrepancy,
        "d2": None if lead is None or lead is w else limit.distance2(sim, lead.fit, f),
        "change": _change(g, f),
        "sensor": [x.parameter.name for x in f.hypothesis.strengths] if instrument else None,
        "parameters": [
            {
                "name": x.parameter.name,
                "effect": x.effect.id,
                "unit": x.parameter.unit,
                "estimate": float(v),
                "ci95": None if ci is None else [ci.low, ci.high],
                "why": "the data do not hold it" if ci is None else None,
                "at_bound": f.at_bound(i),
                "identifiability": labels[i],
            }
            for i, (x, v, ci) in enumerate(zip(f.free, f.values, intervals, strict=True))
        ],
        "identifiability": best,
    }


def _change(g: Given, f: Fit) -> dict[str, float] | None:
    """Return by how much the parameters of effects that the simulator contains differ from what it says, if any do."""
    there = g.search.sim.fixed
    moved = {
        x.parameter.name: scaling.parameter(float(v) - x.parameter.neutral, x.parameter.unit, g.problem.unit_n)
        for x, v in zip(f.free, f.values, strict=True)
        if x.effect.id in there and not x.parameter.shape
    }
    return moved or None


def _recorder_row(g: Given, r: RecorderEffect) -> dict[str, Any]:
    parameters = [
        {
            "name": k,
            "effect": r.id,
            "unit": get(r.id).parameter(k).unit,
            "estimate": v,
            "ci95": None,
            "why": "counted in this record, not estimated",
            "at_bound": False,
            "identifiability": "identifiable",
        }
        for k, v in r.parameters.items()
    ]
    return {
        "id": r.id,
        "probability": g.verdict.probabilities.get((r.id,), 0.0),
        "rmse_held_out_n": None,
        "shrink_pct": 100.0 * (1.0 - np.sqrt(max(1.0 - r.removed_n2 / max(r.total_n2, 1e-300), 0.0))),
        "d2": None,
        "sensor": None,
        "parameters": parameters,
        "identifiability": "identifiable",
    }


def add_beside(g: Given, body: dict[str, Any]) -> None:
    """Add what the channels beside the output show."""
    if not g.beside:
        return
    best = max(g.beside, key=lambda x: x.gain)
    body["beside"] = {
        "channel": best.channel,
        "unit": best.unit,
        "effects": [best.effect],
        "rmse_base": best.rmse_base,
        "rmse_with_effect": best.rmse_with,
        "shrink_pct": 100.0 * (1.0 - best.rmse_with / max(best.rmse_base, 1e-300)),
        "parameters": best.values,
    }
    for gap in g.beside:
        if any(row["id"] == gap.effect for row in body["candidates"]):
            continue
        body["candidates"].append(
            {
                "id": gap.effect,
                "probability": g.verdict.probabilities.get((gap.effect,), 0.0),
                "rmse_held_out_n": gap.rmse_with if gap.unit == "N" else None,
                "shrink_pct": 100.0 * (1.0 - gap.rmse_with / max(gap.rmse_base, 1e-300)),
                "d2": None,
                "sensor": gap.channel,
                "parameters": [
                    {
                        "name": k,
                        "effect": gap.effect,
                        "unit": get(gap.effect).parameter(k).unit,
                        "estimate": v,
                        "ci95": None,
                        "why": "no interval is worked out for the channels beside",
                        "at_bound": False,
                        "identifiability": "identifiable",
                    }
                    for k, v in gap.values.items()
                ],
                "identifiability": "identifiable",
            }
        )
        if (gap.effect,) == g.verdict.effects:
            body["notes"].append(f"the error is that of channel {gap.channel}; where it lies is told of the output")
            body["gap"].update(
                samples=f"channel {gap.channel} ({gap.unit})",
                held_out=False,
                shrink_ci95_pct=None,
                shrink_why="no interval is worked out for the channels beside",
                shrink_pct=100.0 * (1.0 - gap.rmse_with / max(gap.rmse_base, 1e-300)),
                explained_of_reducible_pct=None,
                noise_floor_low_n=None,
                noise_floor_high_n=None,
            )
            if gap.unit == "N":
                body["gap"].update(
                    rmse_base_n=gap.rmse_base, rmse_retuned_n=gap.rmse_base, rmse_with_effect_n=gap.rmse_with, noise_floor_n=gap.noise
                )
    body["candidates"].sort(key=lambda row: -float(row["probability"]))
