"""An output that is no force has a scale and an origin that are nobody's fault: they are found and taken out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from sstl_cli.core.runs import Run
from sstl_cli.diagnosis.constants import DECIDES_NATS, LEADERS, SCALE_ROUNDS
from sstl_cli.diagnosis.evidence import strengths_charge
from sstl_cli.diagnosis.fit import Fit, first_theta, fit, settle
from sstl_cli.diagnosis.found import Search
from sstl_cli.diagnosis.free import free_parameters
from sstl_cli.diagnosis.hypotheses import Hypothesis
from sstl_cli.diagnosis.records import prepare
from sstl_cli.diagnosis.simulator import Simulator
from sstl_cli.diagnosis.whitening import white
from sstl_cli.physics.effect import Mechanics
from sstl_cli.physics.scenario import OutputScale

Array = NDArray[np.float64]
NEWTON = "N"


@dataclass(frozen=True)
class Scale:
    """Units of the output a newton of it, by system, its origin in its own unit, and the unit."""

    unit: str
    per_n: dict[str, float]
    origin: dict[str, float]

    def zeros_n(self, unit_n: float) -> dict[str, float]:
        """Return at which tension (N of the fit, of which one is ``unit_n`` of the recording) the output of each system reads nothing."""
        return {s: -self.origin[s] / (self.per_n[s] * unit_n) for s in self.per_n}

    @property
    def typical(self) -> float:
        """Units a newton, the median over the systems."""
        return float(np.median(list(self.per_n.values())))


def scale_of(runs: Sequence[Run], preload_n: Mapping[str, float] = MappingProxyType({})) -> Scale | None:
    """Return the scale of outputs that are declared in another unit than newtons, None where they are newtons.

    Parameters
    ----------
    preload_n : mapping of system to float
        By how much tendons are stretched where they read nothing (N).
    """
    units = sorted({r.unit_out for r in runs})
    if units == [NEWTON]:
        return None
    systems = sorted({r.system for r in runs})
    per_n, origin = {}, {}
    for system in systems:
        own = [r for r in runs if r.system == system]
        # the span of an output is that of its input times exp(-+theta): a factor of a few at most
        per_n[system] = (
            float(np.median([np.ptp(np.nan_to_num(r.tension_out_n)) / max(np.ptp(np.nan_to_num(r.tension_in_n)), 1e-9) for r in own]))
            or 1.0
        )
        origin[system] = 0.0
    found = Scale(", ".join(units), per_n, origin)
    for _ in range(SCALE_ROUNDS):
        found = _refined(runs, found, preload_n)
    return found


def given(runs: Sequence[Run], output: OutputScale | None) -> Scale | None:
    """Return the scale of an accepted model, None where it has none, or not for these outputs."""
    units = {r.unit_out for r in runs}
    if output is None or ", ".join(sorted(units)) != output.unit or not {r.system for r in runs} <= set(output.per_n):
        return None
    return Scale(output.unit, dict(output.per_n), dict(output.origin))


def in_newtons(runs: Sequence[Run], scale: Scale) -> list[Run]:
    """Return runs with their outputs in newtons."""
    return [replace(r, tension_out_n=(r.tension_out_n - scale.origin[r.system]) / scale.per_n[r.system]) for r in runs]


def _refined(runs: Sequence[Run], scale: Scale, preload_n: Mapping[str, float]) -> Scale:
    """Return the scale after one fit of gain and zero of the output beside theta."""
    problem = prepare(in_newtons(runs, scale))
    sim = Simulator(problem, Mechanics(preload_n=preload_n))
    h = _reading(problem.systems)
    plain = white(1.0, sim.weight, [s.start for s in sim.slices()])
    theta = first_theta(sim, np.full(len(problem.configs), 0.5))
    return _moved(scale, fit(sim, plain, h, theta, _neutral(h)))


def beside(found: Search, scale: Scale) -> Scale | None:
    """Return the scale beside a single cause, None where no cause with another scale is likelier than the leading model on this one.

    A lag or friction that the base lacks is taken for a part of the scale, and what is left of it for other causes.
    """
    sim, lead = found.sim, next(iter(found.ranked()), None)
    if lead is None or lead.evidence <= DECIDES_NATS:
        return None
    h = _reading(sim.problem.systems)
    alone = sorted((g[0] for g in found.singles.values() if not set(h.ids) & set(g[0].ids)), key=lambda w: -w.evidence)
    starts = [(w.fit, w.fit.hypothesis.joined(h), np.concatenate((w.fit.values, _neutral(h)))) for w in alone[:LEADERS]]
    tried = [fit(sim, f.whiten, joined, f.theta, values) for f, joined, values in starts]
    best = min((settle(sim, found.noise, f) for f in tried), key=lambda f: f.cost, default=lead.fit)
    gain = lead.fit.cost - best.cost
    return _moved(scale, best, sim.problem.unit_n) if gain - strengths_charge(len(h.free), 2.0 * gain) > DECIDES_NATS else None


def _reading(systems: Sequence[str]) -> Hypothesis:
    """Return gain and zero of every output."""
    ids = ("gain_error", "zero_offset")
    return Hypothesis(ids, tuple(f for f in free_parameters(ids, systems) if f.effect.id == ids[0] or f.parameter.name.startswith("z_out")))


def _neutral(h: Hypothesis) -> Array:
    return np.array([f.parameter.neutral for f in h.free])


def _moved(scale: Scale, done: Fit, unit_n: float = 1.0) -> Scale:
    """Return a scale after a fit of gain and zero on it, whose newtons are ``unit_n`` of the recording's: what is read is gain times force plus zero."""
    values = {f.parameter.name: float(v) for f, v in zip(done.free, done.values, strict=True)}
    per_n = {s: scale.per_n[s] * values.get(f"g_{s}", 1.0) for s in scale.per_n}
    origin = {s: scale.origin[s] + scale.per_n[s] * unit_n * values.get(f"z_out_{s}_n", 0.0) for s in scale.per_n}
    return Scale(scale.unit, per_n, origin)
