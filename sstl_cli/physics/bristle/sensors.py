"""Sensors and recorder: effect by effect what they make of the true tensions, and their noise."""

from __future__ import annotations

import numpy as np
from numba import njit

from sstl_cli.physics.bristle.effect import FloatArray, Reading
from sstl_cli.physics.bristle.effects import catalogue
from sstl_cli.physics.given import NoiseSpec, Values


@njit(cache=True)
def wander(time: FloatArray, kicks: FloatArray, correlation: float) -> FloatArray:
    """Ornstein-Uhlenbeck noise of unit variance from unit kicks."""
    seen = kicks.copy()
    for n in range(1, kicks.size):
        keep = np.exp((time[n - 1] - time[n]) / correlation)
        seen[n] = keep * seen[n - 1] + np.sqrt(1.0 - keep**2) * kicks[n]
    return seen


def _noise(time: FloatArray, noise: NoiseSpec, rng: np.random.Generator) -> FloatArray:
    white, kicks = rng.standard_normal((2, time.size))
    found: FloatArray = noise.white_n * white + noise.coloured_n * wander(time, kicks, noise.correlation_s)
    return found


def record(
    time: FloatArray, truth: tuple[FloatArray, FloatArray, FloatArray], values: Values, system: str, noise: NoiseSpec, seed: int
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Time stamps (s), tensions in and out (N) and position (mm) as the recorder stores them, each of shape (n,).

    `truth` holds the same three without sensors. Sensors are late or jitter before their noise comes in, which is that
    of the converter; every source of chance has its own stream, so that one effect does not change another's.
    """
    names = ("in", "out", "position", "clock", "faults")
    streams = {name: np.random.default_rng([seed, k]) for k, name in enumerate(names)}
    effects = [(effect, values[name]) for name, effect in catalogue().items()]
    seen = Reading(system, time, *truth, stamps=time, clock=streams["clock"], faults=streams["faults"])
    for effect, v in effects:
        effect.sense(seen, v)
    seen.t_in, seen.t_out = seen.t_in + seen.zero_in, seen.t_out + seen.zero_out
    for effect, v in effects:
        effect.sample(seen, v)
    jittered = seen.stamps is not time
    if jittered:
        seen.t_in, seen.x = np.interp(seen.stamps, time, seen.t_in), np.interp(seen.stamps, time, seen.x)
    if seen.late_s > 0.0 or jittered:
        seen.t_out = np.interp(seen.stamps - seen.late_s, time, seen.t_out)
    seen.t_in = seen.t_in + _noise(time, noise, streams["in"])
    seen.t_out = seen.t_out + _noise(time, noise, streams["out"])
    seen.x = seen.x + noise.position_mm * streams["position"].standard_normal(time.size)
    for effect, v in effects:
        effect.store(seen, v)
    return seen.stamps, seen.t_in, seen.t_out, seen.x
