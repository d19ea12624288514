"""The recorder: late or held channels, noise, clipping, rounding and faults, and `read`, which does all in order."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numba import njit
from scipy.signal import lfilter

from sstl_cli.physics.given import NoiseSpec, Values
from sstl_cli.physics.variant.laws import Chosen
from sstl_cli.physics.variant.line import Array
from sstl_cli.physics.variant.sensors import Laws, sensor_noise, transduce

# mean length of a burst of lost or frozen samples
BURST = 6.0
JITTER_CORRELATION_S = 0.1


@njit(cache=True)
def deadband(signal: Array, step: float) -> Array:
    """Return a signal that is sent anew only once it has moved by a step (N)."""
    out = signal.copy()
    for n in range(1, signal.size):
        out[n] = signal[n] if abs(signal[n] - out[n - 1]) >= step else out[n - 1]
    return out


def late_clock(time: Array, tau_s: float, law: Chosen, rng: np.random.Generator) -> Array:
    """Return the instants (s) whose tension the output channel shows."""
    if law.id == "bus":
        phase = rng.random()
        return np.asarray((np.floor((time - time[0]) / (2.0 * tau_s) + phase) - phase) * 2.0 * tau_s + time[0])
    decay = float(np.exp(-np.median(np.diff(time)) / JITTER_CORRELATION_S))
    wander = lfilter([np.sqrt(1.0 - decay**2)], [1.0, -decay], rng.standard_normal(time.size))
    return np.asarray(time - tau_s * np.clip(1.0 + law.shape * wander, 0.0, 3.0))


def digitise(signal: Array, ceiling: float, step: float, limit: Chosen, rounding: Chosen) -> Array:
    """Return what the converter stores of a signal (N): its full scale first, then its resolution."""
    if ceiling < 1000.0 and limit.id == "soft_knee":
        width = limit.shape * ceiling
        signal = signal - width * np.logaddexp(0.0, (signal - ceiling) / width)
    elif ceiling < 1000.0:
        signal = np.where(signal >= ceiling, np.mod(signal, ceiling), signal)
    if step <= 0.0:
        return signal
    return np.asarray(step * np.floor(signal / step) if rounding.id == "truncate" else deadband(signal, step))


def _bursts(size: int, share: float, rng: np.random.Generator, mean: float = BURST) -> Array:
    """Return which samples lie in bursts that cover about a share of the record (Gilbert's two-state channel)."""
    hit = np.zeros(size, bool)
    if share <= 0.0:
        return hit
    for start in np.flatnonzero(rng.random(size) < share / mean).tolist():
        hit[max(start, 1) : max(start, 1) + int(rng.geometric(1.0 / mean))] = True
    return hit


def _hold(signal: Array, lost: Array) -> None:
    """Let lost samples repeat the last good one, in place."""
    good = np.maximum.accumulate(np.where(lost, 0, np.arange(signal.size)))
    signal[:] = signal[good]


def spoil(signals: tuple[Array, Array], faults: Mapping[str, float], law: Chosen, rng: np.random.Generator) -> None:
    """Write spikes, lost and frozen samples into both channels, in place."""
    size = signals[0].size
    for signal in signals:
        hit = np.flatnonzero(rng.random(size) < 0.01 * faults["spike_pct"] / (law.shape if law.id == "bursts" else 1.0))
        for n in hit:
            sign = rng.choice((-1.0, 1.0))
            if law.id == "bursts":
                # heights and places of a burst are random
                places = n + rng.integers(0, 40, int(rng.geometric(1.0 / law.shape)))
                places = np.unique(places[places < size])
                signal[places] += faults["spike_n"] * sign * rng.exponential(1.0, places.size)
            else:
                tail = signal[n : n + 20]
                tail += faults["spike_n"] * sign * np.exp(-np.arange(tail.size) * 2.0 / law.shape)
    frozen = _bursts(size, 0.01 * faults["frozen_pct"], rng, 4.0 * BURST)
    lost = _bursts(size, 0.01 * faults["dropout_pct"], rng)
    for signal in signals:
        _hold(signal, frozen)
        if law.id == "held":
            _hold(signal, lost)
        else:
            signal[lost] = 0.0


def wandering_clock(time: Array, share: float, law: Chosen, rng: np.random.Generator) -> Array:
    """Return the instants (s) at which the recorder really samples."""
    if share <= 0.0:
        return time
    period = float(np.min(np.diff(time)))
    if law.id == "bursts":
        step = 10.0 * share * rng.standard_normal(time.size)
        return np.asarray(time + period * np.clip(lfilter([1.0], [1.0, -0.98], step), -0.45, 0.45))
    late = rng.random(time.size) < 5.0 * share
    return np.asarray(time + period * np.where(late, rng.uniform(0.0, 0.9, time.size), 0.0))


def read(
    time: Array, truth: tuple[Array, Array, Array], v: Values, laws: Laws, system: str, theta: float, noise: NoiseSpec, seed: int
) -> tuple[Array, Array, Array, Array]:
    """Return time stamps (s), tensions in and out (N) and position (mm) as the recorder stores them, each (n,).

    `truth` holds the last three without sensors. Every source of chance has its own stream.
    """
    drift, first, second, place, clock, late, fault = (np.random.default_rng(child) for child in np.random.SeedSequence(seed).spawn(7))
    t_in, t_out = transduce(time, truth[:2], v, laws, system, theta, drift)
    t_in = t_in + sensor_noise(time, noise, first)
    t_out = t_out + sensor_noise(time, noise, second)
    x = truth[2] + noise.position_mm * place.standard_normal(time.size)
    faults = v["acquisition_faults"]
    stamps = wandering_clock(time, 0.01 * faults["jitter_pct"], laws["acquisition_faults"], clock)
    tau = v["channel_delay"][f"tau_{system}_s"]
    if stamps is not time:
        t_in, x = np.interp(stamps, time, t_in), np.interp(stamps, time, x)
    if tau > 0.0:
        t_out = np.interp(late_clock(stamps, tau, laws["channel_delay"], late), time, t_out)
    elif stamps is not time:
        t_out = np.interp(stamps, time, t_out)
    top, step = v["saturation"], v["quantisation"]
    t_in = digitise(t_in, top["t_max_in_n"], step["q_in_n"], laws["saturation"], laws["quantisation"])
    t_out = digitise(t_out, top["t_max_out_n"], step["q_out_n"], laws["saturation"], laws["quantisation"])
    t_in, t_out = np.array(t_in), np.array(t_out)
    spoil((t_in, t_out), faults, laws["acquisition_faults"], fault)
    return stamps, t_in, t_out, x
