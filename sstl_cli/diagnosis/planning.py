"""What a movement could tell before it is recorded: how small a gap of each effect would show, and from which size it is told.

Runs of the base with the noise that is expected stand for the recording; each effect is judged on them as if it were there (see
limit for the distances).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from copy import copy
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from sstl_cli.core.runs import Run
from sstl_cli.diagnosis import scaling
from sstl_cli.diagnosis.constants import DECIDABLE, LEAST_D2, NEAR_RIVALS, SETTLED, SIZE_NEAR, SIZE_ROUNDS
from sstl_cli.diagnosis.evidence import Weighed
from sstl_cli.diagnosis.fit import Fit, fit
from sstl_cli.diagnosis.following import isolability
from sstl_cli.diagnosis.found import NOTHING, Search
from sstl_cli.diagnosis.hypotheses import full
from sstl_cli.diagnosis.limit import Shown, distance2, least_shown
from sstl_cli.diagnosis.records import Problem, prepare
from sstl_cli.diagnosis.simulator import Simulator
from sstl_cli.diagnosis.starts import grid
from sstl_cli.diagnosis.weights import learned
from sstl_cli.diagnosis.whitening import Noise, Sensor, whitener
from sstl_cli.physics.effects import get
from sstl_cli.physics.scenario import Scenario

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Told:
    """The size from which an effect is told from everything else, its nearest rival, and D^2 between the two there."""

    rival: str | None
    size: float
    d2: float


@dataclass(frozen=True)
class Planned:
    """What a movement could tell of one effect, in the units of the recording.

    ``least_size`` and ``gap_n`` (N, RMS) would show, within the effect's range if ``shows``; from ``told_size`` on it is told from
    its nearest rival, at D^2 = ``d2``; None where it is not within its range.
    """

    effect: str
    parameter: str
    unit: str
    least_size: float
    gap_n: float
    shows: bool
    rival: str | None
    told_size: float | None
    d2: float | None


@dataclass(frozen=True)
class Plan:
    """The effects, smallest gap first, those that the movement cannot tell apart, and the problem that it would pose."""

    rows: tuple[Planned, ...]
    alike: list[list[str]]
    problem: Problem


def plan(runs: Sequence[Run], scenario: Scenario, effects: Sequence[str], advance: Callable[[float], None] = lambda _: None) -> Plan:
    """Return what the recording of a scenario would tell.

    Parameters
    ----------
    runs : sequence of Run
        The scenario's, as the fast model simulates them.
    effects : sequence of str
        Candidates; those that do not act on the output are left out.

    Raises
    ------
    SstlError
        If no run could be diagnosed.
    """
    found, unit_n = _planned(runs, scenario)
    ids = [e for e in effects if get(e).fitted and get(e).channel == "out"]
    for e in ids:
        if (single := _least(found, e)) is not None:
            found.singles[e] = (single,)
        advance(0.5 / len(ids))
    shown = {s.effect: s for s in least_shown(found, learned().shows_d2)}
    names, cosine = isolability(found, len(ids))
    rows = []
    for e in sorted(shown):
        at = names.index(e)
        near = sorted((n for n in names if n != e), key=lambda n: -cosine[at, names.index(n)])
        rivals = [n for i, n in enumerate(near) if i < NEAR_RIVALS or n in get(e).look_alikes]
        told = _told(found, shown[e], rivals, max((float(cosine[at, names.index(n)]) for n in near), default=0.0))
        rows.append(_row(shown[e], told, unit_n))
        advance(0.5 / len(shown))
    rows.sort(key=lambda r: r.gap_n)
    return Plan(tuple(rows), classes(rows), found.sim.problem)


def _planned(runs: Sequence[Run], scenario: Scenario) -> tuple[Search, float]:
    """Return the base model on the planned runs, with the stated noise, and the unit of the fit (N)."""
    unit_n = scaling.unit_of(runs)
    problem = prepare(scaling.scaled(runs, unit_n), unit_n)
    fixed = {e: v for e, v in scaling.effects(scenario, unit_n).items() if get(e).fitted}
    sim = Simulator(problem, scaling.mechanics(scenario, unit_n), fixed)
    theta = np.array([scenario.theta_of(c) for c in problem.configs])
    heard = scenario.noise
    out = Sensor(
        max(heard.white_n / unit_n, 1e-6) / float(np.sqrt(problem.records[0].thin)), heard.coloured_n / unit_n, heard.correlation_s
    )
    noise = Noise(dict.fromkeys(problem.systems, out), dict.fromkeys(problem.systems, out), dict.fromkeys(problem.systems, 1.0))
    # what the base shows, without the noise that is expected
    quiet = copy(sim)
    quiet.y = sim.predict(theta, {})
    whiten = whitener(sim.constants({}, noise), sim.phases(theta, {}, noise))
    return Search(quiet, noise, noise, fit(quiet, whiten, NOTHING, theta, np.zeros(0), 0), {}, {}), unit_n


def _least(found: Search, effect_id: str) -> Weighed | None:
    """Return an effect at the start (of its shapes) from which the smallest gap shows, None where it shows nothing."""
    sim, h = found.sim, full(effect_id, found.sim.problem.systems)
    best: tuple[float, Weighed] | None = None
    for start in grid(h.free) if h.strengths else ():
        single = Weighed(fit(sim, found.base.whiten, h, found.base.theta, start, 0), 0.0, 0.0)
        rows = least_shown(replace(found, singles={effect_id: (single,)}), learned().shows_d2)
        if rows and (best is None or rows[0].gap_n < best[0]):
            best = (rows[0].gap_n, single)
    return None if best is None else best[1]


def _told(found: Search, shown: Shown, rivals: Sequence[str], cosine: float) -> Told:
    """Return from which size an effect is told from its rivals, each refitted to what it shows.

    The linear picture gives a first size; the distance at that size, which grows with its square, corrects it.
    """
    own = found.singles[shown.effect][0].fit
    most = _reach(own, shown.parameter)
    size = float(min(shown.size / np.sqrt(max(1.0 - cosine**2, 1e-6)), most))
    nearest, d2 = None, np.inf
    for _ in range(SIZE_ROUNDS):
        truth = _sized(found.sim, own, shown.parameter, size)
        distances = {r: distance2(found.sim, truth, found.singles[r][0].fit) for r in rivals}
        nearest = min(distances, key=lambda r: (distances[r], r), default=None)
        d2 = distances[nearest] if nearest else np.inf
        if abs(np.log(max(d2, 1e-6) / DECIDABLE)) < SIZE_NEAR or nearest is None or (size >= most and d2 < DECIDABLE):
            break
        size = float(np.clip(size * np.sqrt(DECIDABLE / max(d2, LEAST_D2)), shown.size, most))
    return Told(nearest, size, float(d2))


def _reach(own: Fit, name: str) -> float:
    p = next(f.parameter for f in own.free if f.parameter.name == name)
    return max(abs(p.high - p.neutral), abs(p.low - p.neutral))


def _sized(sim: Simulator, own: Fit, name: str, size: float) -> Fit:
    """Return an effect with one strength of a size, the others neutral."""
    values = own.values.copy()
    for i, f in enumerate(own.free):
        p = f.parameter
        if not p.shape:
            sign = 1.0 if p.high - p.neutral >= p.neutral - p.low else -1.0
            values[i] = p.neutral + (sign * size if p.name == name else 0.0)
    return fit(sim, own.whiten, own.hypothesis, own.theta, values, 0)


def _row(shown: Shown, told: Told, unit_n: float) -> Planned:
    p = get(shown.effect).parameter(shown.parameter)
    reach = max(abs(p.high - p.neutral), abs(p.low - p.neutral))
    settled = told.d2 >= SETTLED * DECIDABLE
    return Planned(
        effect=shown.effect,
        parameter=shown.parameter,
        unit=shown.unit,
        least_size=scaling.parameter(shown.size, shown.unit, unit_n),
        gap_n=shown.gap_n * unit_n,
        shows=shown.size <= reach,
        rival=told.rival,
        told_size=scaling.parameter(told.size, shown.unit, unit_n) if settled and shown.size <= reach else None,
        d2=told.d2 if told.rival else None,
    )


def classes(rows: Sequence[Planned]) -> list[list[str]]:
    """Return the sets of effects that this movement cannot tell apart at any size within their ranges.

    Examples
    --------
    >>> row = lambda e, r, told: Planned(e, "p", "N", 0.1, 0.1, True, r, told, 30.0)
    >>> classes([row("a", "b", None), row("b", "c", None), row("c", "a", 1.0), row("d", "a", 2.0)])
    [['a', 'b', 'c']]
    """
    groups: list[set[str]] = []
    for r in rows:
        if r.told_size is None and r.shows and r.rival is not None:
            pair = {r.effect, r.rival}
            touching = [g for g in groups if g & pair]
            groups = [g for g in groups if not g & pair] + [pair.union(*touching)]
    return sorted(sorted(g) for g in groups)
