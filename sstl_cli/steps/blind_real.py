"""Take terms out of the accepted model of real recordings, one at a time, and diagnose them back."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from sstl_cli.blind import accepted
from sstl_cli.blind.retune import Pair, gap_n, play
from sstl_cli.blind.strength import direction, find_scale
from sstl_cli.core.documents.blind_real import BlindRealDocument, Trial
from sstl_cli.core.documents.diagnosis import DiagnosisDocument
from sstl_cli.core.errors import SstlError, UsageError
from sstl_cli.core.groups import spelled_out
from sstl_cli.core.rng import stream
from sstl_cli.core.runs import Run
from sstl_cli.physics.effects import get
from sstl_cli.physics.scenario import Scenario
from sstl_cli.steps.blind_run import Diagnoser, diagnose

# terms put into a model that accepted none, so that there is something to take out
PLANTED = ("zero_offset", "asymmetric_friction", "channel_delay")
STRENGTH = 2.0


def run(
    runs: Sequence[Run],
    model: Scenario | None = None,
    plant: Sequence[str] | None = None,
    strength: float = STRENGTH,
    seed: int = 0,
    diagnoser: Diagnoser = diagnose,
    advance: Callable[[float], None] = lambda _: None,
) -> BlindRealDocument:
    """Return what was taken out of the accepted model, and what the diagnosis says then.

    Parameters
    ----------
    model : Scenario, optional
        The accepted model; by default the one that diagnosing the recordings gives.
    plant : sequence of str, optional
        Effects to add to the model first; by default a few where it holds none.
    strength : float
        Size of planted effects: RMS gap over the RMS of the model's own residuals.

    Raises
    ------
    SstlError
        If no run can be used or the model has no term that a recording of tensions can show.
    """
    runs = list(runs)
    first = None
    if model is None:
        first, model = diagnoser(runs, Scenario(), ())[:2]
        advance(1)
        if model is None:
            raise SstlError("the diagnosis gave no model", fix="give one with --model", code="E957")
    terms = accepted.audible(model)
    residual = accepted.rms_n(model, runs)
    wanted = list(plant) if plant is not None else ([] if terms else list(PLANTED))
    planted = {e: _planted(model, e, runs, strength * residual, seed) for e in _plantable(wanted) if e not in terms}
    trials = [*(("accepted", e, model) for e in terms), *(("planted", e, full) for e, full in planted.items())]
    if not trials:
        raise SstlError("no term to take out", fix="name effects with --plant", code="E957")
    rows = [_null(model, runs, seed, diagnoser)]
    advance(1)
    for origin, effect_id, full in trials:
        rows.append(_trial(origin, effect_id, full, model, runs, seed, diagnoser))
        advance(1)
    held = [r for r in rows if r.taken_out is not None]
    return BlindRealDocument(
        schema="sstl.blind.real/1",
        runs=len(runs),
        samples=sum(len(r) for r in runs),
        accepted={k: dict(v) for k, v in terms.items()},
        verdict=None if first is None else first.verdict,
        residual_rms_n=residual,
        trials=rows,
        named=sum(r.named for r in held),
        in_group=sum(r.in_group for r in held),
        wrong=sum(r.wrong for r in held),
        of=len(held),
        false_alarm=rows[0].status != "none",
        inputs={},
    )


def _plantable(wanted: Sequence[str]) -> list[str]:
    """Return the effects that are asked for; UsageError where one does not act on the output that a model predicts."""
    for effect_id in wanted:
        effect = get(effect_id)
        if not effect.fitted or effect.channel != "out":
            raise UsageError(f"{effect_id} does not act on a predicted output tension", where="--plant", code="E957")
    return list(wanted)


def _null(model: Scenario, runs: Sequence[Run], seed: int, diagnoser: Diagnoser) -> Trial:
    """Diagnose recordings that the accepted model itself made: nothing is missing."""
    return _row("accepted", None, diagnoser(accepted.remade(model, model, runs, seed), model, ())[0])


def _trial(origin: str, effect_id: str, full: Scenario, model: Scenario, runs: Sequence[Run], seed: int, diagnoser: Diagnoser) -> Trial:
    made = accepted.remade(full, model, runs, seed)
    without = full.model_copy(update={"effects": {k: v for k, v in full.effects.items() if k != effect_id}})
    return _row(origin, effect_id, diagnoser(made, without, ())[0]).model_copy(update={"values": dict(full.effects[effect_id])})


def _row(origin: str, effect_id: str | None, document: DiagnosisDocument) -> Trial:
    verdict = document.verdict
    effects, group = list(verdict.effects), list(spelled_out(verdict.ambiguity_group, verdict.members))
    committed = verdict.status == "identified"
    return Trial(
        origin=origin,
        taken_out=effect_id,
        status=verdict.status,
        effects=effects,
        ambiguity_group=group,
        confidence=verdict.confidence,
        shrink_pct=document.gap.shrink_pct,
        named=committed and effects == [effect_id],
        in_group=effect_id is not None and effect_id in {*effects, *group},
        wrong=committed and any(e != effect_id for e in effects),
    )


def _planted(model: Scenario, effect_id: str, runs: Sequence[Run], target_n: float, seed: int) -> Scenario:
    """Return the model with one more effect, of a size that leaves the wanted gap (N) once theta is re-tuned."""
    base = accepted.predictions(model, runs)
    tops = [float(np.max(x)) for x in zip(*((r.u.max(), y.max()) for r, y in base), strict=True)]
    way = direction(effect_id, stream(seed, "plant", effect_id), *tops)
    bounds = {p.name: (p.low, p.high) for p in get(effect_id).parameters}
    systems = {r.system for r, _ in base}
    found = {r.config: model.theta_of(r.raw.config_id) for r, _ in base}
    theta = [found[c] for c in sorted(found)]
    values = {k: v for k, v in way.full.items() if _shows(k, systems)}
    if not values:
        # drawn for the other system: give this one the same share of its range
        other = next(iter(systems))
        values = {k.replace("sstl" if other == "act" else "act", other): v for k, v in way.full.items()}
    way = type(way)(way.id, values, way.shapes)

    def full(scale: float) -> Scenario:
        at = {k: float(np.clip(v, *bounds[k])) for k, v in way.at(scale).items()}
        return model.model_copy(update={"effects": {**model.effects, effect_id: at}})

    def gap(scale: float) -> float:
        # what a re-tuned theta cannot follow, on the difference that the effect makes to the model
        pairs = []
        for (r, y), (_, more) in zip(base, accepted.predictions(full(scale), runs, model), strict=True):
            factor = float(np.exp(passes(r.system) * theta[r.config]))
            usual = play(r.u, 1.0 / factor, factor, r.start_n)
            pairs.append(Pair(r.config, passes(r.system), r.u, usual + more - y))
        return gap_n(pairs, theta)[0]

    scale, _ = find_scale(gap, target_n)
    return full(scale)


def passes(system: str) -> int:
    """Return how often the tendon runs through the tube."""
    return 2 if system == "sstl" else 1


def _shows(parameter: str, systems: set[str]) -> bool:
    return all(s in systems for s in ("act", "sstl") if f"_{s}" in parameter)
