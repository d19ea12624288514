"""Sensors: what they make of the true tensions, effect by effect, by laws other than the catalogue's."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numba import njit
from scipy.signal import lfilter

from sstl_cli.physics.given import NoiseSpec, Values
from sstl_cli.physics.variant.filters import second_order, sliding_mean
from sstl_cli.physics.variant.laws import Chosen
from sstl_cli.physics.variant.line import Array

FULL_SCALE_N = 50.0
NOMINAL_THETA = 0.53
BUTTERWORTH = 0.5**0.5
Laws = Mapping[str, Chosen]


@njit(cache=True)
def held_play(signal: Array, half_width: float) -> Array:
    """Return a signal behind a play of +-half_width (N)."""
    out = signal.copy()
    for n in range(1, signal.size):
        out[n] = min(max(out[n - 1], signal[n] - half_width), signal[n] + half_width)
    return out


def sensor_noise(time: Array, noise: NoiseSpec, rng: np.random.Generator) -> Array:
    """Return white plus first-order coloured noise of one sensor (N)."""
    white = noise.white_n * rng.standard_normal(time.size)
    if noise.coloured_n == 0.0:
        return white
    decay = float(np.exp(-np.median(np.diff(time)) / noise.correlation_s))
    drive = np.sqrt(1.0 - decay**2) * rng.standard_normal(time.size)
    drive[0] = rng.standard_normal()
    return np.asarray(white + noise.coloured_n * lfilter([1.0], [1.0, -decay], drive))


def transduce(
    time: Array, tension: tuple[Array, Array], v: Values, laws: Laws, system: str, theta: float, rng: np.random.Generator
) -> tuple[Array, Array]:
    """Return the tension readings (N) before noise, delay and recorder: cross-talk, curvature, gain, zero, drift, filter."""
    t_in, t_out = _crossed(*tension, v["crosstalk"], laws["crosstalk"])
    bend, law = v["sensor_nonlinearity"], laws["sensor_nonlinearity"]
    t_in, t_out = _curved(t_in, bend["a_in"], law), _curved(t_out, bend["a_out"], law)
    if bend["h_n"] > 0.0:
        # Prandtl-Ishlinskii: three plays instead of one, as wide on the mean
        t_out = sum((held_play(t_out, w * bend["h_n"]) for w in (0.4, 1.0, 1.6)), np.zeros(t_out.size)) / 3.0
    gain = v["gain_error"][f"g_{system}"]
    if laws["gain_error"].id == "both_sensors":
        t_in, t_out = t_in / np.sqrt(gain), t_out * np.sqrt(gain)
    else:
        pull = np.maximum(t_out, 0.0)
        t_out = t_out * (1.0 + (gain - 1.0) * 1.4 * pull / (pull + laws["gain_error"].shape))
    elapsed = (time - time[0]) / (time[-1] - time[0])
    zero, drift = v["zero_offset"], v["zero_drift"]
    t_in = t_in + _zero(zero[f"z_in_{system}_n"], tension[0], theta, laws["zero_offset"])
    t_out = t_out + _zero(zero[f"z_out_{system}_n"], tension[1], theta, laws["zero_offset"])
    t_in = t_in + _drifted(drift[f"r_in_{system}_n"], elapsed, laws["zero_drift"], rng)
    t_out = t_out + _drifted(drift[f"r_out_{system}_n"], elapsed, laws["zero_drift"], rng)
    tau = v["channel_lowpass"][f"tau_{system}_s"]
    if tau > 0.0 and laws["channel_lowpass"].id == "butterworth":
        t_out = second_order(time, t_out, tau, BUTTERWORTH, 0.0)
    elif tau > 0.0:
        t_out = sliding_mean(time, t_out, 2.0 * tau)
    return t_in, t_out


def _crossed(t_in: Array, t_out: Array, cross: Mapping[str, float], law: Chosen) -> tuple[Array, Array]:
    to_out, to_in = cross["c_in_to_out"], cross["c_out_to_in"]
    if law.id == "mounting":
        both = t_in + t_out
        return t_in + to_in * both, t_out + to_out * both
    s = law.shape
    return t_in + (to_in + s * to_out) * t_out, t_out + (to_out + s * to_in) * t_in


def _curved(t: Array, a: float, law: Chosen) -> Array:
    if a == 0.0:
        return t
    if law.id == "cubic":
        return t + 2.0 * a * law.shape * t * (1.0 - (t / FULL_SCALE_N) ** 2)
    return t + a * (np.minimum(t, law.shape) - np.maximum(t - law.shape, 0.0) / 3.0)


def _zero(z: float, tension: Array, theta: float, law: Chosen) -> Array:
    if z == 0.0:
        return np.zeros(tension.size)
    if law.id == "preload":
        return np.full(tension.size, z * theta / NOMINAL_THETA)
    return np.asarray(-z * np.expm1(-np.maximum.accumulate(np.maximum(tension, 0.0)) / law.shape))


def _drifted(r: float, elapsed: Array, law: Chosen, rng: np.random.Generator) -> Array:
    """Return a zero that has moved by r (N) at the end of the run."""
    if r == 0.0:
        return np.zeros(elapsed.size)
    if law.id == "warm_up":
        return np.asarray(r * np.expm1(-elapsed / law.shape) / np.expm1(-1.0 / law.shape))
    if law.id == "steps":
        count = round(law.shape)
        places, sizes = np.sort(rng.random(count)), rng.dirichlet(np.ones(count))
        return np.asarray(r * np.concatenate(([0.0], np.cumsum(sizes)))[np.searchsorted(places, elapsed, "right")])
    walk = np.concatenate(([0.0], np.cumsum(rng.standard_normal(64)))) / 8.0
    bridge = walk - np.linspace(0.0, walk[-1], walk.size)
    return np.asarray(r * (elapsed + law.shape * np.interp(elapsed, np.linspace(0.0, 1.0, walk.size), bridge)))
