"""Slow noise of the sensor of the input: told from the input's own readings, and kept out of what drives the line.

A smoother that takes all noise for white follows the slow part of it, and what the line is then said to have been driven by
is off by far more than is stated. Told of it, the smoother leaves it to the sensor as far as that is likely, and states what it
does not know.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from sstl_cli.diagnosis import noise as noise_of
from sstl_cli.diagnosis.constants import (
    ALIKE,
    AT_MOST,
    EDGE,
    ENOUGH,
    FLAT,
    HEARD_NEAR,
    HEARD_S,
    HEARD_TRIES,
    MEASURED,
    SHORT_ITERATIONS,
    UNMEASURED,
    UNSEEN,
)
from sstl_cli.diagnosis.fit import Fit, fit
from sstl_cli.diagnosis.latent import Slow
from sstl_cli.diagnosis.noise import some
from sstl_cli.diagnosis.records import Record, sampled, told
from sstl_cli.diagnosis.simulator import Simulator
from sstl_cli.diagnosis.whitening import Noise, Sensor

Array = NDArray[np.float64]


def heard(sim: Simulator, coarse: Sequence[Fit], measured: Noise) -> tuple[Simulator, Fit, Noise]:
    """Return simulator, base and noise; where the input's sensor has slow noise, the input is smoothed again, told of it.

    Not where the output follows the input as it was smoothed before more closely: then what is slow moves the line as well.
    Every way the same models are asked, with the same columns projected out.
    """
    columns = _columns(sim, coarse)
    noise, nats = _likely(sim, coarse, measured, columns)
    own = entering(sim.problem.records, noise, measured)
    plain, told_of = sim.problem, set[str]()
    # readings of a movement that is not quite smooth take some of the noise for movement: what comes out may know better
    for sensors in (own, _alike(own, noise)) if own else ():
        problem = told(plain, {k: Slow(s.coloured_n, s.correlation_s) for k, s in sensors.items()})
        believed = replace(measured, input={**measured.input, **sensors}, spread=noise.spread)
        found, cost = _likely(replace(sim, problem=problem), coarse, believed, columns)
        better = {k for k in sensors if cost[k] < nats[k]}
        pairs = zip(sim.problem.records, problem.records, strict=True)
        sim = replace(sim, problem=replace(problem, records=tuple(b if b.system in better else a for a, b in pairs)))
        noise, nats = _either(found, noise, better), {k: cost[k] if k in better else v for k, v in nats.items()}
        told_of |= better
    if not told_of:
        return sim, coarse[0], noise
    base = fit(sim, coarse[0].whiten, coarse[0].hypothesis, coarse[0].theta, coarse[0].values, SHORT_ITERATIONS)
    return sim, base, noise


def _alike(sensors: dict[str, Sensor], noise: Noise) -> dict[str, Sensor]:
    """Return sensors of inputs whose slow noise is that of the output beside: sensors of a rig are alike."""
    out = noise.output
    return {k: replace(s, coloured_n=out[k].coloured_n, correlation_s=out[k].correlation_s) for k, s in sensors.items()}


def _either(one: Noise, other: Noise, those: set[str]) -> Noise:
    """Return the one noise of those systems, and the other of the rest."""
    parts = ("input", "output", "smoother", "spread", "wanders")
    return replace(other, **{p: {k: getattr(one if k in those else other, p)[k] for k in getattr(other, p)} for p in parts})


def beside(sim: Simulator, fits: Sequence[Fit], measured: Noise) -> Noise:
    """Return the most likely noise in what fits together leave: the base, the best one and others."""
    return _likely(sim, fits, measured, _columns(sim, fits))[0]


def _leading(coarse: Sequence[Fit]) -> Fit:
    return coarse[1] if len(coarse) > 1 else coarse[0]


def _columns(sim: Simulator, coarse: Sequence[Fit]) -> Array:
    """Return what the best few models could still change, shape (samples, k)."""
    base, best = coarse[0], _leading(coarse)
    own = np.zeros((len(sim.y), len(base.theta)))
    own[np.arange(len(sim.y)), sim.config] = best.jacobian[:, 0]
    columns = np.concatenate([own, best.jacobian[:, 1:], *(f.jacobian[:, 1:] for f in coarse[2:])], axis=1)
    return np.asarray(columns[:, np.any(columns * sim.weight[:, None] != 0.0, axis=0)])


def _likely(sim: Simulator, coarse: Sequence[Fit], measured: Noise, columns: Array) -> tuple[Noise, dict[str, float]]:
    """Return the most likely noise in what the best few models together leave, by the phases of the best, and its cost by system."""
    best = _leading(coarse)
    phases = sim.phases(best.theta, best.effects, measured)
    return noise_of.likely(sim.problem.records, phases, sim.y - sim.predict(best.theta, best.effects), columns, measured)


def entering(records: Sequence[Record], noise: Noise, measured: Noise) -> dict[str, Sensor]:
    """Return the sensors of the inputs whose slow noise can be told from their own readings, by system.

    The input is smooth but for few corners (see latent): what wanders beside is the sensor's. Sensors of a rig are alike, so
    that of the output is where to look; not where it had to leave what was measured for as far as it may: then the models miss
    more than noise, and what is known of it is little.
    """
    found = {}
    for system, out in noise.output.items():
        wide = measured.open.get(system, MEASURED)
        off = abs(float(np.log(out.coloured_n / measured.output[system].coloured_n)))
        if out.coloured_n > UNSEEN * out.white_n and off < (1.0 - EDGE) * AT_MOST * wide:
            part = [r for r, _ in some([(r, slice(0, len(r))) for r in records if r.system == system])]
            # an input without noise was not smoothed
            if all(r.error_n.any() for r in part):
                found[system] = _likeliest(part, noise.input[system], out)
    return found


def _likeliest(records: Sequence[Record], into: Sensor, out: Sensor) -> Sensor:
    def sensor(p: Array) -> Sensor:
        size, slow = (float(v) for v in np.exp(np.clip(p, -AT_MOST * UNMEASURED, AT_MOST * ALIKE)))
        return Sensor(into.white_n, out.coloured_n * size, out.correlation_s * slow)

    def cost(p: Array) -> float:
        s = sensor(p)
        slow, left, nats = Slow(s.coloured_n, s.correlation_s), ENOUGH // 2, 0.0
        for r in records:
            if left > 0:
                every = max(1, round(HEARD_S / r.raw.dt_s))
                nats += sampled(r, every, left, slow).nats
                left -= len(r.raw) // every
        return nats + 0.5 * float(np.sum((p / ALIKE) ** 2))

    options = {
        "initial_simplex": ALIKE * np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]),
        "maxfev": HEARD_TRIES,
        "xatol": HEARD_NEAR,
        "fatol": FLAT,
    }
    return sensor(np.asarray(minimize(cost, np.zeros(2), method="Nelder-Mead", options=options).x))
