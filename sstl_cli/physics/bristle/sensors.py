"""Sensors and recorder: what they make of the true tensions, effect by effect, and their noise."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numba import njit
from numpy.typing import NDArray

from sstl_cli.physics.given import NoiseSpec

FloatArray = NDArray[np.float64]
Values = Mapping[str, Mapping[str, float]]

FULL_SCALE_N = 50.0
# Mean number of samples that one dropout or one freeze of the recorder lasts.
DROPOUT_SAMPLES, FROZEN_SAMPLES = 3.0, 12.0
# A sample is never taken nearer than this share of a period to its neighbour's place.
LARGEST_JITTER = 0.45


@njit(cache=True)
def relax(time: FloatArray, signal: FloatArray, tau: float) -> FloatArray:
    """First-order lag of a signal that holds its mean between two samples."""
    seen = np.empty_like(signal)
    seen[0] = signal[0]
    for n in range(1, signal.size):
        keep = np.exp((time[n - 1] - time[n]) / tau)
        seen[n] = keep * seen[n - 1] + (1.0 - keep) * 0.5 * (signal[n] + signal[n - 1])
    return seen


@njit(cache=True)
def sticky(signal: FloatArray, half: float) -> FloatArray:
    """Reading of an element that moves only when it is pushed by more than `half`."""
    seen = signal.copy()
    for n in range(1, signal.size):
        off = signal[n] - seen[n - 1]
        seen[n] = seen[n - 1]
        if abs(off) > half:
            seen[n] += off - half if off > 0.0 else off + half
    return seen


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


def _instants(time: FloatArray, sd: float, rng: np.random.Generator) -> FloatArray:
    """When the recorder really samples: every stamp off by a share of a period with this standard deviation."""
    off = np.clip(sd * rng.standard_normal(time.size), -LARGEST_JITTER, LARGEST_JITTER)
    if sd == 0.0:
        return time
    gaps = np.diff(time)
    off[0] = off[-1] = 0.0
    room: FloatArray = np.minimum(np.append(gaps, gaps[-1]), np.insert(gaps, 0, gaps[0]))
    return time + off * room


def _stretches(size: int, share: float, mean: float, rng: np.random.Generator) -> list[slice]:
    """Stretches of samples with a geometric length, which together cover about `share` of the record."""
    starts = 1 + np.flatnonzero(rng.random(size - 1) < share / mean)
    lengths = rng.geometric(1.0 / mean, starts.size)
    return [slice(a, a + n) for a, n in zip(starts.tolist(), lengths.tolist(), strict=True)]


def _spoil(t_in: FloatArray, t_out: FloatArray, faults: Mapping[str, float], rng: np.random.Generator) -> None:
    both = (t_in, t_out)
    for signal in both:
        hit = np.flatnonzero(rng.random(signal.size) < 0.01 * faults["spike_pct"])
        signal[hit] += faults["spike_n"] * np.sign(rng.random(hit.size) - 0.5)
    for hold in _stretches(t_in.size, 0.01 * faults["frozen_pct"], FROZEN_SAMPLES, rng):
        for signal in both:
            signal[hold] = signal[hold.start - 1]
    for lost in _stretches(t_in.size, 0.01 * faults["dropout_pct"], DROPOUT_SAMPLES, rng):
        for signal in both:
            signal[lost] = 0.0


def transduce(time: FloatArray, true_in: FloatArray, true_out: FloatArray, values: Values, system: str) -> tuple[FloatArray, FloatArray]:
    """Tension signals (N) before noise and converter: mounting, characteristic, gain, zero, analogue filter."""
    cross, curve = values["crosstalk"], values["sensor_nonlinearity"]
    seen_in = true_in + cross["c_out_to_in"] * true_out
    seen_out = true_out + cross["c_in_to_out"] * true_in
    seen_in = seen_in * (1.0 + curve["a_in"] * (1.0 - seen_in / FULL_SCALE_N))
    seen_out = seen_out * (1.0 + curve["a_out"] * (1.0 - seen_out / FULL_SCALE_N))
    if curve["h_n"] > 0.0:
        seen_out = sticky(seen_out, curve["h_n"])
    seen_out = values["gain_error"][f"g_{system}"] * seen_out
    passed = (time - time[0]) / (time[-1] - time[0])
    zero, drift = values["zero_offset"], values["zero_drift"]
    seen_in = seen_in + (zero[f"z_in_{system}_n"] + drift[f"r_in_{system}_n"] * passed)
    seen_out = seen_out + (zero[f"z_out_{system}_n"] + drift[f"r_out_{system}_n"] * passed)
    tau = values["channel_lowpass"][f"tau_{system}_s"]
    return seen_in, relax(time, seen_out, tau) if tau > 0.0 else seen_out


def record(
    time: FloatArray, truth: tuple[FloatArray, FloatArray, FloatArray], values: Values, system: str, noise: NoiseSpec, seed: int
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Time stamps (s), tensions in and out (N) and position (mm) as the recorder stores them, each of shape (n,).

    `truth` holds the same three without sensors. Sensors are late or jitter before their noise comes in, which is that
    of the converter; every source of chance has its own stream, so that one effect does not change another's.
    """
    names = ("in", "out", "position", "clock", "faults")
    streams = {name: np.random.default_rng([seed, k]) for k, name in enumerate(names)}
    seen_in, seen_out = transduce(time, truth[0], truth[1], values, system)
    stamps = _instants(time, 0.1 * values["acquisition_faults"]["jitter_pct"], streams["clock"])
    late = values["channel_delay"][f"tau_{system}_s"]
    x = truth[2]
    if stamps is not time:
        seen_in, x = np.interp(stamps, time, seen_in), np.interp(stamps, time, x)
    if late > 0.0 or stamps is not time:
        seen_out = np.interp(stamps - late, time, seen_out)
    t_in = seen_in + _noise(time, noise, streams["in"])
    t_out = seen_out + _noise(time, noise, streams["out"])
    x = x + noise.position_mm * streams["position"].standard_normal(time.size)
    top, step = values["saturation"], values["quantisation"]
    t_in, t_out = np.minimum(t_in, top["t_max_in_n"]), np.minimum(t_out, top["t_max_out_n"])
    if step["q_in_n"] > 0.0:
        t_in = step["q_in_n"] * np.rint(t_in / step["q_in_n"])
    if step["q_out_n"] > 0.0:
        t_out = step["q_out_n"] * np.rint(t_out / step["q_out_n"])
    _spoil(t_in, t_out, values["acquisition_faults"], streams["faults"])
    return stamps, t_in, t_out, x
