"""How an accepted model of a rig varies along theta and the strengths of effects: learned from its record, applied to another."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from sstl_cli.diagnosis import scaling, wander
from sstl_cli.diagnosis.constants import PARAMETER_STEP, STRETCHES, THETA_STEP
from sstl_cli.diagnosis.evidence import Weighed
from sstl_cli.diagnosis.fit import Fit, normal_equations
from sstl_cli.diagnosis.free import ASIDE
from sstl_cli.diagnosis.latent import block_mean
from sstl_cli.diagnosis.records import Record
from sstl_cli.diagnosis.simulator import Effects, Simulator
from sstl_cli.diagnosis.state import turning
from sstl_cli.diagnosis.wander import nowhere
from sstl_cli.physics.effects import get
from sstl_cli.physics.scenario import Variation, WanderSection

Array = NDArray[np.float64]
Values = Mapping[str, Mapping[str, float]]


@dataclass(frozen=True)
class Ways:
    """The strengths along which a rig may vary, by effect and name, how far each is moved, and the shapes that are held."""

    strengths: tuple[tuple[str, str], ...]
    steps: tuple[float, ...]
    shapes: Values

    def section(self, sizes: Array) -> Variation:
        """Return standard deviations, theta first, as they are kept."""
        found: dict[str, dict[str, float]] = {}
        for (effect_id, name), size in zip(self.strengths, sizes[1:], strict=True):
            if size > 0.0:
                found.setdefault(effect_id, dict(self.shapes[effect_id]))[name] = float(size)
        return Variation(theta=float(sizes[0]), effects=found)


def ways(singles: Iterable[Sequence[Weighed]]) -> Ways:
    """Return the ways in which fitted effects could vary; of each effect the hypotheses, the most evident first.

    An effect's answer is not linear in its strengths: they are moved by as much as was fitted.
    """
    shapes: dict[str, dict[str, float]] = {}
    steps: dict[tuple[str, str], float] = {}
    for models in singles:
        effect_id = models[0].ids[0]
        for f in (m.fit for m in models):
            for x, v in zip(f.free, f.values, strict=True):
                if x.effect.id in ASIDE:
                    continue
                if x.parameter.shape:
                    shapes.setdefault(effect_id, {}).setdefault(x.parameter.name, float(v))
                else:
                    steps.setdefault((effect_id, x.parameter.name), float(v) - x.parameter.neutral)
        shapes.setdefault(effect_id, {})
    return Ways(tuple(steps), tuple(steps.values()), shapes)


def learned(sim: Simulator, accepted: Fit, own: Ways) -> WanderSection:
    """Return by how much an accepted model varied from stretch to stretch and from run to run of its record, in its own units."""
    records = sim.problem.records
    usual = float(np.median([_stretch_s(r) for r in records]))
    columns = directions(sim, accepted.theta, accepted.effects, own)
    runs = [np.arange(s.start, s.stop) for s in sim.slices()]
    stretches = [at[c] for r, at in zip(records, runs, strict=True) for c in _cut(r, usual)]
    seen, left = accepted.whiten(columns), accepted.whiten.left(accepted.residual)
    sizes = []
    for blocks in (stretches, runs):
        sizes.append(wander.components(seen, left, blocks))
        turn = wander.turned(seen * sizes[-1], blocks)
        seen, left = turn(seen), turn(left[:, None])[:, 0]
    return WanderSection(stretch_s=usual, stretch=own.section(sizes[0]), run=own.section(sizes[1]))


def of_the_whole(sim: Simulator, base: Fit, own: Ways) -> Variation:
    """Return by how much a model seems to be another one on its own record, where nothing has changed.

    Parameters
    ----------
    base : Fit
        The model on its own record, theta fitted.
    """
    columns = base.whiten(np.column_stack((base.jacobian[:, 0], directions(sim, base.theta, {}, own)[:, 1:])))
    left = base.whiten.left(base.residual)
    configs = len(base.theta)
    a, _ = normal_equations(sim, columns, left)
    a += 1e-9 * np.diag(np.diag(a) + 1e-12)
    # theta is fitted to every record: it takes its part of each
    follow = np.linalg.solve(a[:configs, :configs], a[:configs, configs:])
    apart = columns[:, 1:] - columns[:, :1] * follow[sim.config]
    sizes = wander.components(apart, left, [np.arange(len(left))])
    return own.section(np.concatenate(([0.0], sizes)))


def seen_in(whole: Variation, models: Iterable[Weighed]) -> Variation:
    """Return a variation that holds, too, what evident models of one effect have on the own record: what they do is not linear."""
    own = ways([w] for w in models if w.evidence > 0.0)
    seen = own.section(np.abs([0.0, *own.steps])).effects
    effects = {e: {**seen.get(e, {}), **whole.effects.get(e, {})} for e in (*whole.effects, *seen)}
    for effect_id, name in own.strengths:
        if name in seen.get(effect_id, {}):
            effects[effect_id][name] = max(seen[effect_id][name], whole.effects.get(effect_id, {}).get(name, 0.0))
    return whole.model_copy(update={"effects": effects})


def _stretch_s(r: Record) -> float:
    """Return how long a stretch of a record is (s): a part of it, and no shorter than a loop, within which nothing is alike."""
    whole = _duration_s(r)
    way, _ = turning(block_mean(r.u, r.factor))
    return max(whole / STRETCHES, 2.0 * whole / max(int(np.count_nonzero(np.diff(way))), 1))


def _cut(r: Record, stretch_s: float) -> list[slice]:
    return wander.cut(len(r), _duration_s(r), stretch_s)


def _duration_s(r: Record) -> float:
    return len(r) * r.dt_s * r.factor


def applied(sim: Simulator, theta: Array, section: WanderSection | None, unit_n: float) -> Simulator:
    """Return a simulator whose records know how the rig varies.

    Parameters
    ----------
    theta : ndarray, shape (configurations,)
        Where the directions are taken.
    unit_n : float
        What one N of the records is in the recording (see scaling).
    """
    if section is None:
        return sim
    here = rescaled(section, 1.0 / unit_n)
    stretch, run, whole = (_columns(sim, theta, v) for v in (here.stretch, here.run, here.whole))
    records = tuple(
        replace(
            r,
            wander=replace(
                r.wander or nowhere(len(r)), stretch=stretch[s], run=run[s], whole=whole[s], stretches=tuple(_cut(r, here.stretch_s))
            ),
        )
        for r, s in zip(sim.problem.records, sim.slices(), strict=True)
    )
    stretches = sum(len(r.wander.stretches) for r in records if r.wander is not None)
    usual = of_a_record(here, stretches, len(records))
    return replace(sim, problem=replace(sim.problem, records=records), usual=usual)


def of_a_record(section: WanderSection, stretches: int, runs: int) -> dict[tuple[str, str], float]:
    """Return by how much (standard deviation) each strength is off in a record of so many stretches and runs as a whole."""
    found: dict[tuple[str, str], float] = {}
    for v, count in ((section.stretch, stretches), (section.run, runs), (section.whole, 1)):
        for effect_id, name in _strengths(v):
            here = v.effects[effect_id][name] / np.sqrt(max(count, 1))
            found[effect_id, name] = float(np.hypot(found.get((effect_id, name), 0.0), here))
    return found


def _strengths(v: Variation) -> list[tuple[str, str]]:
    """Return the strengths along which something varies, by effect and name."""
    return [(e, k) for e, values in v.effects.items() for k in values if not get(e).parameter(k).shape]


def _columns(sim: Simulator, theta: Array, v: Variation) -> Array:
    """Return what one standard deviation of each way of a variation does to the output (N), shape (samples, k)."""
    strengths = _strengths(v)
    sizes = np.array([v.theta, *(v.effects[e][k] for e, k in strengths)])
    if not np.any(sizes):
        return np.zeros((len(sim.y), 0))
    shapes = {e: {k: x for k, x in values.items() if (e, k) not in strengths} for e, values in v.effects.items()}
    return np.asarray(directions(sim, theta, {}, Ways(tuple(strengths), tuple(sizes[1:].tolist()), shapes)) * sizes)


def rescaled(section: WanderSection, unit_n: float) -> WanderSection:
    """Return a section that was learned in units of ``unit_n`` (N) in newtons."""

    def of(v: Variation) -> Variation:
        return v.model_copy(update={"effects": {e: scaling.in_recording(e, values, unit_n) for e, values in v.effects.items()}})

    return section.model_copy(update={"stretch": of(section.stretch), "run": of(section.run), "whole": of(section.whole)})


def directions(sim: Simulator, theta: Array, present: Effects, own: Ways) -> Array:
    """Return d prediction / d (theta, strengths) about a model, shape (samples, 1 + k); a strength that is not there begins at neutral.

    Parameters
    ----------
    present : mapping
        Effects of the model beside those that the simulator contains.
    """
    base = sim.predict(theta, present)
    columns = [(sim.predict(theta + THETA_STEP, present) - base) / THETA_STEP]
    for (effect_id, name), far in zip(own.strengths, own.steps, strict=True):
        p = get(effect_id).parameter(name)
        values = {**own.shapes[effect_id], **present.get(effect_id, {})}
        at, least = values.get(name, p.neutral), PARAMETER_STEP * (p.high - p.low)
        up, down = p.most - at, at - p.least
        step = min(max(far, -down), up)
        if abs(step) < least:
            step = least if up >= down else -least
        moved = sim.predict(theta, {**present, effect_id: {**values, name: at + step}})
        columns.append((moved - base) / step)
    return np.column_stack(columns)
