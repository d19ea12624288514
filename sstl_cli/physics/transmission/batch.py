"""Many runs simulated in one compiled pass: law, propagation lines, transition."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from sstl_cli.core.errors import SstlError
from sstl_cli.physics.effect import Drive, Law, Mechanics, Transition
from sstl_cli.physics.transmission.active import Active
from sstl_cli.physics.transmission.envelope import Envelopes, Line, envelopes
from sstl_cli.physics.transmission.line import Geometry, elastic_lines, geometry, marched
from sstl_cli.physics.transmission.play import bounded_runs, play_runs
from sstl_cli.physics.transmission.state import Input, Lines

Array = NDArray[np.float64]
Counts = NDArray[np.int64]
TOP_STEP = 1.5
# friction of a pass (rad) that nothing comes through; a fit may ask for more, which must only stay a number
MOST_RAD = 50.0
# ids and values of the effects that make a law, and propagation lines by it and by what they are for
LawKey = tuple[tuple[str, tuple[tuple[str, float], ...]], ...]
Tables = dict[tuple[LawKey, tuple[Line, ...]], Envelopes]
ONE = np.ones(1)


@dataclass(frozen=True)
class Runs:
    """Runs laid end to end: run i has the samples ``edges[i]`` to ``edges[i + 1]`` of ``tension_n`` (N).

    ``knots`` are the samples, counted from each run's start, at which an elastic line is marched, ``steps_s`` apart.
    """

    drives: tuple[Drive, ...]
    edges: Counts
    tension_n: Array
    knots: Counts
    knot_edges: Counts
    steps_s: Array
    passes: Counts

    def __len__(self) -> int:
        return len(self.drives)

    @cached_property
    def preload_n(self) -> Array:
        """By how much (N) the tendon of each run is stretched where it reads nothing, shape (runs,)."""
        return np.array([d.mechanics.preload(d.system) for d in self.drives])

    def each(self, signal: Array) -> list[Array]:
        """Return a signal over all samples, run by run."""
        return [signal[a:b] for a, b in zip(self.edges[:-1], self.edges[1:], strict=True)]

    @cached_property
    def places(self) -> Geometry:
        """Nodes of the elastic lines; the load is not part of them."""
        return geometry([(d.system, d.location) for d in self.drives], self.drives[0].mechanics)


def laid(drives: Sequence[Drive]) -> Runs:
    """Return runs of one tube and tendon laid end to end."""
    edges = np.concatenate(([0], np.cumsum([len(d.tension_n) for d in drives])))
    knot_edges = np.concatenate(([0], np.cumsum([len(d.knots) for d in drives])))
    steps = [np.diff(d.time_s[d.knots], prepend=d.time_s[d.knots[0]] - d.dt_s) for d in drives]
    return Runs(
        tuple(drives),
        edges.astype(np.int64),
        np.concatenate([np.asarray(d.tension_n, np.float64) for d in drives]),
        np.concatenate([d.knots for d in drives]).astype(np.int64),
        knot_edges.astype(np.int64),
        np.concatenate(steps),
        np.array([d.passes for d in drives], np.int64),
    )


@dataclass(frozen=True)
class Case:
    """One set of parameters for runs.

    ``theta`` is mu Phi of one pass (rad), ``start_n`` the output tension before the first sample, NaN starts midway between the
    propagation lines; both have shape (runs,). True input tensions, the mechanics (for what the lines end at) and the loop's friction stand where they
    are not those of the runs.
    """

    theta: Array
    active: Active
    start_n: Array
    tension_n: Array | None = None
    mechanics: Mechanics | None = None
    loop_friction: float | None = None


def predict_runs(runs: Runs, cases: Sequence[Case]) -> list[Array]:
    """Return the true output tensions (N, shape (n,) each) of runs, end to end, for each case; elastic lines are marched together.

    A tendon of a pair carries the preload beside what is read of it.
    """
    tables: Tables = {}
    preload_n = np.repeat(runs.preload_n, np.diff(runs.edges)) if runs.preload_n.any() else None
    made = [_made(runs, case if preload_n is None else _stretched(runs, case, preload_n), tables) for case in cases]
    elastic = [m for m in made if isinstance(m, tuple)]
    out = iter(marched(elastic) if elastic else [])
    whole = [next(out) if isinstance(m, tuple) else m for m in made]
    return whole if preload_n is None else [x - preload_n for x in whole]


def _stretched(runs: Runs, case: Case, preload_n: Array) -> Case:
    """Return a case whose tensions are those of the tendon itself, not of what is read."""
    read = runs.tension_n if case.tension_n is None else case.tension_n
    return replace(case, tension_n=read + preload_n, start_n=case.start_n + runs.preload_n)


def _made(runs: Runs, case: Case, tables: Tables) -> Array | tuple[Input, Lines]:
    """Return the output of runs, or the elastic lines that have to be marched to it; cases of one law share their tables."""
    law, laws = Law(), case.active.of_hook("law")
    for effect, values in laws:
        effect.law(law, values)  # type: ignore[misc]
    bent = case.active.of_hook("transition")
    tension = runs.tension_n if case.tension_n is None else case.tension_n
    loop = runs.drives[0].mechanics.loop_friction if case.loop_friction is None else case.loop_friction
    theta = np.clip(np.where(runs.passes == 2, loop * case.theta, case.theta), -MOST_RAD, MOST_RAD)
    driven = [d.slip is not None for d in runs.drives]
    if not bent and law == Law() and not any(driven):
        angle = runs.passes * theta
        # a tendon cannot push: below zero the lines stay at zero, as they do with effects
        return play_runs(tension, runs.edges, np.exp(-angle), np.exp(angle), case.start_n)
    drives = runs.drives if case.mechanics is None else [replace(d, mechanics=case.mechanics) for d in runs.drives]
    if (bent or law.friction_scale or law.following_scale) and case.tension_n is not None:
        drives = [replace(d, tension_n=x) for d, x in zip(drives, runs.each(tension), strict=True)]
    transitions = [Transition() for _ in drives]
    for effect, values in bent:
        for transition, drive in zip(transitions, drives, strict=True):
            effect.transition(transition, values, drive)  # type: ignore[misc]
    level, following = _scale(law.friction_scale, drives), _scale(law.following_scale, drives)
    scale = level * following
    # where friction changes under a line that is held, what was pulled last gives way: a cascade of plays is no longer one
    if any(t != Transition() for t in transitions) or (level.size > 1 and not any(driven)):
        if any(driven):
            raise SstlError("effects of the transition need a run that is driven by its tension", code="E735")
        start = np.where(np.isnan(case.start_n), 0.5 * tension[runs.edges[:-1]], case.start_n)
        ends = np.array([d.mechanics.end_mm_per_n(d.system) for d in drives])
        into = Input(tension, runs.edges, runs.knots, runs.knot_edges, runs.steps_s, scale)
        return into, elastic_lines(into, runs.places, ends, theta, law, transitions, start)
    of_law = tuple((effect.id, tuple(values.items())) for effect, values in laws)

    def lines_of(wanted: tuple[Line, ...]) -> Envelopes:
        if (of_law, wanted) not in tables:
            tables[of_law, wanted] = envelopes(law, wanted, runs.drives[0].mechanics)
        return tables[of_law, wanted]

    return _between_lines(runs, theta, lines_of, scale, case.start_n, tension, np.array(driven))


def _scale(factors: Sequence[Callable[[Drive], Array]], drives: Sequence[Drive]) -> Array:
    """Return the product of factors on friction over all samples, one 1 where there is none."""
    if not factors:
        return ONE
    return np.concatenate(
        [np.broadcast_to(np.prod(np.broadcast_arrays(*(f(d) for f in factors)), axis=0), d.tension_n.shape) for d in drives]
    )


def _between_lines(
    runs: Runs,
    theta: Array,
    lines_of: Callable[[tuple[Line, ...]], Envelopes],
    scale: Array,
    start_n: Array,
    tension: Array,
    driven: NDArray[np.bool_],
) -> Array:
    """Return the play of every run between its propagation lines; a motion that drives a run says on which it is."""
    first = runs.edges[:-1]
    low, high = np.ones(len(runs)), np.ones(len(runs))
    if scale.size > 1:
        low, high = np.minimum.reduceat(scale, first), np.maximum.reduceat(scale, first)
    # runs of one bend share their table up to the next of a few tops
    peak = np.log(np.maximum(np.maximum.reduceat(tension, first), 1.0))
    top = TOP_STEP ** np.ceil(peak / np.log(TOP_STEP))
    wanted: dict[Line, int] = {}
    table = np.array([
        wanted.setdefault(Line(float(t), d.system, d.location, float(x), float(a), float(b)), len(wanted))
        for t, d, x, a, b in zip(theta, runs.drives, top, low, high, strict=True)
    ])  # fmt: skip
    lines = lines_of(tuple(wanted))

    def between(lower: Array, upper: Array) -> Array:
        return bounded_runs(
            tension, runs.edges, table, lower, upper, lines.edges, lines.tension_step_n, scale, lines.scale0,
            lines.scale_step, start_n,
        )  # fmt: skip

    if not driven.any():
        return between(lines.pull, lines.release)
    slip = np.concatenate([np.zeros(len(d.tension_n)) if d.slip is None else d.slip for d in runs.drives])
    moved = np.where(slip > 0.0, between(lines.pull, lines.pull), between(lines.release, lines.release))
    if driven.all():
        return moved
    return np.where(np.repeat(driven, np.diff(runs.edges)), moved, between(lines.pull, lines.release))
