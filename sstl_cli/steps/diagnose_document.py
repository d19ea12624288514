"""The JSON form of a diagnosis (CONTRACT: sstl.diagnosis/1)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, replace

import numpy as np
from numpy.typing import NDArray

from sstl_cli import __version__
from sstl_cli.core.documents.diagnosis import (
    Analysis,
    Cosines,
    DiagnosisDocument,
    Estimated,
    Gap,
    LeastShown,
    LeftOver,
    NextExperiment,
    OutputScale,
    Simple,
    Verdict,
)
from sstl_cli.core.groups import ANALYSED, RECORDED
from sstl_cli.core.numbers import quantity
from sstl_cli.diagnosis import by_run, following, heldout, limit, misfit, scaling, sentence, shrink, where
from sstl_cli.diagnosis.constants import DECIDABLE
from sstl_cli.diagnosis.faults import RecorderEffect, squared_errors
from sstl_cli.diagnosis.free import ASIDE, Free
from sstl_cli.diagnosis.noise import floor_n, likely, of_readings
from sstl_cli.diagnosis.readings import gaps
from sstl_cli.diagnosis.reasons import also, without_name
from sstl_cli.diagnosis.rounding import unrounded
from sstl_cli.diagnosis.verdict import AMBIGUOUS, IDENTIFIED, NONE, NOTHING, UNDECIDED
from sstl_cli.diagnosis.whitening import Noise
from sstl_cli.physics.effects import get
from sstl_cli.steps import diagnose_drawn as drawn
from sstl_cli.steps import diagnose_rows as rows
from sstl_cli.steps.diagnose_given import Errors, Given, name
from sstl_cli.steps.diagnose_numbers import before, below_floor, floor_interval, recorded_shares

Array = NDArray[np.float64]
# tests of the residual that are told where the cause is not known
TOLD = 4


def document(g: Given) -> DiagnosisDocument:
    """Return the diagnosis as laid down in the contract, tensions in the units of the recording."""
    g = replace(g, recorder=tuple(_above_noise(g, r) for r in g.recorder))
    sim = g.search.sim
    # the error is that of the simulator alone: what it is known to leave counts as well
    known = misfit.known(g.problem)
    held = g.search.held_out
    errors = Errors(known + held.residual(g.search.base), known + held.residual(g.accepted), _fine(g, g.search.noise), sim.weight, known)
    code = where.phases(sim, g.accepted.prediction)
    ids, cosine = following.isolability(g.search)
    fitted = rows.fitted(g, errors)
    only = rows.only_beside(g, fitted)
    scale, notes = g.scale, [*_notes(g, held.folds), *rows.notes_beside(g, only)]
    if scale is not None:
        said = ", ".join(f"{k} {v:.4g} {scale.unit}/N" for k, v in scale.per_n.items())
        notes.append(f"the scale of the output is nobody's fault and was fitted: {said}; parameters are in newtons")
    if g.problem.unit_n != 1.0:
        notes.append(f"fitted in units of {g.problem.unit_n:g} N: the catalogue's ranges are for 3 to 60 N")
    found = DiagnosisDocument(
        schema="sstl.diagnosis/1",
        package_version=__version__,
        verdict=_verdict(g),
        gap=rows.gap_beside(g, _gap(g, errors, code), only),
        where=where.shares(sim, errors.base, code) if _fault(g) is None else recorded_shares(g, code),
        where_samples=ANALYSED if _fault(g) is None else RECORDED,
        where_bands=where.bands(sim, errors.base),
        candidates=rows.candidates(g, fitted, only),
        next_experiment=_next(g),
        unit="N" if scale is None else scale.unit,
        remarks=list(g.remarks),
        analysis=_analysis(g),
        baselines=_baselines(g, errors),
        notes=notes,
        isolability=Cosines(ids=ids, cosine=np.asarray(cosine).tolist()),
        loops=drawn.loops(g),
        residuals=drawn.residuals(g),
    )
    beside = rows.beside(g)
    restored = _in_own_units(g, found if beside is None else found.model_copy(update={"beside": beside}))
    notes = [*notes, *below_floor(restored.gap, g.verdict.effects, restored.unit or "N")]
    analysis = None if restored.analysis is None else restored.analysis.model_copy(update=before(g, restored.gap))
    restored = restored.model_copy(update={"notes": notes, "analysis": analysis})
    return restored.model_copy(update={"sentence": sentence.sentence(restored)})


def _in_own_units(g: Given, found: DiagnosisDocument) -> DiagnosisDocument:
    """Return a diagnosis with its tensions in the units of the recording, its errors in the unit of the output."""
    if g.problem.unit_n != 1.0:
        found = DiagnosisDocument(**scaling.restore(found.plain(), g.problem.unit_n))
    if g.scale is None:
        return found
    return found.model_copy(update={"gap": Gap(**scaling.restore(found.gap.plain(), g.scale.typical))})


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
    if g.scale is None:
        return found
    return found.model_copy(update={"output_scale": OutputScale(unit=g.scale.unit, per_n=g.scale.per_n, origin=g.scale.origin)})


def _verdict(g: Given) -> Verdict:
    said = g.verdict
    singles = [i for ids in said.group for i in ids]
    rest = {k: v for k, v in said.probabilities.items() if k in (NONE, ("?",))}
    in_class = {part: title for title, parts in said.classes.items() for part in parts}
    members = {title: list(parts) for title, parts in said.classes.items()}
    members |= {name(ids): list(ids) for ids in said.group if len(ids) > 1}
    least = [LeastShown(**asdict(s)) for s in limit.least_shown(g.search, g.shows_d2)] if _asks_least(g) else None
    # what chance makes now and then is not left over
    worst = [t for t in sorted(g.rows.best.tests, key=lambda t: -t.z)[:TOLD] if t.z > 2.0] if said.status == UNDECIDED else None
    found = Verdict(
        status=said.status,
        effects=_by_size(g),
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


def _asks_least(g: Given) -> bool:
    """Whether there is time to say what would have shown where nothing did."""
    return g.verdict.status == NOTHING and not g.passed("what would have shown")


def _by_size(g: Given) -> list[str]:
    """Return the named effects, the one whose removal changes the prediction most first."""
    effects = list(g.verdict.effects)
    if g.verdict.status not in (IDENTIFIED, AMBIGUOUS) or len(effects) < 2:
        return effects
    f = g.accepted

    def loss(effect_id: str) -> float:
        without = {k: v for k, v in f.effects.items() if k != effect_id}
        return float(np.sum((f.prediction - g.search.sim.predict(f.theta, without)) ** 2))

    return sorted(effects, key=lambda e: -loss(e))


def _fine(g: Given, noise: Noise) -> float:
    """Return the white noise of the output above the analysis rate (N): what a mean over the readings of a sample does not hold."""
    # readings are counted in steps of the simulation; a slow sensor has one in a sample, which holds all of its noise
    coarse = [(noise.output[r.system].white_n * r.louder, r.readings[r.weight > 0]) for r in g.problem.records]
    return float(np.sqrt(np.mean([w**2 * (1.0 - float(np.mean(1.0 / np.maximum(n, 1.0)) if len(n) else 1.0)) for w, n in coarse])))


def _gap(g: Given, errors: Errors, code: NDArray[np.int64]) -> Gap:
    sim = g.search.sim
    given = errors.rms(sim.y + errors.known - sim.predict(g.nominal, {}))
    base, with_effect = errors.rms(errors.base), errors.rms(errors.accepted)
    named = g.accepted is not g.search.base
    noise = min(_sensors(g), key=lambda noise: _floor(g, noise))
    floor = float(np.hypot(_floor(g, noise), errors.fine_n))
    low, high = floor_interval(noise, lambda n: float(np.hypot(_floor(g, n), errors.fine_n)))
    interval: shrink.Interval | None = shrink.shrinkage(sim, errors.base, errors.accepted, errors.fine_n) if named else None
    percent = 100.0 * (1.0 - with_effect / base) if base > 0.0 else 0.0
    fault, samples = _fault(g), ANALYSED
    if fault is not None:
        # the spoilt samples are in both errors: before as they were read, after as explained
        base, with_effect, given = _recorded(g, fault)
        percent, interval, samples = 100.0 * (1.0 - with_effect / max(base, 1e-300)), None, RECORDED
        if fault.id == "quantisation":
            floor, low, high = _unrounded(g), None, None
    reducible = base - float(np.hypot(floor, misfit.rms_n(g.problem)))
    explained = 100.0 * (base - with_effect) / reducible if reducible > 1e-3 * base else None
    why = None
    if interval is None:
        why = _no_interval(named, fault)
    return Gap(
        rmse_base_n=given,
        rmse_retuned_n=base,
        rmse_with_effect_n=with_effect,
        noise_floor_n=floor,
        noise_floor_low_n=low,
        noise_floor_high_n=high,
        known_misfit_n=misfit.rms_n(g.problem) if g.problem.scatters else None,
        shrink_pct=percent,
        shrink_ci95_pct=None if interval is None else (interval.low, interval.high),
        shrink_why=why,
        explained_of_reducible_pct=None if explained is None else float(np.clip(explained, -100.0, 100.0)),
        explained_scale="error (RMSE) above the noise floor",
        samples=samples,
        held_out=g.search.held_out.folds.honest and fault is None and g.accepted.hypothesis.foretold,
        held_out_kind=g.search.held_out.folds.kind if g.accepted.hypothesis.foretold else by_run.OWN,
        worse_regions=shrink.worse_regions(sim, errors.base, errors.accepted, code) if named else [],
    )


def _no_interval(named: bool, fault: RecorderEffect | None) -> str:
    """Return why there is no interval of by how much the error falls."""
    if fault is not None:
        return "a fault of the recorder has no scatter from run to run"
    return "the record is too short to have parts that differ" if named else "no effect of the output was added"


def _fault(g: Given) -> RecorderEffect | None:
    """Return the fault of the recorder that is named, if one is."""
    return next((r for r in g.recorder if (r.id,) == g.verdict.effects), None)


def _floor(g: Given, noise: Noise) -> float:
    """Return what a perfect model would leave (N) at the analysis rate, by the phases of the accepted one."""
    return floor_n(g.problem.records, g.search.sim.phases(g.accepted.theta, g.accepted.effects, noise), noise)


def _unrounded(g: Given) -> float:
    """Return what a perfect model would leave (N) beside the steps of the converters: the noise was measured on rounded readings."""
    records = g.problem.records
    coarse = min(_floor(g, unrounded(records, noise)) for noise in _sensors(g))
    return float(np.hypot(coarse, _fine(g, unrounded(records, g.search.noise))))


def _above_noise(g: Given, r: RecorderEffect) -> RecorderEffect:
    """Return a fault with what it can have made at most: readings that were not rounded would still be noisy."""
    if r.id != "quantisation":
        return r
    noise = sum(len(x.raw) for x in g.problem.records) * _unrounded(g) ** 2
    return replace(r, removed_n2=min(r.removed_n2, max(r.total_n2 - noise, 0.0)))


def _sensors(g: Given) -> list[Noise]:
    """Return what the noise of the sensors may be: as likely as can be, or as measured where an accepted model's scatter is beside it.

    The search takes what its first models leave for noise. Where the named model leaves less, that was no noise.
    """
    if g.problem.scatters:
        return [g.search.measured]
    f = g.accepted
    if f is g.search.base:
        return [g.search.noise]
    columns = np.zeros((len(f.residual), len(f.theta) + len(f.free)))
    columns[np.arange(len(columns)), g.search.sim.config] = f.jacobian[:, 0]
    columns[:, len(f.theta) :] = f.jacobian[:, 1:]
    columns = columns[:, np.any(columns * g.search.sim.weight[:, None] != 0.0, axis=0)]
    phases = g.search.sim.phases(f.theta, f.effects, g.search.noise)
    return [g.search.noise, likely(g.problem.records, phases, f.residual, columns, g.search.measured)[0]]


def _recorded(g: Given, fault: RecorderEffect) -> tuple[float, float, float]:
    """Return RMSE (N) before and after a fault of the recorder is taken out, and as given, all over all raw samples.

    Readings of the input that were spoilt count as well: a fault is named for those of both sensors.
    """
    sim = g.search.sim

    def power(theta: Array) -> tuple[float, int]:
        total, count = 0.0, 0
        for r, prediction in zip(g.problem.records, sim.predict_fine(theta, {}), strict=True):
            expected, out, into = squared_errors(r, prediction)
            total += float(out.sum() + into.sum())
            count += int(np.count_nonzero(gaps(r.raw)[: len(expected)] == 0))
        return total, max(count, 1)

    total, count = power(g.search.base.theta)
    left = max(total - fault.removed_n2, 0.0)
    return float(np.sqrt(total / count)), float(np.sqrt(left / count)), float(np.sqrt(power(g.nominal)[0] / count))


def _noise(g: Given) -> dict[str, dict[str, dict[str, Estimated]]]:
    """Return the noise of each sensor as estimated, with 95 % intervals."""
    found = {}
    noise = of_readings(g.problem.records, g.search.noise)
    for system in sorted(noise.output):
        sensors = (("input", noise.input[system]), ("output", noise.output[system]))
        spread = noise.spread.get(system, {})
        found[system] = {side: {k: _estimated(v, spread.get(f"{side}.{k}")) for k, v in asdict(sensor).items()} for side, sensor in sensors}
    return found


def _estimated(value: float, spread: float | None) -> Estimated:
    """Return a number of a sensor with its interval; what was not fitted is what differences of its readings say."""
    if spread is None:
        return Estimated(estimate=value, ci95=None, why="as differences of readings show it: it is not fitted with the rest")
    if not 0.0 < spread < np.inf:
        return Estimated(estimate=value, ci95=None, why="the readings show no noise")
    return Estimated(estimate=value, ci95=_log_interval(value, spread))


def _log_interval(value: float, spread: float) -> tuple[float, float]:
    return float(value * np.exp(-1.96 * spread)), float(value * np.exp(1.96 * spread))


def _baselines(g: Given, errors: Errors) -> Simple:
    """Return what simpler rules would have answered, for comparison in the blind check."""
    singles = [v[0] for v in g.search.singles.values()]
    if not singles:
        return Simple(smallest_rmse=None, iid_bic=None)
    w = g.search.sim.weight
    n = max(float(w.sum()), 2.0)

    def bic(residual: Array, k: int) -> float:
        # an exact model leaves nothing at all
        return n * float(np.log(max(float(np.sum(w * residual**2)) / n, 1e-300))) + k * float(np.log(n))

    scores = {x.ids[0]: bic(x.fit.residual, len(x.fit.free)) for x in singles}
    best = min(scores, key=lambda k: scores[k])
    return Simple(
        smallest_rmse=min(singles, key=lambda x: errors.rms(x.fit.residual)).ids[0],
        iid_bic=best if scores[best] < bic(g.search.base.residual, 0) else None,
    )


def _notes(g: Given, folds: heldout.Folds) -> list[str]:
    p, notes = g.problem, []
    if any(r.slip is not None for r in p.records):
        notes.append("driven by the recorded motion: its direction sets the sign of friction, reversals are left out")
    if not folds.honest:
        notes.append(f"held out: {folds.kind}; repeats of one excitation protect little against a wrong name")
    if len(p.configs) == 1:
        notes.append("one configuration: offsets, constant and terminal friction cannot be told apart by their spread")
    if len(p.systems) == 1:
        notes.append(f"only {p.systems[0]} was recorded: effects of the other system cannot show")
    if p.set_aside:
        notes.append(f"{len(p.set_aside)} runs set aside")
    if (differs := by_run.shown(g.search.sim, g.accepted)) is not None:
        notes.append(_by_run(g, *differs))
    if g.verdict.status in (IDENTIFIED, AMBIGUOUS) and (alike := also(g.rows, g.verdict.effects)):
        notes.append(alike)
    if g.verdict.status == UNDECIDED and (own := without_name(g.search, g.rows)) is not None:
        loop = f"loop_friction = {g.search.sim.loop_friction(own.fit.effects):.4g}"
        notes.append(f"friction of the loop is a constant of the rig: with {loop} in [rig] of --sim other effects can be asked for")
    notes += [
        f"{get(i).id}: {x.parameter.name} lies outside its usual range {x.parameter.low:g}..{quantity(f'{x.parameter.high:g}', x.parameter.unit)}"
        for k, x in enumerate(g.accepted.free)
        for i in (x.effect.id,)
        if x.effect.id not in ASIDE and g.accepted.at_bound(k) and not x.parameter.shape
    ]
    return notes


def _by_run(g: Given, kind: Free, parts: Mapping[str, float]) -> str:
    """Return what each run has of its own, in words."""
    friction, unit_n = kind is by_run.FRICTION, g.problem.unit_n
    what = "friction" if friction else f"zero of the {'output' if kind is by_run.OUTPUT else 'input'} sensor"
    told = (f"{run} {100.0 * x:+.1f} %" if friction else f"{run} {x * unit_n:+.3g}" for run, x in parts.items())
    return f"{what} of each run is fitted to it, nobody can foretell that of another: {', '.join(told)}"


def _next(g: Given) -> NextExperiment | None:
    """Propose the movement that separates the two leading rivals, if any of the menu can.

    Where the two are told apart here, were laws exact, a movement that shows less of the difference would add nothing.
    """
    ranked = following.rivals(g.search.ranked(), g.verdict)
    # whoever is behind what has no name need not be told from one another, and where nothing propagates only a larger stroke helps
    settled = g.verdict.status in (NOTHING, IDENTIFIED) or without_name(g.search, g.rows) is not None or g.rows.log.propagates < 1.0
    if settled or len(ranked) < 2 or g.passed("next experiment"):
        return None
    first, second = ranked[:2]
    experiment = following.best_experiment(g.search, first, second, g.limits)
    if experiment is None or max(experiment.d2, DECIDABLE) <= experiment.d2_here:
        return None
    here = f"24 settles it; here {experiment.d2_here:.3g}"
    if experiment.d2_here >= DECIDABLE:
        here = f"24 would settle it if laws were exact; here {experiment.d2_here:.3g}"
    does = (
        f"recorded on one bend, the two would differ by D^2 = {experiment.d2:.3g} ({here})"
        if experiment.settles
        else f"no movement of the menu settles it within these tensions and rates: at most D^2 = {experiment.d2:.1f} (24 would), "
        f"here {experiment.d2_here:.1f}"
    )
    unit_n = g.problem.unit_n
    return NextExperiment(
        separates=list(experiment.separates),
        trajectory=experiment.trajectory.name,
        why=does + ("" if unit_n == 1.0 else f"; its tensions are to be taken times {unit_n:g}"),
        d2=experiment.d2,
        d2_here=experiment.d2_here,
        settles=experiment.settles,
        scenario=following.scenario_of(g.search, experiment).model_dump(mode="json", by_alias=True, exclude_defaults=False),
        tension_factor=unit_n,
    )
