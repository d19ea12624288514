"""From recorded runs to all that a verdict on them is made from: fits, faults of the recorder, channels beside."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from sstl_cli.core.runs import Run
from sstl_cli.diagnosis import channels, faults, features, misfit, scale, scaling, search, variation
from sstl_cli.diagnosis.channels import ChannelGap
from sstl_cli.diagnosis.constants import MOST_EFFECTS
from sstl_cli.diagnosis.corners import likelier
from sstl_cli.diagnosis.faults import RecorderEffect
from sstl_cli.diagnosis.found import Search
from sstl_cli.diagnosis.neighbours import NEIGHBOUR
from sstl_cli.diagnosis.preload import preload_of
from sstl_cli.diagnosis.propagation import propagates
from sstl_cli.diagnosis.question import Question, candidates
from sstl_cli.diagnosis.records import Problem, Record, prepare
from sstl_cli.diagnosis.scale import Scale
from sstl_cli.diagnosis.simulator import Simulator
from sstl_cli.physics.effect import TRANSITION
from sstl_cli.physics.effects import get
from sstl_cli.physics.scenario import Scenario

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Evidence:
    """All that was found before anything is said: fits, faults of the recorder, channels beside, and their rows.

    ``prepared`` is the problem as the runs alone pose it: no noise, no simulator has a part in it. ``nominal`` is theta (rad, shape
    (configurations,)) as the simulator has it.
    """

    problem: Problem
    search: Search
    nominal: Array
    recorder: tuple[RecorderEffect, ...]
    beside: tuple[ChannelGap, ...]
    rows: features.Rows
    prepared: Problem
    scale: Scale | None = None
    runs: tuple[Run, ...] = ()

    @property
    def preload_n(self) -> dict[str, float]:
        """By how much (N of the recording) the tendons of each system that pulls both ways are stretched where they read nothing."""
        return {system: self.problem.unit_n * p for system, p in self.search.sim.mechanics.preload_n.items()}


def gather(
    runs: Sequence[Run],
    asked: Question,
    advance: Callable[[float], None] = lambda _: None,
    passed: Callable[[str], bool] = lambda _: False,
    before: Evidence | None = None,
) -> Evidence:
    """Return everything that a verdict on recorded runs is made from; what has ``passed`` (see core.deadline) is left out.

    Parameters
    ----------
    before : Evidence, optional
        What was found of these runs, perhaps beside others: they are not made ready again.

    Raises
    ------
    SstlError
        If no run can be used.
    """
    output = asked.sim.output if asked.sim else None
    # a constant of the rig, whichever of its runs are asked
    preload_n = preload_of(runs, asked.sim) if before is None else before.preload_n
    had = scale.given(runs, output)
    own = had or scale.scale_of(runs, preload_n)
    found = _on_scale(runs, asked, own, preload_n, advance, passed, before)
    better = None if own is None or had is not None else scale.beside(found.search, own)
    return found if better is None else _on_scale(runs, asked, better, preload_n, passed=passed)


def _on_scale(
    runs: Sequence[Run],
    asked: Question,
    own: Scale | None,
    preload_n: Mapping[str, float],
    advance: Callable[[float], None] = lambda _: None,
    passed: Callable[[str], bool] = lambda _: False,
    before: Evidence | None = None,
) -> Evidence:
    """Return everything that a verdict is made from, outputs in another unit on a scale of their own."""
    recorded, output = tuple(runs), asked.sim.output if asked.sim else None
    if own is not None:
        runs = scale.in_newtons(runs, own)
    unit_n = scaling.unit_of(runs)
    scenario = asked.given(unit_n).with_rig(preload_n=preload_n)
    prepared = prepare(scaling.scaled(runs, unit_n), unit_n, _ready(before, own, unit_n))
    problem = misfit.applied(prepared, scenario.misfits, unit_n)
    # a scale that is nobody's fault is not compared; the one that an accepted model has is a scale like any other
    ids = [i for i in candidates(asked) if own is None or output is not None or i != "gain_error"]
    nominal = np.array([scenario.theta_of(c) for c in problem.configs])
    # a scale that is found on these runs has no gain beside it
    sim, theta = _begun(problem, scenario, nominal, {} if own is None or output is None else own.zeros_n(unit_n))
    found = search.run(sim, _fitted(ids, problem), theta, min(asked.max_effects, MOST_EFFECTS), advance, asked.workers, passed=passed)
    # the noise that was found may have changed what the input is taken to be
    problem = found.sim.problem
    # of the recorder there are no changes: what the simulator claims is as it says
    new = [i for i in ids if i not in scenario.effects]
    faulty = faults.beyond(found, scenario)
    found = faults.once(found, faulty, lambda w: faults.beyond(found, scenario, beside=w.fit))
    recorder = [e for e in faulty if e.id in new and e.id not in found.singles]
    lag = found.sim.fixed.get("tension_loop_lag")
    gaps = channels.loop_gaps(problem.records, lag) if "tension_loop_lag" in ids else []
    if asked.position:
        gaps = [*gaps, *channels.position_gaps(found.sim, found.base, ids)]
    rows = features.rows(found, beside(found, faulty, gaps), 1.0 if propagates(problem) else 0.0)
    rows = replace(rows, barred={**rows.barred, **{e.id: e.id for e in faulty if e.id not in new}})
    return Evidence(problem, found, nominal, tuple(recorder), tuple(gaps), rows, prepared, own, recorded)


def _ready(before: Evidence | None, own: Scale | None, unit_n: float) -> dict[str, Record]:
    """Return the records that were made before on the same scale."""
    if before is None or (before.scale, before.prepared.unit_n) != (own, unit_n):
        return {}
    return {r.run_id: r for r in before.prepared.records}


def _begun(problem: Problem, scenario: Scenario, nominal: Array, zeros_n: Mapping[str, float]) -> tuple[Simulator, Array]:
    """Return the simulator of a problem and the theta from which it is fitted; ``nominal`` is as the scenario has it."""
    unit_n = problem.unit_n
    mechanics, fixed = scaling.mechanics(scenario, unit_n), scaling.effects(scenario, unit_n)
    # what holds keep says what the input does at corners
    sim, theta = likelier(Simulator(problem, mechanics, fixed, scenario.dispersion, zeros_n=zeros_n), nominal)
    if not scenario.misfits:
        return sim, theta
    # of a bend that it has not seen a model says nothing
    seen = {c.id for c in scenario.configurations}
    had = np.array([n if c in seen else t for c, n, t in zip(problem.configs, nominal, theta, strict=True)])
    return variation.applied(replace(sim, accepted=had), theta, scenario.wander, unit_n), theta


def _fitted(ids: Sequence[str], problem: Problem) -> list[str]:
    """Return the candidates that are fitted to the output: a pulley of the loop is none where the tendon alone was recorded."""
    fitted = [i for i in ids if get(i).sought and get(i).channel in _shown(problem) and set(get(i).systems) & set(problem.systems)]
    if any(r.slip is not None for r in problem.records):
        # which element slips next is known only where a tension drives the line
        fitted = [i for i in fitted if get(i).stage != TRANSITION]
    return fitted


def _shown(problem: Problem) -> tuple[str, ...]:
    """Return the channels whose effects the output can show: between tendons only if the others were recorded too."""
    act = [r for r in problem.records if r.system == "act"]
    together = bool(act) and all(NEIGHBOUR in r.raw.extra for r in act)
    return ("out", "neighbour") if together else ("out",)


def beside(found: Search, recorder: Sequence[RecorderEffect], gaps: Sequence[ChannelGap]) -> list[features.CandidateRow]:
    """Return the rows of the candidates that are not fitted to the output."""
    return [e.row() for e in recorder if e.id not in found.singles] + [g.row() for g in gaps if g.effect not in found.singles]
