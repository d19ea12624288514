"""Slow noise of the sensor of the input: told from the input's own readings, and kept out of what drives the line.

A smoother that takes all noise for white follows the slow part of it, and what the line is then said to have been driven by
is off by far more than is stated. Told of it, the smoother leaves it to the sensor as far as that is likely, and states what it
does not know.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

from sstl_cli.diagnosis import noise as noise_of
from sstl_cli.diagnosis.constants import (
    ALIKE,
    AT_MOST,
    DECIDES_NATS,
    EDGE,
    ENOUGH,
    HEARD_NEAR,
    HEARD_S,
    HEARD_TIMES_S,
    HEARD_TRIES,
    LEVELS,
    MEASURED,
    PARTS,
    SHORT_ITERATIONS,
    UNKNOWN_COLOUR,
    UNSEEN,
)
from sstl_cli.diagnosis.fit import Fit, fit
from sstl_cli.diagnosis.latent import Slow
from sstl_cli.diagnosis.records import Record, content, sampled_nats, told
from sstl_cli.diagnosis.simulator import Simulator
from sstl_cli.diagnosis.whitening import Noise, Sensor

Array = NDArray[np.float64]
NO_DEARER: Mapping[str, float] = MappingProxyType({})


def heard(sim: Simulator, coarse: Sequence[Fit], measured: Noise) -> tuple[Simulator, Fit, Noise, Noise]:
    """Return simulator, base, noise and what is measured of it; where the input's sensor has slow noise, the input is smoothed again, told of it.

    Its readings tell how much of it there is for each time that it may last; how long that is, and whether it is the sensor's at all,
    tells the output: not where that follows the input as it was smoothed before more closely (then what is slow moves the line as
    well), nor where it is still left with more than noise. Every way the same models are asked, with the same columns projected out.
    """
    moved = columns(sim, coarse)
    asked = _Asked(sim, tuple(coarse), measured, moved, *_likely(sim, coarse, measured, moved))
    noise, runs = asked.noise, _smoothed(sim.problem.records, asked.noise.output)
    seen = [entering(runs, noise, measured, tau) for tau in HEARD_TIMES_S]
    # readings of a movement that is not quite smooth take some of the noise for movement: what comes out may know better
    for sensors in (*seen, _alike(noise, measured, runs)):
        asked = asked.told_of(sensors)
    if noise_of.strain(asked.noise, measured) > 1.0:
        for sensors, dearer in _louder({k: part for k, part in runs.items() if k not in asked.told}, noise.input):
            asked = asked.told_of(sensors, dearer)
    if not asked.told:
        return sim, coarse[0], noise, measured
    sim, noise = asked.sim, asked.noise
    base = fit(sim, coarse[0].whiten, coarse[0].hypothesis, coarse[0].theta, coarse[0].values, SHORT_ITERATIONS)
    return sim, base, noise, replace(measured, input={**measured.input, **{k: noise.input[k] for k in asked.told}})


@dataclass(frozen=True)
class _Asked:
    """The simulator whose smoother was told of what the output likes best so far, the noise beside it and its cost (nats) by system."""

    sim: Simulator
    coarse: tuple[Fit, ...]
    measured: Noise
    columns: Array
    noise: Noise
    nats: dict[str, float]
    told: frozenset[str] = frozenset()

    def told_of(self, sensors: Mapping[str, Sensor], dearer: Mapping[str, float] = NO_DEARER) -> _Asked:
        """Return what is liked best once these sensors of inputs were tried, system by system, at what they cost (nats) besides."""
        if not sensors:
            return self
        problem = told(self.sim.problem, {k: Slow(s.coloured_n, s.correlation_s) for k, s in sensors.items()})
        believed = replace(self.measured, input={**self.measured.input, **sensors}, spread=self.noise.spread)
        found, cost = _likely(replace(self.sim, problem=problem), self.coarse, believed, self.columns)
        cost = {k: v + dearer.get(k, 0.0) for k, v in cost.items()}
        # an input explains what noise of the output had to take up only if that is then what was measured
        better = {k for k in sensors if cost[k] < self.nats[k] and _is_noise(k, found, self.measured)}
        pairs = zip(self.sim.problem.records, problem.records, strict=True)
        records = tuple(b if b.system in better else a for a, b in pairs)
        return replace(
            self,
            sim=replace(self.sim, problem=replace(problem, records=records)),
            noise=_either(found, self.noise, better),
            nats={k: cost[k] if k in better else v for k, v in self.nats.items()},
            told=self.told | better,
        )


def _alike(noise: Noise, measured: Noise, systems: Collection[str]) -> dict[str, Sensor]:
    """Return sensors of inputs whose slow noise is that of the output beside, where that is seen: sensors of a rig are mostly alike."""
    out = {k: noise.output[k] for k in systems if _is_noise(k, noise, measured)}
    seen = {k: s for k, s in out.items() if s.coloured_n > UNSEEN * s.white_n}
    return {k: replace(noise.input[k], coloured_n=s.coloured_n, correlation_s=s.correlation_s) for k, s in seen.items()}


def _louder(runs: Mapping[str, Sequence[Record]], inputs: Mapping[str, Sensor]) -> Iterator[tuple[dict[str, Sensor], dict[str, float]]]:
    """Yield sensors of inputs that are louder and louder, and what that costs (nats) by their own readings, beyond what decides.

    Fast movement is not as smooth as the law of the latent input has it, and its readings say little of slow noise.
    """
    lasting_s = HEARD_TIMES_S[1]
    quiet = {k: _readings_nats(part, LEVELS[0] * inputs[k].white_n, lasting_s) for k, part in runs.items()}
    for level in LEVELS[LEVELS > UNKNOWN_COLOUR][::2] if runs else ():
        sensors = {k: replace(inputs[k], coloured_n=level * inputs[k].white_n, correlation_s=lasting_s) for k in runs}
        nats = {k: _readings_nats(runs[k], s.coloured_n, lasting_s) - quiet[k] + DECIDES_NATS for k, s in sensors.items()}
        yield sensors, nats


def _is_noise(system: str, noise: Noise, measured: Noise) -> bool:
    """Whether the slow noise of an output stayed as it was measured; where it had to leave that as far as it may the models miss more than noise."""
    off = abs(float(np.log(noise.output[system].coloured_n / measured.output[system].coloured_n)))
    return off < (1.0 - EDGE) * AT_MOST * measured.open.get(system, MEASURED)


def _either(one: Noise, other: Noise, those: set[str]) -> Noise:
    """Return the one noise of those systems, and the other of the rest."""
    parts = ("input", "output", "smoother", "spread", "wanders")
    return replace(other, **{p: {k: getattr(one if k in those else other, p)[k] for k in getattr(other, p)} for p in parts})


def beside(sim: Simulator, fits: Sequence[Fit], measured: Noise) -> Noise:
    """Return the most likely noise in what fits together leave: the base, the best one and others."""
    return _likely(sim, fits, measured, columns(sim, fits))[0]


def _leading(coarse: Sequence[Fit]) -> Fit:
    return coarse[1] if len(coarse) > 1 else coarse[0]


def columns(sim: Simulator, coarse: Sequence[Fit]) -> Array:
    """Return what the best few models could still change, shape (samples, k)."""
    base, best = coarse[0], _leading(coarse)
    own = np.zeros((len(sim.y), len(base.theta)))
    own[np.arange(len(sim.y)), sim.config] = best.jacobian[:, 0]
    found = np.concatenate([own, best.jacobian[:, 1:], *(f.jacobian[:, 1:] for f in coarse[2:])], axis=1)
    return np.asarray(found[:, np.any(found * sim.weight[:, None] != 0.0, axis=0)])


def _likely(sim: Simulator, coarse: Sequence[Fit], measured: Noise, columns: Array) -> tuple[Noise, dict[str, float]]:
    """Return the most likely noise in what the best few models together leave, by the phases of the best, and its cost by system."""
    best = _leading(coarse)
    phases = sim.phases(best.theta, best.effects, measured)
    return noise_of.likely(sim.problem.records, phases, sim.y - sim.predict(best.theta, best.effects), columns, measured)


def entering(runs: Mapping[str, Sequence[Record]], noise: Noise, measured: Noise, lasting_s: float) -> dict[str, Sensor]:
    """Return the sensors of the inputs whose slow noise shows in the readings of their ``runs`` if it lasts so long (s), by system.

    The input is smooth but for few corners (see latent): what wanders beside is the sensor's.
    """
    found = {}
    for system, part in runs.items():
        out = (noise if _is_noise(system, noise, measured) else measured).output[system]
        sensor, nats = _likeliest(part, noise.input[system], out, lasting_s)
        if nats > DECIDES_NATS:
            found[system] = sensor
    return found


def _smoothed(records: Sequence[Record], systems: Collection[str]) -> dict[str, list[Record]]:
    """Return a few runs of each system, since how well slow noise shows depends on the movement; an input without noise was not smoothed."""
    found = {}
    for system in systems:
        own = sorted((r for r in records if r.system == system), key=content)
        part = own[:: -(-len(own) // PARTS)]
        if all(r.error_n.any() for r in part):
            found[system] = part
    return found


def _readings_nats(records: Sequence[Record], coloured_n: float, lasting_s: float) -> float:
    """Return minus the log likelihood of the readings of inputs beside slow noise of a size (N) that lasts so long (s)."""
    most, slow = ENOUGH // len(records), Slow(coloured_n, lasting_s)
    return sum(sampled_nats(r, max(1, round(HEARD_S / r.raw.dt_s)), most, slow) for r in records)


def _likeliest(records: Sequence[Record], into: Sensor, out: Sensor, lasting_s: float) -> tuple[Sensor, float]:
    """Return the sensor of an input as its readings have it, and by how much (nats) they do rather than without slow noise.

    Mostly it is as loud as that of the output (Cauchy's prior of the logarithm, as in holds).
    """
    like = np.log(max(out.coloured_n, LEVELS[0] * into.white_n))

    def unlike(level: float) -> float:
        return float(np.log1p(((level - like) / ALIKE) ** 2))

    def cost(level: float) -> float:
        return _readings_nats(records, float(np.exp(level)), lasting_s) + unlike(level)

    # as loud as that of the output and as its own readings have it are two valleys
    levels = np.unique([*np.log(LEVELS[::2] * into.white_n), like])
    costs = np.array([cost(x) for x in levels])
    at, quiet = int(np.argmin(costs)), float(costs[0]) - unlike(levels[0])
    level, least, near = float(levels[at]), float(costs[at]), slice(max(at - 1, 0), at + 2)
    # a valley falls between two levels no further than it has risen beside them: what then decides nothing is not looked for
    gaps = np.diff(levels[near])
    deepest = least - float(np.max(np.abs(np.diff(costs[near])) / gaps) * np.max(gaps))
    if quiet - deepest > DECIDES_NATS:
        options = {"maxiter": HEARD_TRIES, "xatol": HEARD_NEAR}
        found = minimize_scalar(cost, bounds=tuple(levels[near][[0, -1]]), method="bounded", options=options)
        level, least = (float(found.x), float(found.fun)) if found.fun < least else (level, least)
    # the lowest level is none
    return Sensor(into.white_n, float(np.exp(level)), lasting_s), quiet - least
