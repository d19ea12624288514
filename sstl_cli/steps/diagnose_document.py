"""The JSON form of a diagnosis (CONTRACT: sstl.diagnosis/1)."""

from __future__ import annotations

from dataclasses import asdict, replace

import numpy as np

from sstl_cli import __version__
from sstl_cli.core.documents.diagnosis import (
    Analysis,
    Cosines,
    DiagnosisDocument,
    Estimated,
    EstimatedInput,
    EstimatedOutput,
    Gap,
    LeastShown,
    LeftOver,
    NextExperiment,
    OutputScale,
    Simple,
    Verdict,
)
from sstl_cli.core.documents.quantity import Quantity
from sstl_cli.core.groups import ANALYSED, RECORDED, below
from sstl_cli.diagnosis import bends, by_run, following, gap, limit, planning, reasons, recorded, scaling, sentence, simple, where
from sstl_cli.diagnosis.adjusted import NONE
from sstl_cli.diagnosis.compared import compared, only_beside
from sstl_cli.diagnosis.constants import DECIDABLE
from sstl_cli.diagnosis.faults import RecorderEffect
from sstl_cli.diagnosis.floor import above_noise, log_interval
from sstl_cli.diagnosis.gathering import Evidence
from sstl_cli.diagnosis.judged import by_size
from sstl_cli.diagnosis.noise import of_readings
from sstl_cli.diagnosis.verdict import NOTHING, UNDECIDED
from sstl_cli.steps import diagnose_drawn as drawn
from sstl_cli.steps import diagnose_notes as notes
from sstl_cli.steps import diagnose_rows as rows
from sstl_cli.steps.diagnose_given import Given, name


def document(g: Given) -> DiagnosisDocument:
    """Return the diagnosis as laid down in the contract, tensions in the units of the recording."""
    g = replace(g, recorder=tuple(above_noise(g, r) for r in g.recorder))
    sim, errors = g.search.sim, gap.errors(g)
    code = where.phases(sim, g.accepted.prediction)
    sizes = gap.sizes(g, errors, code)
    ids, cosine = following.isolability(g.search)
    fitted = compared(g, errors)
    only = only_beside(g.beside, {*(name(c.model.ids) for c in fitted), *(r.id for r in g.recorder)})
    found = DiagnosisDocument(
        schema="sstl.diagnosis/1",
        package_version=__version__,
        verdict=_verdict(g),
        gap=_gap(g, sizes),
        where=where.shares(sim, errors.base, code) if g.fault is None else recorded.shares(sim, g.search.base.theta, code),
        where_samples=ANALYSED if g.fault is None else RECORDED,
        where_bands=where.bands(sim, errors.base),
        candidates=rows.candidates(g, fitted),
        next_experiment=_next(g),
        unit="N" if g.scale is None else g.scale.unit,
        remarks=list(g.remarks),
        analysis=_analysis(g),
        baselines=Simple(**vars(simple.answers(g.search, errors))),
        notes=[*_no_model(g, errors, sizes.floor.value_n), *notes.of(g), *rows.notes_beside(g, only), *notes.of_units(g)],
        isolability=Cosines(ids=ids, cosine=np.asarray(cosine).tolist()),
        loops=drawn.loops(g),
        residuals=drawn.residuals(g),
    )
    restored = rows.with_beside(g, scaling.restored(found, units_of(g)), only)
    named = restored.candidates, g.verdict.effects
    said = [*notes.of_changes(*named), *notes.of_alternatives(*named), *(restored.notes or [])]
    said += notes.beside_floor(restored.gap, g.verdict.effects, restored.unit or "N")
    analysis = None if restored.analysis is None else restored.analysis.model_copy(update=_theta(g, restored.gap))
    restored = restored.model_copy(update={"notes": said, "analysis": analysis, "gap": _as_given(g, restored.gap)})
    return restored.model_copy(update={"sentence": sentence.sentence(restored)})


def _no_model(g: Given, errors: gap.Errors, floor_n: float) -> list[str]:
    """Return the note on an accepted model that a straight line beats."""
    factor, _ = units_of(g).of(Quantity.OUTPUT, None, None)
    left, line = errors.rms(errors.accepted), simple.line_n(g.search.sim, errors)
    return notes.beside_line(factor * left, factor * line, factor * floor_n, "N" if g.scale is None else g.scale.unit)


def _as_given(g: Given, found: Gap) -> Gap:
    """Return the gap with what another simulator's log is off by as given: of the base that stands for it theta is only assumed."""
    own = gap.of_other(g) if found.samples in (ANALYSED, RECORDED) else None
    return found if own is None else found.model_copy(update={"rmse_base_n": own})


def _theta(g: Given, found: Gap) -> dict[str, object]:
    """Return theta of a model that was accepted before, by bend that it has seen, and whether it has changed; nothing without one."""
    had = bends.since(g, found.rmse_base_n or 0.0, found.rmse_retuned_n or 0.0, found.known_misfit_n or 0.0)
    if had is None:
        return {}
    beside = {} if had.with_effect is None else {"theta_with_effect": had.with_effect}
    return {"theta_before": had.before, **beside, "theta_changed": had.changed}


def units_of(g: Evidence) -> scaling.Units:
    """Return the units of the recording."""
    return scaling.Units(g.problem.unit_n, g.scale)


def _analysis(g: Given) -> Analysis:
    p = g.problem
    found = Analysis(
        rate_hz=p.analysis_hz,
        samples=sum(len(r.raw) for r in p.records),
        runs=len(p.records),
        set_aside=p.set_aside,
        theta=dict(zip(p.configs, g.search.base.theta.tolist(), strict=True)),
        noise=_noise(g),
    )
    # what is not there stays unset
    beside: dict[str, object] = {"preload_n": g.preload_n} if g.preload_n else {}
    if g.scale is not None:
        beside["output_scale"] = OutputScale(unit=g.scale.unit, per_n=g.scale.per_n, origin=g.scale.origin)
    return found.model_copy(update=beside)


def _verdict(g: Given) -> Verdict:
    said = g.verdict
    singles = [i for ids in said.group for i in ids]
    rest = {k: v for k, v in said.probabilities.items() if k in (NONE, ("?",))}
    in_class = {part: title for title, parts in said.classes.items() for part in parts}
    members = {title: list(parts) for title, parts in said.classes.items()}
    members |= {name(ids): list(ids) for ids in said.group if len(ids) > 1}
    least = _least(g) if _asks_least(g) else None
    worst = g.rows.best.told() if said.status == UNDECIDED else None
    found = Verdict(
        status=said.status,
        effects=by_size(g),
        confidence=said.confidence,
        ambiguity_group=list(dict.fromkeys(in_class.get(i, i) for i in [*said.effects, *singles])),
        why=said.why,
        probability_none=rest.get(NONE, 0.0),
        probability_unknown=rest.get(("?",), 0.0),
        members=members or None,
        causes=[list(ids) for ids in said.group],
        would_have_shown=least,
        leftover=None if worst is None else [LeftOver(test=t.name, sigma=float(t.z), where=t.peak) for t in worst],
        odd_runs=None,
    )
    if said.confidence is not None:
        return found
    return found.model_copy(update={"confidence_why": "no library was tried under this prior, or nothing could be judged"})


def _least(g: Given) -> list[LeastShown]:
    """Return per effect what would have shown, and from which size it would have been told from what looks most like it."""
    rows = []
    for s, told in planning.told_apart(g.search, limit.least_shown(g.search, g.shows_d2), 1, alike=False):
        also = {} if told.rival is None else {"rival": told.rival, "told_size": told.size if told.settled else None}
        rows.append(LeastShown(**asdict(s), **also))
    return rows


def _asks_least(g: Given) -> bool:
    """Whether there is time to say what would have shown where nothing did."""
    return g.verdict.status == NOTHING and not g.passed("what would have shown")


def _gap(g: Given, found: gap.Sizes) -> Gap:
    named, interval = g.accepted is not g.search.base, found.interval
    known = found.known_n if g.problem.scatters else None
    return Gap(
        rmse_base_n=found.given_n,
        rmse_retuned_n=found.retuned_n,
        rmse_with_effect_n=found.with_effect_n,
        noise_floor_n=found.floor.value_n,
        noise_floor_low_n=found.floor.low_n,
        noise_floor_high_n=found.floor.high_n,
        known_misfit_n=known,
        shrink_pct=found.fall_pct,
        shrink_ci95_pct=None if interval is None else (interval.low, interval.high),
        shrink_why=_no_interval(named, g.fault) if interval is None else None,
        explained_of_reducible_pct=found.explained_pct,
        explained_scale=f"error (RMSE) above {below(known)}",
        accounted_pct=reasons.accounted_pct(g.accepted, g.rows),
        samples=ANALYSED if g.fault is None else RECORDED,
        held_out=g.search.held_out.folds.honest and g.fault is None and g.accepted.hypothesis.foretold,
        held_out_kind=g.search.held_out.folds.kind if g.accepted.hypothesis.foretold else by_run.OWN,
        worse_regions=found.worse,
    )


def _no_interval(named: bool, fault: RecorderEffect | None) -> str:
    """Return why there is no interval of by how much the error falls."""
    if fault is not None:
        return "a fault of the recorder has no scatter from run to run"
    return "the record is too short to have parts that differ" if named else "no effect of the output was added"


def _noise(g: Given) -> dict[str, dict[str, dict[str, Estimated]]]:
    """Return the noise of each sensor as estimated, with 95 % intervals."""
    found = {}
    noise = of_readings(g.problem.records, g.search.noise)
    for system in sorted(noise.output):
        sensors = (("input", noise.input[system]), ("output", noise.output[system]))
        spread = noise.spread.get(system, {})
        found[system] = {
            side: {k: _estimated(side, k, v, spread.get(f"{side}.{k}")) for k, v in asdict(sensor).items()} for side, sensor in sensors
        }
    return found


def _estimated(side: str, name: str, value: float, spread: float | None) -> Estimated:
    """Return a number of a sensor with its interval; what was not fitted is what differences of its readings say."""
    of = Estimated if name == "correlation_s" else EstimatedInput if side == "input" else EstimatedOutput
    if spread is None:
        return of(estimate=value, ci95=None, why="as differences of readings show it: it is not fitted with the rest")
    if not 0.0 < spread < np.inf:
        return of(estimate=value, ci95=None, why="the readings show no noise")
    return of(estimate=value, ci95=log_interval(value, spread))


def _next(g: Given) -> NextExperiment | None:
    """Return the movement that separates the two leading rivals, in words and as a scenario."""
    experiment = following.proposed(g.search, g.rows, g.verdict, g.limits, g.passed)
    if experiment is None:
        return None
    unit_n = g.problem.unit_n
    return NextExperiment(
        separates=list(experiment.separates),
        trajectory=experiment.trajectory.name,
        why=promised(experiment) + ("" if unit_n == 1.0 else f"; its tensions are to be taken times {unit_n:g}"),
        d2=experiment.d2,
        d2_here=experiment.d2_here,
        settles=experiment.settles,
        chance=experiment.chance,
        scenario=following.scenario_of(g.search, experiment).model_dump(mode="json", by_alias=True, exclude_defaults=False),
        tension_factor=unit_n,
    )


def promised(experiment: following.Experiment) -> str:
    """Return what a proposed movement would settle, or in how many recordings the best of the menu settles it all the same."""
    if experiment.settles:
        here = f"24 settles it; here {experiment.d2_here:.3g}"
        if experiment.d2_here >= DECIDABLE:
            here = f"24 would settle it if laws were exact; here {experiment.d2_here:.3g}"
        return f"recorded on one bend, the two would differ by D^2 = {experiment.d2:.3g} ({here})"
    most = f"at most D^2 = {experiment.d2:.1f} (24 would), here {experiment.d2_here:.1f}"
    settled = round(100.0 * experiment.chance)
    if settled == 0:
        return f"no movement of the menu settles it within these tensions and rates: {most}"
    return f"no movement of the menu is sure to settle it within these tensions and rates, the best does in {settled} of 100 recordings: {most}"
