"""What a movement could tell before it is recorded: how small a gap of each effect would show, and from which size it is told.

Runs of the base with the noise that is expected stand for the recording; each effect is judged on them as if it were there (see
limit for the distances).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from copy import copy
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from sstl_cli.core.runs import Run
from sstl_cli.diagnosis import scaling
from sstl_cli.diagnosis.constants import DECIDABLE, LEAST_D2, NEAR_RIVALS, SETTLED, SIZE_NEAR, SIZE_ROUNDS
from sstl_cli.diagnosis.evidence import Weighed
from sstl_cli.diagnosis.fit import Fit, fit
from sstl_cli.diagnosis.following import span, strengths
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

    @property
    def settled(self) -> bool:
        """Whether the size is large enough, and not only as large as the effect gets."""
        return self.d2 >= SETTLED * DECIDABLE


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
    shown = sorted(least_shown(found, learned().shows_d2), key=lambda s: s.effect)
    rows = []
    for s, told in told_apart(found, shown):
        rows.append(_row(s, told, unit_n))
        advance(0.5 / len(shown))
    rows.sort(key=lambda r: r.gap_n)
    return Plan(tuple(rows), classes(rows), found.sim.problem)


def told_apart(found: Search, shown: Sequence[Shown], look: int = NEAR_RIVALS, alike: bool = True) -> Iterator[tuple[Shown, Told]]:
    """Yield for each effect that shows the rival that is nearest to it, refitted, and the size from which the two are told apart.

    Parameters
    ----------
    look : int
        How many of the rivals with the most similar response are refitted.
    alike : bool
        Whether all look-alikes are, too.
    """
    against = {e: w[0].fit for e, w in widest(found).singles.items()}
    spans = {e: span(strengths(found, f)) for e, f in against.items()}
    for s in shown:
        left = _left(found, s, spans)
        near = sorted(left, key=lambda r: (left[r], r))
        rivals = {r: against[r] for i, r in enumerate(near) if i < look or (alike and r in get(s.effect).look_alikes)}
        yield s, _told(found, s, rivals, min(left.values(), default=1.0))


def _left(found: Search, s: Shown, spans: Mapping[str, Array]) -> dict[str, float]:
    """Return which share of the square of what an effect shows each other one leaves, by linear responses."""
    own = _first(found, s.effect)
    names = [x.parameter.name for x in own.free if not x.parameter.shape]
    column = strengths(found, own)[:, names.index(s.parameter)]
    # what shows has a response
    whole = float(column @ column)
    return {e: 1.0 - float(np.sum((q.T @ column) ** 2)) / whole for e, q in spans.items() if e != s.effect}


def _first(found: Search, effect_id: str) -> Fit:
    """Return the model of an effect by which it is said what would have shown."""
    return next(w.fit for w in found.singles[effect_id] if w.fit.hypothesis.foretold)


def widest(found: Search) -> Search:
    """Return a search with one model of each effect, that of most strengths which foretells: what its parts can show it can, too."""
    fits = {e: [w for w in models if w.fit.hypothesis.foretold] for e, models in found.singles.items()}
    return replace(found, singles={e: (max(ws, key=lambda w: len(w.fit.hypothesis.strengths)),) for e, ws in fits.items() if ws})


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


def _told(found: Search, shown: Shown, rivals: Mapping[str, Fit], left: float) -> Told:
    """Return from which size an effect is told from its rivals, each refitted to what it shows; ``left``: share the nearest leaves.

    The linear picture gives a first size. Sizes that are too small and too large then close in on the one that is sought, as far as
    a power law between the two goes: of a delay and a low-pass the distance grows with the fourth power of the size.
    """
    own = _first(found, shown.effect)
    most = max(_reach(own, shown.parameter), shown.size)
    size = float(np.clip(shown.size / np.sqrt(max(left, 1e-6)), shown.size, most))
    low: Told | None = None
    high: Told | None = None
    for _ in range(SIZE_ROUNDS):
        truth = _sized(found.sim, own, shown.parameter, size)
        distances = {r: distance2(found.sim, truth, f) for r, f in rivals.items()}
        nearest = min(distances, key=lambda r: (distances[r], r), default=None)
        tried = Told(nearest, size, distances[nearest] if nearest else np.inf)
        near = abs(np.log(max(tried.d2, 1e-6) / DECIDABLE)) < SIZE_NEAR
        if nearest is None or near or size == (shown.size if tried.d2 >= DECIDABLE else most):
            return tried
        low, high = (low, tried) if tried.d2 >= DECIDABLE else (tried, high)
        size = float(np.clip(_between(low, high), shown.size, most))
    # what was seen to be enough, or how far that was from it
    told = high or low
    assert told is not None
    return told


def _between(low: Told | None, high: Told | None) -> float:
    """Return the size at which D^2 should be the one that decides, from one that is too small, one that is too large, or both."""
    if low is None or high is None:
        one = low or high
        assert one is not None
        return float(one.size * np.sqrt(DECIDABLE / max(one.d2, LEAST_D2)))
    least = max(low.d2, LEAST_D2)
    return float(low.size * (high.size / low.size) ** (np.log(DECIDABLE / least) / np.log(high.d2 / least)))


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
    return Planned(
        effect=shown.effect,
        parameter=shown.parameter,
        unit=shown.unit,
        least_size=scaling.parameter(shown.size, shown.unit, unit_n),
        gap_n=shown.gap_n * unit_n,
        shows=shown.size <= reach,
        rival=told.rival,
        told_size=scaling.parameter(told.size, shown.unit, unit_n) if told.settled and shown.size <= reach else None,
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
