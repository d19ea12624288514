"""Run the feedforward controller of every configuration along a reference and score its plant (Section IV)."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from sstl_cli.control.controller import IDENTITY, METHODS, PHASES, Controller, Options, Theta
from sstl_cli.control.plant import Plant, Track, replay, track
from sstl_cli.control.references import Reference, first_cycle_s
from sstl_cli.control.scoring import MAPE_FLOOR_N, Score, reduction_pct, score, windows
from sstl_cli.core.documents.control import ScoreRow
from sstl_cli.core.errors import SstlError
from sstl_cli.core.rng import stream
from sstl_cli.core.runs import Run
from sstl_cli.core.tables import COMMAND, PARAMETERS, SCORE
from sstl_cli.mapping.configurations import configurations

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Case:
    """One configuration: what was identified on its actuation tendon (act) and on its sensing loop (sstl).

    ``mapped`` holds the lines that the mapping predicts from ``sstl``, ``outside`` whether its input
    lies outside the trained range, ``made_for`` the method that stored parameters belong to.
    """

    config_id: str
    location: str | None = None
    act: Theta | None = None
    sstl: tuple[float, float] | None = None
    mapped: Theta | None = None
    outside: bool = False
    made_for: str | None = None

    def lines(self, method: str) -> Theta | None:
        """Return the lines that a method drives with, or None where it is not possible."""
        known = self.mapped if self.mapped is not None else self.act
        if method == "DI":
            return self.act
        if method == "proposed":
            return self.mapped
        if method == "no-bias":
            return known.without_bias() if known is not None else None
        return known

    def usual_method(self) -> str:
        """Return the method to drive with where none is asked for."""
        return self.made_for or ("proposed" if self.mapped is not None else "DI")


@dataclass(frozen=True)
class Result:
    """One configuration, reference and method: what happened and how well (scores by window)."""

    run_id: str
    case: Case
    trajectory: str
    method: str
    reference: Reference
    track: Track
    scores: dict[str, Score]
    reduction_pct: dict[str, float | None] = field(default_factory=dict)
    bound_cost_n: float | None = None


def cases_of(theta: pa.Table) -> tuple[list[Case], dict[str, str]]:
    """Return the configurations of a Theta table, and why others were set aside.

    Several runs of one configuration and system are averaged. A column ``tendon`` splits the actuation
    side of a configuration into its tendons, which share the sensing loop.
    """
    known, unused = configurations(theta, alone=True)
    aside = {f"{u.config} ({u.run_id})": u.why for u in unused}
    found = []
    for one in known:
        loop = one.loop
        slopes, place = (loop.slopes, loop.location) if loop is not None else (None, None)
        if not one.tendons:
            found.append(Case(one.name, place, None, slopes))
        for tendon, act in one.tendons.items():
            name = f"{one.name}/{tendon}" if tendon else one.name
            try:
                lines = Theta(*(getattr(act, p) for p in PARAMETERS))
            except SstlError as error:
                aside[name] = error.what
                continue
            found.append(Case(name, act.location or place, lines, slopes))
    return found, aside


def mean_biases(cases: Iterable[Case]) -> tuple[float, float] | None:
    """Return the pre-calibrated constant biases (N): the means over the identified actuation tendons."""
    known = [c.act for c in cases if c.act is not None]
    if not known:
        return None
    return float(np.mean([t.beta_p for t in known])), float(np.mean([t.beta_r for t in known]))


def with_mapping(
    cases: Sequence[Case],
    predict: Callable[[Array], Array],
    biases: tuple[float, float],
    outside: Callable[[Array], NDArray[np.bool_]] | None = None,
) -> tuple[list[Case], dict[str, str]]:
    """Return the cases with the actuation lines that a mapping predicts from the sensing loop (Phase I).

    The second value says why a prediction could not be used, by configuration.

    Parameters
    ----------
    predict : callable
        Maps slopes (Gamma_p, Gamma_r) of the sensing loop, shape (n, 2), to those of the actuation tendon.
    biases : tuple of float
        Constant biases beta_p, beta_r of the actuation tendon in N.
    outside : callable, optional
        Tells for the same input, shape (n,), whether it lies outside the trained range.
    """
    usable = [i for i, c in enumerate(cases) if c.sstl is not None]
    done = list(cases)
    aside: dict[str, str] = {}
    if not usable:
        return done, aside
    inputs = np.array([cases[i].sstl for i in usable], dtype=np.float64)
    slopes = np.asarray(predict(inputs), dtype=np.float64)
    if slopes.shape != inputs.shape:
        raise SstlError(f"mapping answers shape {slopes.shape} to inputs of shape {inputs.shape}", code="E405")
    flags = outside(inputs) if outside is not None else np.zeros(len(usable), bool)
    for i, (gp, gr), flag in zip(usable, slopes, flags, strict=True):
        try:
            mapped = Theta(float(gp), biases[0], float(gr), biases[1])
        except SstlError as error:
            aside[cases[i].config_id] = f"mapping gives unusable lines: {error.what}"
            continue
        done[i] = replace(cases[i], mapped=mapped, outside=bool(flag))
    return done, aside


def possible_methods(cases: Sequence[Case]) -> dict[str, str]:
    """Return for every method why it is not possible for any case (empty text where it is)."""
    why = dict.fromkeys(METHODS, "")
    if not any(c.act for c in cases):
        why["DI"] = "no usable row of system 'act'"
    if not any(c.mapped for c in cases):
        why["proposed"] = "needs --model and usable rows of system 'sstl'"
    if why["DI"] and why["proposed"]:
        why["no-bias"] = "needs identified or mapped slopes"
    return why


def run(
    cases: Iterable[Case],
    references: Callable[[Case], Sequence[Reference]],
    plant_of: Callable[[Case], Plant | None],
    methods: Sequence[str] = METHODS,
    options: Options | None = None,
    seed: int = 0,
    floor_n: float = MAPE_FLOOR_N,
) -> Iterator[Result]:
    """Yield the result of every configuration, reference and method, one after the other.

    Parameters
    ----------
    references : callable
        The references to be tracked by a configuration (N), sampled at ``options.dt_s``.
    plant_of : callable
        The plant of a configuration, or None where it has none (it is then left out).
    floor_n : float
        References below this (N) are left out of MAPE.
    """
    options = options or Options()
    for case in cases:
        plant = plant_of(case)
        if plant is None:
            continue
        for reference in references(case):
            _require_reachable(reference, options)
            baseline: dict[str, Score] | None = None
            for method in _baseline_first(methods):
                lines = case.lines(method) or (case.act if method == "none" else None)
                if lines is None and method != "none":
                    continue
                controller = Controller(lines or IDENTITY, options, method != "none")
                sensor = (seed, "sensor", case.config_id, reference.name)
                done = track(controller, plant, reference.tension_n, stream(*sensor))
                scores = _scores(reference, done.tension_out, floor_n)
                cost = None
                if options.bounded() and method != "none":
                    unbounded = Controller(lines or IDENTITY, options.unbounded())
                    free = track(unbounded, plant, reference.tension_n, stream(*sensor))
                    cost = scores["all"].rmse_n - _scores(reference, free.tension_out, floor_n)["all"].rmse_n
                if method == "none":
                    baseline = scores
                yield _result(case, reference, method, done, scores, baseline, cost)


def run_recorded(
    cases: Sequence[Case],
    recorded: Iterable[Run],
    methods: Sequence[str] = METHODS,
    options: Options | None = None,
    floor_n: float = MAPE_FLOOR_N,
    plant_of: Callable[[Case], Plant | None] | None = None,
) -> Iterator[Result]:
    """Yield results where the input tension of a recorded loop drives the controller.

    The output is predicted by the identified lines of the loop for each command; the record's own
    tracking is scored as method ``recorded``.

    Raises
    ------
    SstlError
        If no recorded run has a reference and a configuration of the Theta table.
    """
    options = options or Options()
    by_id = {c.config_id: c for c in cases}
    used = 0
    for log in recorded:
        case = by_id.get(log.config_id or log.run_id)
        if log.system != "act" or case is None or log.tension_ref_n is None or len(log) < 2:
            continue
        plant = plant_of(case) if plant_of is not None else None
        if plant is None:
            continue
        used += 1
        settings = options.model_copy(update={"dt_s": log.dt_s})
        time = log.time_s - log.time_s[0]
        wanted = log.tension_ref_n
        reference = Reference(log.trajectory or log.run_id, time, wanted, first_cycle_s(time, wanted))
        own = Track(wanted, log.tension_in_n, log.tension_out_n, np.full(len(log), len(PHASES) - 1, np.int8))
        own_scores = _scores(reference, own.tension_out, floor_n)
        yield _result(case, reference, "recorded", own, own_scores, None, None, log.run_id)
        baseline: dict[str, Score] | None = None
        for method in _baseline_first(methods):
            lines = case.lines(method)
            if lines is None:
                continue
            done = replay(Controller(lines, settings, method != "none"), plant, log.tension_ref_n, log.tension_in_n)
            scores = _scores(reference, done.tension_out, floor_n)
            baseline = scores if method == "none" else baseline
            yield _result(case, reference, method, done, scores, baseline, None, log.run_id)
    if not used:
        raise SstlError(
            "no recorded run of system 'act' has a tension_ref_n and a configuration of the Theta table",
            fix="record the reference, or give --reference instead of --recorded",
            code="E410",
        )


def command_table(result: Result) -> pa.Table:
    """Return what happened as a table of the COMMAND schema."""
    n = len(result.reference.time_s)
    labels = {
        "run_id": result.run_id,
        "config_id": result.case.config_id,
        "location": result.case.location,
        "trajectory": result.trajectory,
        "method": result.method,
    }
    arrays: list[pa.Array] = [pa.repeat(pa.scalar(v, pa.string()), n) for v in labels.values()]
    done = result.track
    time, wanted = result.reference.time_s, result.reference.tension_n
    arrays += [pa.array(v, pa.float64()) for v in (time, wanted, done.command, done.tension_in, done.tension_out)]
    phases = pa.DictionaryArray.from_arrays(pa.array(done.phase, pa.int8()), pa.array(PHASES))
    arrays.append(phases.cast(pa.string()))
    return pa.Table.from_arrays(arrays, schema=COMMAND.arrow())


def score_rows(result: Result) -> list[ScoreRow]:
    """Return the scores of a result as rows of the SCORE schema."""
    return [
        ScoreRow(
            run_id=result.run_id,
            config_id=result.case.config_id,
            location=result.case.location,
            trajectory=result.trajectory,
            method=result.method,
            window=window,
            rmse_n=s.rmse_n,
            std_n=s.std_n,
            mape_pct=s.mape_pct,
            mape_floor_n=s.mape_floor_n,
            masked_pct=s.masked_pct,
            reduction_pct=result.reduction_pct[window],
        )
        for window, s in result.scores.items()
    ]


def score_table(rows: Sequence[ScoreRow]) -> pa.Table:
    """Return score rows as a table of the SCORE schema."""
    return pa.Table.from_pylist([row.plain() for row in rows], schema=SCORE.arrow())


def _baseline_first(methods: Sequence[str]) -> list[str]:
    return sorted(dict.fromkeys(methods), key=METHODS.index)


def _scores(reference: Reference, output: Array, floor_n: float) -> dict[str, Score]:
    found = windows(reference.time_s, reference.cycle_s)
    return {w: score(reference.tension_n[s], output[s], floor_n) for w, s in found.items()}


def _result(
    case: Case,
    reference: Reference,
    method: str,
    done: Track,
    scores: dict[str, Score],
    baseline: dict[str, Score] | None,
    cost: float | None,
    source: str | None = None,
) -> Result:
    compared = baseline if method != "none" else None
    reduction = {w: reduction_pct(s.rmse_n, compared[w].rmse_n) if compared else None for w, s in scores.items()}
    run_id = f"{source or f'{case.config_id}-{reference.name}'}-{method}"
    return Result(run_id, case, reference.name, method, reference, done, scores, reduction, cost)


def _require_reachable(reference: Reference, options: Options) -> None:
    low, high = float(reference.tension_n.min()), float(reference.tension_n.max())
    if low < 0.0 or high > options.t_max_n:
        raise SstlError(
            f"reference spans {low:g}..{high:g} N, outside 0..{options.t_max_n:g} N",
            where=reference.name,
            fix="change the reference or --t-max",
            code="E408",
        )
