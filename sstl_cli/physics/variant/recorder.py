"""Sensors and recorder: effect by effect what they make of the true tensions, and their noise."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from scipy.signal import lfilter

from sstl_cli.physics.given import NoiseSpec, Values
from sstl_cli.physics.variant.effect import Reading
from sstl_cli.physics.variant.effects import catalogue
from sstl_cli.physics.variant.laws import Chosen
from sstl_cli.physics.variant.line import Array
from sstl_cli.physics.variant.spec import VariantRun


def sensor_noise(time: Array, noise: NoiseSpec, rng: np.random.Generator) -> Array:
    """Return white plus first-order coloured noise of one sensor (N)."""
    white = noise.white_n * rng.standard_normal(time.size)
    if noise.coloured_n == 0.0:
        return white
    decay = float(np.exp(-np.median(np.diff(time)) / noise.correlation_s))
    drive = np.sqrt(1.0 - decay**2) * rng.standard_normal(time.size)
    drive[0] = rng.standard_normal()
    return np.asarray(white + noise.coloured_n * lfilter([1.0], [1.0, -decay], drive))


def read(
    run: VariantRun, truth: tuple[Array, Array, Array], v: Values, laws: Mapping[str, Chosen], noise: NoiseSpec, seed: int
) -> tuple[Array, Array, Array, Array]:
    """Return time stamps (s), tensions in and out (N) and position (mm) as the recorder stores them, each (n,).

    `truth` holds the last three without sensors. Every source of chance has its own stream.
    """
    time = run.time_s
    drift, first, second, place, clock, late, fault = (np.random.default_rng(child) for child in np.random.SeedSequence(seed).spawn(7))
    effects = [(effect, v[name], laws[name]) for name, effect in catalogue().items()]
    seen = Reading(run.system, run.theta, time, *truth[:2], *truth, time, time, drift, clock, late, fault)
    for effect, values, law in effects:
        effect.sense(seen, values, law)
    seen.t_in = seen.t_in + sensor_noise(time, noise, first)
    seen.t_out = seen.t_out + sensor_noise(time, noise, second)
    seen.x = seen.x + noise.position_mm * place.standard_normal(time.size)
    for effect, values, law in effects:
        effect.sample(seen, values, law)
    if seen.stamps is not time:
        seen.t_in, seen.x = np.interp(seen.stamps, time, seen.t_in), np.interp(seen.stamps, time, seen.x)
    if seen.read_at is not time:
        seen.t_out = np.interp(seen.read_at, time, seen.t_out)
    for effect, values, law in effects:
        effect.store(seen, values, law)
    return seen.stamps, seen.t_in, seen.t_out, seen.x
