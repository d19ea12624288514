"""Diagnose the gap between recorded runs and a simulator: where, which effect, how far, what next."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from sstl_cli.core.errors import SstlError
from sstl_cli.core.runs import Run
from sstl_cli.diagnosis import calibration, channels, downstream, faults, gains, scaling, search, sentence, unmodelled
from sstl_cli.diagnosis.decide import Decision, Rules, decide, jumps_instead
from sstl_cli.diagnosis.fit import first_theta, fit
from sstl_cli.diagnosis.noise import noise_floor
from sstl_cli.diagnosis.records import Problem, prepare
from sstl_cli.diagnosis.simulator import Simulator
from sstl_cli.diagnosis.whitening import identity
from sstl_cli.physics.effect import TRANSITION
from sstl_cli.physics.effects import catalogue, get
from sstl_cli.physics.scenario import Scenario
from sstl_cli.steps.diagnose_document import document


@dataclass(frozen=True)
class DiagnoseOptions:
    """What to compare: a simulator, the candidates, and how many effects may be combined."""

    sim: Scenario | None = None
    effects: tuple[str, ...] | None = None
    exclude: tuple[str, ...] = ()
    max_effects: int = 3
    workers: int = 1
    position: bool = False
    rules: Rules = field(default_factory=Rules)


@dataclass(frozen=True)
class Diagnosis:
    """A finished diagnosis; ``document()`` is its JSON form."""

    problem: Problem
    search: search.Search
    decision: Decision
    recorder: list[faults.RecorderEffect]
    options: DiagnoseOptions
    body: dict[str, Any]

    def document(self) -> dict[str, Any]:
        """Return the diagnosis as laid down in the contract."""
        return self.body

    def model(self) -> Scenario:
        """Return the accepted simulator, effects included, as a scenario."""
        from sstl_cli.physics.scenario import Configuration

        winner = self.decision.winner
        fit = winner.fit if winner is not None and self.body["verdict"]["effects"] else self.search.base
        locations = {r.config: r.location for r in self.problem.records}
        base = self.options.sim or Scenario()
        effects = {**base.effects}
        for effect_id, values in fit.effects.items():
            if effect_id == "line":
                rig = base.rig.model_copy(update={"load_n_per_mm": 1.0 / values["load_mm_per_n"]})
                base = base.model_copy(update={"rig": rig})
            else:
                effects[effect_id] = dict(values)
        for fault in self.recorder:
            effects[fault.id] = get(fault.id).complete({k: v for k, v in fault.parameters.items() if v})
        configurations = tuple(
            Configuration(id=name, location=locations.get(i), theta=float(fit.theta[i]))
            for i, name in enumerate(self.problem.configs)
        )
        return base.model_copy(update={"configurations": configurations, "effects": effects, "generator": None})


def candidates(options: DiagnoseOptions, present: Sequence[str]) -> list[str]:
    """Return the ids of the effects to compare; effects that the simulator already contains are not candidates."""
    ids = [get(e).id for e in options.effects] if options.effects else list(catalogue())
    excluded = {get(e).id for e in options.exclude}
    return [i for i in ids if i not in excluded and i not in present]


def run(runs: Sequence[Run], options: DiagnoseOptions, advance: Callable[[float], None] = lambda _: None) -> Diagnosis:
    """Return the diagnosis of recorded runs.

    Raises
    ------
    SstlError
        If no run can be used.
    """
    unit_n = scaling.unit_of(runs)
    runs = scaling.scaled(runs, unit_n)
    problem = prepare(runs, unit_n)
    wrong = gains.wrong_scales(problem) if _is_candidate("gain_error", options) else []
    if wrong:
        problem = prepare(gains.corrected(runs, wrong), unit_n)
    result = _diagnose(problem, options, advance)
    _add_wrong_scale(result.body, wrong)
    result.body.update(scaling.restore(result.body, unit_n))
    if unit_n == 1.0:
        _add_downstream(result)
    else:
        result.body["notes"].append(f"fitted in units of {unit_n:g} N: the catalogue's ranges are for 3 to 60 N")
    result.body["sentence"] = sentence.sentence(result.body)
    return result


def _is_candidate(effect_id: str, options: DiagnoseOptions) -> bool:
    present = options.sim.effects if options.sim is not None else {}
    return effect_id in candidates(options, list(present))


def _diagnose(problem: Problem, options: DiagnoseOptions, advance: Callable[[float], None]) -> Diagnosis:
    scenario = options.sim or Scenario()
    fixed = {
        e: scaling.values(v, {p.name: p.unit for p in get(e).parameters}, problem.unit_n)
        for e, v in scenario.effects.items()
    }
    ids = candidates(options, list(scenario.effects))
    fitted = [i for i in ids if get(i).fitted and get(i).channel in _shown(problem)]
    by_motion = any(r.slip is not None for r in problem.records)
    if by_motion:
        # which element slips next is known only where a tension drives the line
        fitted = [i for i in fitted if get(i).stage != TRANSITION]
    sim = Simulator(problem, scenario.rig.mechanics(), fixed)
    nominal = np.array([scenario.theta_of(c) for c in problem.configs])
    first = fit(sim, identity(sim.slices(), sim.weight), (), (), first_theta(sim, nominal), np.zeros(0))
    floor = noise_floor(sim, first.theta, first.prediction)
    sim = Simulator(problem, scenario.rig.mechanics(), fixed, floor.push_n)
    found = search.run(
        sim,
        fitted,
        first.theta,
        min(options.max_effects, 3),
        advance,
        options.workers,
        floor.total_n,
        options.rules.partner_share,
    )
    fine = sim.predict_fine(found.base.theta, {})
    recorder = [e for e in faults.recorder_effects(problem.records, fine, max(floor.fine_n, 1e-9)) if e.id in ids]
    decision = decide(found, floor.total_n, options.rules)
    decision = jumps_instead(found, decision, fitted, floor.coloured)
    if not _propagates(problem, floor.output_n):
        why = "the output never leaves its hold: without propagation no effect can show; use a larger stroke"
        decision = replace(decision, status="unknown", winner=None, group=(), confidence=1.0, why=why, evidence="unknown/hold")
    decision = _unlisted(problem, found, decision, floor.white_n)
    body = document(problem, found, decision, recorder, nominal, floor, scenario)
    if by_motion:
        body["notes"].append("driven by the recorded motion: its direction sets the sign of friction, reversals are left out")
    beside = channels.loop_gap(problem.records) if "tension_loop_lag" in ids else None
    if beside is None and options.position:
        beside = channels.position_gap(sim, found.base, ids)
    _add_channel(body, beside)
    return Diagnosis(problem, found, decision, recorder, options, body)


def _unlisted(problem: Problem, found: search.Search, d: Decision, white_n: float) -> Decision:
    """Turn "nothing is missing" into "unknown" where a tone or a change in mid-run is beyond doubt."""
    if d.status != "none":
        return d
    steady = unmodelled.tone(problem.records, found.sim.predict_fine(found.base.theta, {}), white_n)
    between, within = unmodelled.shifts(found.sim, found.whiten, found.base)
    change, where = (between, "between runs") if abs(between.z) >= abs(within.z) else (within, "within a run")
    if steady is not None:
        why = f"the output holds a steady tone of {steady.rms_n * problem.unit_n:.2g} N RMS at {steady.frequency_hz:.3g} Hz (hum?)"
    elif abs(change.z) > unmodelled.LEAST_SHIFT_Z and abs(change.share) > unmodelled.LEAST_SHIFT:
        why = f"theta of one configuration changes by {100 * change.share:.2g} % {where}: did the tube move?"
    else:
        return d
    return replace(d, status="unknown", winner=None, group=(), confidence=1.0, why=why, evidence="unknown/sign")


def _add_wrong_scale(body: dict[str, Any], wrong: Sequence[gains.WrongScale]) -> None:
    """Put a sensor's wrong scale in front: everything else was judged after the output had been divided by it."""
    if not wrong:
        return
    gap, rest = body["gap"], body["verdict"]
    for scale in wrong:
        body["candidates"].insert(0, _scale_row(scale))
    said = ", ".join(f"{s.system} output {s.gain:.3g} times what any friction could make of its input" for s in wrong)
    after = "" if rest["status"] == "none" else f"; once it is put right: {rest['why']}"
    gap.update(
        rmse_base_n=max(s.rmse_n for s in wrong), rmse_retuned_n=max(s.rmse_n for s in wrong),
        rmse_with_effect_n=max(s.rmse_with_n for s in wrong),
    )
    gap["noise_floor_n"] = min(gap["noise_floor_n"] * max(s.gain for s in wrong), gap["rmse_with_effect_n"])
    reducible = gap["rmse_retuned_n"] - gap["noise_floor_n"]
    gap["explained_of_reducible_pct"] = 100.0 * (gap["rmse_retuned_n"] - gap["rmse_with_effect_n"]) / max(reducible, 1e-12)
    gap["shrink_pct"] = 100.0 * (1.0 - gap["rmse_with_effect_n"] / gap["rmse_retuned_n"])
    gap["shrink_ci95_pct"] = [gap["shrink_pct"]] * 2
    gap["held_out"] = False
    body["verdict"] = {
        "status": "identified", "effects": ["gain_error"], "confidence": 0.95, "ambiguity_group": ["gain_error"],
        "evidence": "named/scale", "why": f"{said}: the scale of a sensor is wrong{after}",
    }
    body["notes"].append(body["verdict"]["why"])


def _scale_row(scale: gains.WrongScale) -> dict[str, Any]:
    return {
        "id": "gain_error", "probability": 0.95, "rmse_held_out_n": scale.rmse_with_n,
        "shrink_pct": 100.0 * (1.0 - scale.rmse_with_n / scale.rmse_n), "score": None,
        "parameters": [
            {"name": f"g_{scale.system}", "effect": "gain_error", "unit": "1", "estimate": scale.gain,
             "ci95": [scale.gain, scale.gain], "at_bound": True, "identifiability": "identifiable"}
        ],
        "identifiability": "identifiable",
    }


def _add_channel(body: dict[str, Any], gap: channels.ChannelGap | None) -> None:
    """Add a gap beside the output tension; it is the verdict where the output tension has none."""
    if gap is None:
        return
    shrunk = 100.0 * (1.0 - gap.rmse_with / gap.rmse_base)
    body["beside"] = {
        "channel": gap.channel, "unit": gap.unit, "effects": list(gap.effects), "rmse_base": gap.rmse_base,
        "rmse_with_effect": gap.rmse_with, "shrink_pct": shrunk, "parameters": gap.values,
    }
    what = f"{gap.channel}: {gap.effects[0]} takes its error from {gap.rmse_base:.3g} to {gap.rmse_with:.3g} {gap.unit}"
    body["notes"].append(what)
    if body["verdict"]["status"] != "none":
        return
    status = "identified" if len(gap.effects) == 1 else "ambiguous"
    body["verdict"] = {
        "status": status, "effects": [gap.effects[0]], "confidence": calibration.confidence("named/beside", 0.95),
        "ambiguity_group": list(gap.effects), "why": what, "evidence": "named/beside",
    }
    if gap.unit == "N":
        body["gap"].update(
            rmse_base_n=gap.rmse_base, rmse_retuned_n=gap.rmse_base, rmse_with_effect_n=gap.rmse_with,
            noise_floor_n=min(gap.rmse_with, body["gap"]["noise_floor_n"]), shrink_pct=shrunk,
            shrink_ci95_pct=[shrunk, shrunk], explained_of_reducible_pct=100.0, held_out=False,
        )
    body["candidates"].insert(
        0,
        {
            "id": gap.effects[0], "probability": 0.95, "rmse_held_out_n": gap.rmse_with if gap.unit == "N" else None,
            "shrink_pct": shrunk, "score": None,
            "parameters": [
                {"name": k, "effect": gap.effects[0], "unit": get(gap.effects[0]).parameter(k).unit, "estimate": v,
                 "ci95": [v, v], "at_bound": False, "identifiability": "identifiable"}
                for k, v in gap.values.items()
            ],
            "identifiability": "identifiable",
        },
    )


def _add_downstream(result: Diagnosis) -> None:
    """Add what the named effect is worth to a controller, on the configuration nearest the middle."""
    winner = result.decision.winner
    if winner is None or not result.body["verdict"]["effects"] or winner.ids[0] not in result.body["verdict"]["effects"]:
        return
    theta = winner.fit.theta
    middle = int(np.argsort(theta)[len(theta) // 2])
    name = result.problem.configs[middle]
    try:
        found = downstream.tracking(result.model(), name, float(result.search.base.theta[middle]))
    except SstlError as error:
        result.body["notes"].append(f"downstream: {error.what}")
        return
    result.body["downstream"] = {
        "config_id": name,
        "tracking": [
            {"reference": t.reference, "rmse_without_n": t.rmse_without_n, "rmse_with_n": t.rmse_with_n} for t in found
        ],
    }


def _shown(problem: Problem) -> tuple[str, ...]:
    """Return the channels whose effects the output can show: between tendons only if the others were recorded too."""
    act = [r for r in problem.records if r.system == "act"]
    together = bool(act) and all("neighbour_n" in r.raw.extra for r in act)
    return ("out", "neighbour") if together else ("out",)


def _propagates(problem: Problem, noise_n: float) -> bool:
    """Whether the output of any run moves by clearly more than its noise."""
    spans = [np.ptp(np.convolve(r.y, np.full(9, 1 / 9), mode="valid")) for r in problem.records if len(r) > 20]
    return max(spans, default=0.0) > 8.0 * noise_n


