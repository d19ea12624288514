"""Sensors and recorder: effect by effect what they make of the true tensions, and their noise."""

from __future__ import annotations

import numpy as np
from numba import njit

from sstl_cli.physics.given import NoiseSpec, Values
from sstl_cli.physics.rig.effect import FloatArray, Reading
from sstl_cli.physics.rig.effects import catalogue


@njit(cache=True)
def coloured(time: FloatArray, white: FloatArray, correlation: float) -> FloatArray:
    """First-order Gauss-Markov noise of unit variance with autocorrelation exp(-|lag| / correlation)."""
    out = np.empty_like(white)
    out[0] = white[0]
    for n in range(1, white.size):
        decay = np.exp(-(time[n] - time[n - 1]) / correlation)
        out[n] = decay * out[n - 1] + np.sqrt(1.0 - decay * decay) * white[n]
    return out


def sensor_noise(time: FloatArray, noise: NoiseSpec, rng: np.random.Generator) -> FloatArray:
    """White plus coloured tension noise of one sensor, shape (n,), N."""
    white = rng.standard_normal(time.size)
    slow = coloured(time, rng.standard_normal(time.size), noise.correlation_s)
    return noise.white_n * white + noise.coloured_n * slow


def record(
    time: FloatArray, truth: tuple[FloatArray, FloatArray, FloatArray], values: Values, system: str, noise: NoiseSpec, seed: int
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Time stamps (s), tensions in and out (N) and position (mm) as the recorder stores them, each of shape (n,).

    `truth` holds the same three without sensors; tension out is late by the channel delay.

    Every sensor draws from its own random stream, so that one effect does not change the noise of another sensor.
    """
    streams = [np.random.default_rng(child) for child in np.random.SeedSequence(seed).spawn(5)]
    effects = [(effect, values[name]) for name, effect in catalogue().items()]
    seen = Reading(system, time, *truth, stamps=time, clock=streams[3], faults=streams[4])
    for effect, v in effects:
        effect.sense(seen, v)
    seen.t_in = seen.t_in + sensor_noise(time, noise, streams[0])
    seen.t_out = seen.t_out + sensor_noise(time, noise, streams[1])
    seen.x = seen.x + noise.position_mm * streams[2].standard_normal(time.size)
    for effect, v in effects:
        effect.sample(seen, v)
    jittered = not np.array_equal(seen.stamps, time)
    if jittered:
        seen.t_in, seen.x = np.interp(seen.stamps, time, seen.t_in), np.interp(seen.stamps, time, seen.x)
    if seen.late_s > 0.0 or jittered:
        seen.t_out = np.interp(seen.stamps - seen.late_s, time, seen.t_out)
    for effect, v in effects:
        effect.store(seen, v)
    return seen.stamps, seen.t_in, seen.t_out, seen.x
