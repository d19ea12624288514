"""Movements of the input: trapezoid, sinusoid, random multi-sine, ramps with holds, minor loops, chirp."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from sstl_cli.core.errors import SstlError
from sstl_cli.physics.scenario import Lines, Trajectory

Array = NDArray[np.float64]
# default range of the input tension (N): the sensing loop must fall by Gamma_r / Gamma_p before it releases
RANGE_N = {"act": (1.0, 30.0), "sstl": (0.2, 40.0)}
# lowest and highest frequency (Hz) of a movement that says none
SPAN_HZ = {"chirp": (0.02, 1.0), "random": (0.02, 0.15)}
DURATION_S = {"trapezoid": 12.0, "sinusoid": 100.0, "random": 400.0, "ramp_hold": 60.0, "minor_loops": 60.0, "chirp": 60.0}
MAX_SAMPLES = 100_000_000


def times(trajectory: Trajectory, sampling_hz: float) -> Array:
    """Return the sampling times (s) of a movement; SstlError where there are too few or too many."""
    duration = (trajectory.duration_s or DURATION_S[trajectory.kind]) / trajectory.speed
    samples = duration * sampling_hz
    # held apart before it is rounded: it may be infinite
    n = round(min(samples, MAX_SAMPLES + 1.0))
    if not 4 <= n <= MAX_SAMPLES:
        raise SstlError(
            f"{duration:g} s at {sampling_hz:g} Hz gives {samples:.9g} samples, outside 4..{MAX_SAMPLES}",
            where=f"trajectory {trajectory.name}",
            fix="change duration_s or sampling_hz",
            code="E711",
        )
    return np.arange(n) / sampling_hz


def span_hz(trajectory: Trajectory) -> tuple[float, float]:
    """Return lowest and highest frequency (Hz) of a chirp or a random movement."""
    low, high = SPAN_HZ[trajectory.kind]
    return trajectory.frequency_hz or low, trajectory.top_frequency_hz or high


def tension_path(trajectory: Trajectory, system: str, time_s: Array, rng: np.random.Generator) -> Array:
    """Return the input tension (N, shape (n,)) of a movement."""
    low, high = RANGE_N[system]
    low = trajectory.low_n if trajectory.low_n is not None else low
    high = trajectory.high_n if trajectory.high_n is not None else high
    if high <= low:
        raise SstlError(f"high_n {high:g} N is not above low_n {low:g} N", where=f"trajectory {trajectory.name}", code="E712")
    phase = time_s / (time_s[-1] + time_s[1])
    mid, half = (low + high) / 2, (high - low) / 2
    kind = trajectory.kind
    if kind == "trapezoid":
        return low + (high - low) * _trapezoid(phase * (trajectory.cycles or 1))
    if kind == "sinusoid":
        # the paper's sinusoidal reference: 10 N offset, 5 N amplitude, 0.01 Hz
        mid, half = (mid, half) if trajectory.high_n is not None else (10.0, 5.0)
        frequency = trajectory.frequency_hz or 0.01
        return mid - half * np.cos(2 * np.pi * frequency * trajectory.speed * time_s)
    if kind == "random":
        return low + (high - low) * _multisine(trajectory, time_s, rng)
    if kind == "chirp":
        f0, f1 = span_hz(trajectory)
        total = time_s[-1] + time_s[1]
        angle: Array = 2 * np.pi * f0 * total / np.log(f1 / f0) * ((f1 / f0) ** phase - 1)
        return mid - half * np.cos(angle)
    levels = _ramp_hold_levels() if kind == "ramp_hold" else _minor_loop_levels(rng)
    hold = trajectory.hold_s if trajectory.hold_s is not None else (2.0 if kind == "ramp_hold" else 0.0)
    return low + (high - low) * _through(levels, phase, hold / (time_s[-1] + time_s[1]))


def _trapezoid(phase: Array) -> Array:
    """Return one up-hold-down-hold cycle per unit of phase: 40 % up, 5 % hold, 50 % down, 5 % hold."""
    return np.interp(phase % 1.0, [0.0, 0.4, 0.45, 0.95, 1.0], [0.0, 1.0, 1.0, 0.0, 0.0])


def _multisine(trajectory: Trajectory, time_s: Array, rng: np.random.Generator) -> Array:
    f0, f1 = span_hz(trajectory)
    frequencies = rng.uniform(f0, f1, 8)
    angles, amplitudes = rng.uniform(0, 2 * np.pi, 8), rng.uniform(0.4, 1.0, 8)
    wave = np.sum(amplitudes[:, None] * np.sin(2 * np.pi * frequencies[:, None] * time_s + angles[:, None]), axis=0)
    share: Array = (wave - wave.min()) / (wave.max() - wave.min())
    return share


def _ramp_hold_levels() -> Array:
    return np.array([0.0, 0.35, 0.65, 1.0, 0.7, 0.4, 0.1, 0.5, 1.0, 0.03])


def _minor_loop_levels(rng: np.random.Generator) -> Array:
    """Return turning points: a full loop, then nested and drifting minor loops, then a full release."""
    steps = [0.0, 1.0, 0.05, 0.8, 0.35, 0.7, 0.02, 0.6, 0.15, 0.9, 0.5, 1.0, 0.01]
    jitter = rng.uniform(-0.03, 0.03, len(steps))
    return np.clip(np.array(steps) + jitter, 0.0, 1.0)


def _through(levels: Array, phase: Array, hold: float) -> Array:
    """Return ramps of one speed through the levels, with a hold (share of the duration) at each."""
    hold = min(hold, 0.6 / len(levels))
    travel = np.abs(np.diff(levels))
    ramp = travel / travel.sum() * (1.0 - hold * (len(levels) - 1))
    at: list[float] = [0.0]
    values: list[float] = [levels[0]]
    for length, level in zip(ramp, levels[1:], strict=True):
        at += [at[-1] + length, at[-1] + length + hold]
        values += [level, level]
    return np.interp(phase, at, values)


@njit(cache=True)
def position_driven(
    position: Array, start_n: float, gp: float, bp: float, gr: float, br: float, tendon_mm_per_n: float, load_mm_per_n: float
) -> Array:
    """Return the input tension (N) of a line pulled to a given position (mm), by its stiffness in each phase.

    In propagation tendon and load spring yield in series; in backlash only the half of the
    tendon behind the turning front does.
    """
    out = np.empty_like(position)
    t = start_n
    y = max(gp * t + bp, 0.0)
    for k in range(position.size):
        dx = position[k] - position[k - 1] if k else 0.0
        low, high = gp * t + bp, gr * t + br
        if dx >= 0.0 and y <= low + 1e-9:
            t += dx / (load_mm_per_n * gp + tendon_mm_per_n)
        elif dx < 0.0 and y >= high - 1e-9:
            t += dx / (load_mm_per_n * gr + tendon_mm_per_n)
        else:
            t += dx / (0.5 * tendon_mm_per_n)
        t = max(t, 0.0)
        y = max(max(gp * t + bp, 0.0), min(y, gr * t + br))
        out[k] = t
    return out


def probe(trajectory: Trajectory, system: str, time_s: Array, lines: Lines, tendon_mm_per_n: float, load_mm_per_n: float) -> Array:
    """Return the input tension (N) of the position-driven trapezoid, scaled to the range of the trajectory."""
    low, high = RANGE_N[system]
    low = trajectory.low_n if trajectory.low_n is not None else low
    high = trajectory.high_n if trajectory.high_n is not None else high
    shape = _trapezoid(time_s / (time_s[-1] + time_s[1]) * (trajectory.cycles or 1))
    stroke = (high - low) * (load_mm_per_n * lines.gamma_p + tendon_mm_per_n)
    args = (lines.gamma_p, lines.beta_p, lines.gamma_r, lines.beta_r, tendon_mm_per_n, load_mm_per_n)
    return position_driven(shape * stroke, low, *args)
