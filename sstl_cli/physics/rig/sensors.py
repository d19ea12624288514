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
# Longest run of samples that one dropout or one freeze of the recorder lasts.
DROPOUT_RUN = 4
FROZEN_RUN = 25


@njit(cache=True)
def first_order(time: FloatArray, signal: FloatArray, tau: float) -> FloatArray:
    """First-order low-pass of a signal that runs straight between samples: exact for ramps, any time base."""
    out = np.empty_like(signal)
    out[0] = signal[0]
    for n in range(1, signal.size):
        dt = time[n] - time[n - 1]
        decay = np.exp(-dt / tau)
        slope = (signal[n] - signal[n - 1]) / dt
        settled = signal[n] - slope * tau
        out[n] = settled + (out[n - 1] - signal[n - 1] + slope * tau) * decay
    return out


@njit(cache=True)
def sensor_play(signal: FloatArray, half_width: float) -> FloatArray:
    """Hysteresis of a sensor element: the reading stays while the tension moves within +-half_width of it."""
    out = np.empty_like(signal)
    out[0] = signal[0]
    for n in range(1, signal.size):
        out[n] = min(max(out[n - 1], signal[n] - half_width), signal[n] + half_width)
    return out


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


def transduce(time: FloatArray, true_in: FloatArray, true_out: FloatArray, values: Values, system: str) -> tuple[FloatArray, FloatArray]:
    """Tension readings (N) before noise: crosstalk, nonlinearity, hysteresis, gain, zero, drift, analogue filter."""
    cross = values["crosstalk"]
    t_in = true_in + cross["c_out_to_in"] * true_out
    t_out = true_out + cross["c_in_to_out"] * true_in
    bend = values["sensor_nonlinearity"]
    t_in = t_in + bend["a_in"] * t_in * (1.0 - t_in / FULL_SCALE_N)
    t_out = t_out + bend["a_out"] * t_out * (1.0 - t_out / FULL_SCALE_N)
    if bend["h_n"] > 0.0:
        t_out = sensor_play(t_out, bend["h_n"])
    t_out = t_out * values["gain_error"][f"g_{system}"]
    elapsed = (time - time[0]) / (time[-1] - time[0])
    zero, drift = values["zero_offset"], values["zero_drift"]
    t_in = t_in + zero[f"z_in_{system}_n"] + drift[f"r_in_{system}_n"] * elapsed
    t_out = t_out + zero[f"z_out_{system}_n"] + drift[f"r_out_{system}_n"] * elapsed
    tau = values["channel_lowpass"][f"tau_{system}_s"]
    if tau > 0.0:
        t_out = first_order(time, t_out, tau)
    return t_in, t_out


def digitise(signal: FloatArray, ceiling: float, step: float) -> FloatArray:
    """Converter: nothing above `ceiling` (N), then rounding to multiples of `step` (N), 0 for none."""
    clipped = np.minimum(signal, ceiling)
    return np.round(clipped / step) * step if step > 0.0 else clipped


def _starts(size: int, share: float, length: int, rng: np.random.Generator) -> NDArray[np.int64]:
    """Start indices of faults of `length` samples that together cover about `share` of the record."""
    if share <= 0.0:
        return np.zeros(0, dtype=np.int64)
    count = max(1, round(share * size / length))
    return np.sort(rng.choice(np.arange(1, size), size=min(count, size - 1), replace=False))


def jittered_clock(time: FloatArray, share: float, rng: np.random.Generator) -> FloatArray:
    """Instants at which the recorder really samples: a share of them up to 0.4 periods early or late."""
    shifted = time.copy()
    if share > 0.0:
        inner = np.zeros(time.size, dtype=bool)
        inner[_starts(time.size - 1, share, 1, rng)] = True
        spacing = np.minimum(np.diff(time, prepend=2 * time[0] - time[1]), np.diff(time, append=2 * time[-1] - time[-2]))
        # Below half a period, so that stamps stay in order.
        shifted[inner] += (rng.uniform(-0.4, 0.4, time.size) * spacing)[inner]
    return shifted


def spoil(t_in: FloatArray, t_out: FloatArray, faults: Mapping[str, float], rng: np.random.Generator) -> None:
    """Write spikes (one channel), frozen stretches and dropouts to 0 N (both channels) into the records, in place."""
    size = t_in.size
    for signal in (t_in, t_out):
        for start in _starts(size, 0.01 * faults["spike_pct"], 1, rng):
            signal[start] += faults["spike_n"] * rng.choice((-1.0, 1.0))
    for start in _starts(size, 0.01 * faults["frozen_pct"], FROZEN_RUN, rng):
        for signal in (t_in, t_out):
            signal[start : start + FROZEN_RUN] = signal[start - 1]
    for start in _starts(size, 0.01 * faults["dropout_pct"], DROPOUT_RUN, rng):
        length = int(rng.integers(1, 2 * DROPOUT_RUN))
        for signal in (t_in, t_out):
            signal[start : start + length] = 0.0


def record(
    time: FloatArray, truth: tuple[FloatArray, FloatArray, FloatArray], values: Values, system: str, noise: NoiseSpec, seed: int
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Time stamps (s), tensions in and out (N) and position (mm) as the recorder stores them, each of shape (n,).

    `truth` holds the same three without sensors; tension out is late by the channel delay.

    Every sensor draws from its own random stream, so that one effect does not change the noise of another sensor.
    """
    streams = [np.random.default_rng(child) for child in np.random.SeedSequence(seed).spawn(5)]
    true_in, true_out, true_x = truth
    t_in, t_out = transduce(time, true_in, true_out, values, system)
    t_in = t_in + sensor_noise(time, noise, streams[0])
    t_out = t_out + sensor_noise(time, noise, streams[1])
    x = true_x + noise.position_mm * streams[2].standard_normal(time.size)
    stamps = jittered_clock(time, 0.01 * values["acquisition_faults"]["jitter_pct"], streams[3])
    late = values["channel_delay"][f"tau_{system}_s"]
    if not np.array_equal(stamps, time):
        t_in, x = np.interp(stamps, time, t_in), np.interp(stamps, time, x)
    if late > 0.0 or not np.array_equal(stamps, time):
        t_out = np.interp(stamps - late, time, t_out)
    limits, steps = values["saturation"], values["quantisation"]
    t_in = digitise(t_in, limits["t_max_in_n"], steps["q_in_n"])
    t_out = digitise(t_out, limits["t_max_out_n"], steps["q_out_n"])
    spoil(t_in, t_out, values["acquisition_faults"], streams[4])
    return stamps, t_in, t_out, x
