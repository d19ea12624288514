"""The JSON form of a diagnosis (CONTRACT: sstl.diagnosis/1)."""

from __future__ import annotations

from typing import Any

import numpy as np

from sstl_cli.diagnosis import calibration, faults, following, search, shrink, where
from sstl_cli.diagnosis.decide import Candidate, Decision
from sstl_cli.diagnosis.evidence import advantage
from sstl_cli.diagnosis.noise import Floor
from sstl_cli.diagnosis.records import Problem
from sstl_cli.diagnosis.simulator import Simulator
from sstl_cli.physics.effects import get
from sstl_cli.physics.scenario import Scenario

SCHEMA = "sstl.diagnosis/1"


def document(
    problem: Problem,
    found: search.Search,
    d: Decision,
    recorder: list[faults.RecorderEffect],
    nominal: np.ndarray,
    noise: Floor,
    scenario: Scenario,
) -> dict[str, Any]:
    """Return the diagnosis as laid down in the contract, but for its sentence; tensions in units of the problem."""
    sim, base, winner = found.sim, d.base, d.winner
    weight = max(float(sim.weight.sum()), 1.0)
    as_given = float(np.sqrt(np.sum(sim.weight * (sim.y - sim.predict(nominal, {})) ** 2) / weight))
    fine_n = float(np.sqrt(max(noise.fine_n**2 - noise.output_n**2, 0.0)))

    def full_rate(rms: float) -> float:
        return float(np.hypot(rms, fine_n))

    named = winner is not None and d.status in ("identified", "ambiguous")
    evidence = d.evidence
    effects = _by_size(found, winner) if named and winner is not None else []
    status, why, confidence = d.status, d.why, d.confidence
    group = [e for ids in d.group for e in ids] if named else []
    if recorder:
        status, why, confidence, effects, group = _with_recorder(recorder, d, effects, group, base, sim)
        evidence = f"{status}/recorder"
    accepted = winner if winner is not None and named and any(e in winner.ids for e in effects) else None
    floor = min(d.noise_n, (accepted or base).rms_n)
    interval = shrink.shrinkage(found, base, accepted or base, fine_n)
    code = where.phases(sim, (accepted or base).fit.prediction)
    retuned, with_effect = full_rate(base.rms_n), full_rate((accepted or base).rms_n)
    if recorder and effects and effects[0] in {r.id for r in recorder}:
        retuned, with_effect, interval = _recorder_gap(problem, sim, found, recorder, with_effect)
    reducible = retuned - full_rate(floor)
    body: dict[str, Any] = {
        "schema": SCHEMA,
        "verdict": {
            "status": status,
            "effects": effects,
            "confidence": calibration.confidence(evidence, confidence),
            "ambiguity_group": list(dict.fromkeys([*effects, *group])),
            "why": why,
            "evidence": evidence,
        },
        "gap": {
            "rmse_base_n": max(full_rate(as_given), retuned),
            "rmse_retuned_n": retuned,
            "rmse_with_effect_n": with_effect,
            "noise_floor_n": full_rate(floor),
            "shrink_pct": interval.estimate,
            "shrink_ci95_pct": [interval.low, interval.high],
            "explained_of_reducible_pct": float(np.clip(100.0 * (retuned - with_effect) / reducible, 0, 100))
            if reducible > 1e-12
            else 0.0,
            "held_out": d.folds.honest,
            "held_out_kind": d.folds.kind,
            "worse_regions": shrink.worse_regions(found, base, accepted, code) if accepted else [],
            "parameters_stable": shrink.stable(found, d) if accepted else True,
        },
        "where": where.shares(sim, base.raw, code),
        "where_bands": where.bands(sim, base.raw),
        "candidates": _candidates(found, d, base, fine_n, recorder),
        "next_experiment": None,
        "base_score": base.score,
        "base_behind_nats": 0.0 if _best(d) is base else advantage(_best(d), base),
        "analysis": {
            "rate_hz": problem.analysis_hz,
            "samples": sum(len(r.raw) for r in problem.records),
            "runs": len(problem.records),
            "set_aside": problem.set_aside,
            "theta": dict(zip(problem.configs, found.base.theta.tolist(), strict=True)),
        },
        "baselines": _baselines(found, d),
        "notes": _notes(problem, d),
    }
    ids, cosine = following.isolability(found)
    body["isolability"] = {"ids": ids, "cosine": cosine}
    body["loops"] = _loops(sim, found, accepted)
    _add_next(body, found, d, scenario)
    return body


def _by_size(found: search.Search, winner: Candidate) -> list[str]:
    """Return the winner's effects, the one whose removal costs most first."""
    if len(winner.ids) == 1:
        return list(winner.ids)
    fit = winner.fit

    def loss(effect_id: str) -> float:
        without = {k: v for k, v in fit.effects.items() if k != effect_id}
        return float(np.sum((fit.prediction - found.sim.predict(fit.theta, without)) ** 2))

    return sorted(winner.ids, key=lambda e: -loss(e))


def _with_recorder(
    recorder: list[faults.RecorderEffect],
    d: Decision,
    effects: list[str],
    group: list[str],
    base: Candidate,
    sim: Simulator,
) -> tuple[str, str, float, list[str], list[str]]:
    """Merge recorder faults into the verdict: found on raw samples, they come before any fitted effect."""
    ids = [r.id for r in recorder]
    why = "; ".join(f"{r.id} carries {100 * r.share:.0f} % of the squared error beyond the noise" for r in recorder)
    rounding = [r for r in recorder if r.id == "quantisation"]
    if rounding and effects:
        removed = base.rms_n**2 - (d.winner.rms_n**2 if d.winner else base.rms_n**2)
        power = rounding[0].removed_n2 / max(sum(len(r.raw) for r in sim.problem.records), 1)
        # rounding errors are no noise: what a fitted effect takes out of them is not its own
        if removed < 2.0 * power:
            effects, group = [], []
    if d.status in ("none", "unknown") or not effects:
        # faults are facts: beside nothing else they are the answer, beside a gap of unknown cause only if they carry it
        if d.status != "unknown" or sum(r.share for r in recorder) > 0.5:
            return "identified", why, 0.95, ids, []
        return "unknown", f"{why}; {d.why}", 0.5, [], []
    if max(r.share for r in recorder) > 0.8:
        return "identified", why, 0.95, ids, []
    return d.status, f"{why}; {d.why}", d.confidence, [*ids, *effects], group


def _recorder_gap(
    problem: Problem, sim: Simulator, found: search.Search, recorder: list[faults.RecorderEffect], with_effect: float
) -> tuple[float, float, shrink.Interval]:
    """Return errors before and after the faulty samples are taken out, and their shrinkage."""
    before, after = [], []
    for r, prediction in zip(problem.records, sim.predict_fine(found.base.theta, {}), strict=True):
        thin = max(1, len(r.raw) // max(len(prediction), 1))
        expected = np.repeat(prediction, thin)
        error2 = (r.raw.tension_out_n[: len(expected)] - expected) ** 2
        keep = r.raw_weight[: len(expected)] > 0
        before.append(error2)
        after.append(error2[keep])
    raw = float(np.sqrt(np.mean(np.concatenate(before))))
    clean = float(np.sqrt(np.mean(np.concatenate(after)))) if any(len(a) for a in after) else raw
    if {r.id for r in recorder} == {"quantisation"}:
        removed = sum(r.removed_n2 for r in recorder) / max(sum(len(b) for b in before), 1)
        clean = float(np.sqrt(max(raw**2 - removed, (0.1 * raw) ** 2)))
    percent = 100.0 * (1.0 - min(clean, with_effect if with_effect > 0 else clean) / raw) if raw > 0 else 0.0
    ratios = np.array(
        [np.sqrt(a.mean() / b.mean()) for a, b in zip(after, before, strict=True) if len(a) and b.mean() > 0]
    )
    spread = 196.0 * float(ratios.std()) / np.sqrt(max(len(ratios), 1)) if len(ratios) > 1 else 5.0
    return raw, min(clean, raw), shrink.Interval(percent, percent - spread, min(percent + spread, 100.0))


def _candidates(
    found: search.Search, d: Decision, base: Candidate, fine_n: float, recorder: list[faults.RecorderEffect]
) -> list[dict[str, Any]]:
    rows = []
    best = _best(d)
    shown = {c.ids for c in d.candidates if len(c.ids) == 1} | ({d.winner.ids} if d.winner else set())
    for c in d.candidates:
        if c.ids not in shown:
            continue
        intervals = shrink.parameter_intervals(found, c)
        labels = [shrink.identifiability(c, i, x) for i, x in enumerate(intervals)]
        strengths = [s for s, f in zip(labels, c.fit.free, strict=True) if not f.parameter.shape]
        rows.append(
            {
                "id": "+".join(c.ids),
                "probability": d.probability.get(c.ids, 0.0),
                "rmse_held_out_n": float(np.hypot(c.rms_n, fine_n)),
                "shrink_pct": shrink.shrinkage(found, base, c, fine_n).estimate,
                "score": c.score,
                "behind_nats": 0.0 if c is best else advantage(best, c),
                "parameters": [
                    {
                        "name": f.parameter.name,
                        "effect": f.effect.id,
                        "unit": f.parameter.unit,
                        "estimate": x.estimate,
                        "ci95": [x.low, x.high],
                        "at_bound": c.fit.at_bound(i),
                        "identifiability": labels[i],
                    }
                    for i, (f, x) in enumerate(zip(c.fit.free, intervals, strict=True))
                ],
                "identifiability": "identifiable"
                if "identifiable" in strengths
                else ("weak" if "weak" in strengths else "not_identifiable"),
            }
        )
    for r in recorder:
        rows.insert(
            0,
            {
                "id": r.id,
                "probability": r.share,
                "rmse_held_out_n": None,
                "shrink_pct": 100.0 * (1.0 - np.sqrt(max(1.0 - r.share, 0.0))),
                "score": None,
                "parameters": [
                    {
                        "name": k,
                        "effect": r.id,
                        "unit": get(r.id).parameter(k).unit,
                        "estimate": v,
                        "ci95": [v, v],
                        "at_bound": False,
                        "identifiability": "identifiable",
                    }
                    for k, v in r.parameters.items()
                ],
                "identifiability": "identifiable",
            },
        )
    return sorted(rows, key=lambda row: -float(row["probability"]))


def _best(d: Decision) -> Candidate:
    """Return the base or the single candidate with the best held-out score."""
    return max([d.base, *(c for c in d.candidates if len(c.ids) == 1)], key=lambda c: c.score)


def _baselines(found: search.Search, d: Decision) -> dict[str, Any]:
    """Return what simpler rules would have answered, for comparison in the blind check."""
    singles = [c for c in d.candidates if len(c.ids) == 1]
    if not singles:
        return {"smallest_rmse": None, "iid_bic": None}
    w = found.sim.weight
    n = max(float(w.sum()), 2.0)

    def bic(residual: np.ndarray, k: int) -> float:
        return n * float(np.log(np.sum(w * residual**2) / n)) + k * float(np.log(n))

    scores = {c.ids[0]: bic(c.fit.residual, len(c.fit.free)) for c in singles}
    best = min(scores, key=lambda k: scores[k])
    return {
        "smallest_rmse": min(singles, key=lambda c: c.rms_n).ids[0],
        "iid_bic": best if scores[best] < bic(d.base.fit.residual, 0) else None,
    }


def _notes(problem: Problem, d: Decision) -> list[str]:
    notes = []
    if not d.folds.honest:
        notes.append(f"held out: {d.folds.kind}; repeats of one excitation protect little against a wrong name")
    if len(problem.configs) == 1:
        notes.append("one configuration: offsets, constant and terminal friction cannot be told apart by their spread")
    if len(problem.systems) == 1:
        notes.append(f"only {problem.systems[0]} was recorded: effects of the other system cannot show")
    if problem.set_aside:
        notes.append(f"{len(problem.set_aside)} runs set aside")
    return notes


def _loops(sim: Simulator, found: search.Search, accepted: Candidate | None) -> list[dict[str, Any]]:
    """Return a few measured loops with the simulated ones before and after, thinned for drawing."""
    loops = []
    seen: set[str] = set()
    for r, s in zip(sim.problem.records, sim.slices(), strict=True):
        if r.system in seen:
            continue
        seen.add(r.system)
        step = max(1, len(r) // 600)
        u = r.u.reshape(-1, r.factor).mean(axis=1)
        loops.append(
            {
                "run_id": r.run_id,
                "system": r.system,
                "tension_in_n": u[::step],
                "measured_n": r.y[::step],
                "base_n": found.base.prediction[s][::step],
                "with_effect_n": (accepted.fit if accepted else found.base).prediction[s][::step],
            }
        )
    return loops


def _add_next(document: dict[str, Any], found: search.Search, d: Decision, scenario: Scenario) -> None:
    """Propose the movement that separates the winner from its nearest rival (or the two leading candidates)."""
    singles = [c.ids for c in d.candidates if len(c.ids) == 1]
    first = d.winner.ids if d.winner is not None else (singles[0] if singles else ())
    rivals = [g for g in d.group if g != first] or [i for i in singles if i != first and not set(i) & set(first)]
    if not first or not rivals:
        return
    experiment = following.best_experiment(found, first, rivals[0], scenario.rig.mechanics())
    if experiment is None:
        return
    unit_n = found.sim.problem.unit_n
    document["next_experiment"] = {
        "separates": list(experiment.separates),
        "trajectory": experiment.trajectory.name,
        "why": (
            f"refitted, the two differ by {experiment.distance_n * unit_n:.3g} N RMS on it, "
            f"by {experiment.here_n * unit_n:.3g} N on this data"
            + ("" if unit_n == 1.0 else f"; its tensions are to be taken times {unit_n:g}")
        ),
        "scenario": following.scenario_of(found, experiment.trajectory).model_dump(
            mode="json", by_alias=True, exclude_defaults=False
        ),
    }
