"""Sensor noise measured where the output is held, and what noise of the input does to a prediction.

In backlash nothing but noise moves the output. Noise of the same kind on the measured input is
amplified by the slope, and its extremes push held levels up, which looks like friction that falls with
speed. The mean of that push is taken out by simulation and extrapolation (SIMEX, Cook and Stefanski
1994); its scatter belongs to the noise floor, because no effect can explain it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_toeplitz
from scipy.signal import lfilter

from sstl_cli.core.rng import stream
from sstl_cli.diagnosis.recorder import white_noise
from sstl_cli.diagnosis.records import Record
from sstl_cli.diagnosis.simulator import Simulator
from sstl_cli.diagnosis.smoothing import smoothed

Array = NDArray[np.float64]
WINDOW_S = 3.0
MIN_WINDOW_S = 0.5
ORDER = 8
DRAWS = 8
# Noise added to an input that is noisy already moves extremes less than the first noise did: on rig runs with
# known inputs, scatter is 1.5 times and the mean push half of what the added noise shows.
SCATTER_FACTOR = 1.5
PUSH_FACTOR = 0.5


@dataclass(frozen=True)
class Floor:
    """Noise at the analysis rate (N, RMS): of the output sensor, of a perfect prediction, and on the fine grid.

    ``push_n`` is the mean push of input noise on the prediction, shape (samples,).
    """

    output_n: float
    prediction_n: float
    fine_n: float
    push_n: Array
    white_n: float

    @property
    def coloured(self) -> float:
        """How much of the output noise is coloured: 0 (white) to 1."""
        return float(np.clip(self.output_n / max(self.white_n, 1e-12) - 1.0, 0.0, 1.0))

    @property
    def total_n(self) -> float:
        """What remains when everything but noise is explained."""
        return float(np.hypot(self.output_n, self.prediction_n))


def noise_floor(sim: Simulator, theta: Array, prediction: Array) -> Floor:
    """Return the noise floor of a problem, given the base fit."""
    series: list[Array] = []
    fine: list[float] = []
    step = max(r.dt_s * r.factor for r in sim.problem.records)
    for window_s in (WINDOW_S, 1.5, MIN_WINDOW_S):
        length = max(8, round(window_s / step))
        series = [
            w
            for r, s in zip(sim.problem.records, sim.slices(), strict=True)
            for w in _windows(r, prediction[s], length)
        ]
        if len(series) >= 4:
            break
    if len(series) < 4:
        white = [(white_noise(r.y), white_noise(r.y_fine)) for r in sim.problem.records]
        output, fine_n = (float(np.median(x)) for x in zip(*white, strict=True))
        scatter, push = _passed_on(sim, theta, np.array([1.0]), output)
        return Floor(output, scatter, fine_n, push, output)
    coefficients, sigma = _autoregression(np.array(series))
    fine = [white_noise(r.y_fine) for r in sim.problem.records]
    coarse = [white_noise(r.y) for r in sim.problem.records]
    above = float(np.sqrt(max(np.median(fine) ** 2 - np.median(coarse) ** 2, 0.0)))
    scatter, push = _passed_on(sim, theta, coefficients, sigma)
    return Floor(sigma, scatter, float(np.hypot(sigma, above)), push, float(np.median(coarse)))


def _windows(r: Record, prediction: Array, length: int) -> list[Array]:
    """Return detrended pieces of the output in which the model holds it; the loudest tenth may be jumps."""
    if r.slip is not None:
        # a line that slides all the time holds nothing
        return []
    held = np.concatenate((np.abs(np.diff(prediction)) < 1e-9, [False])) & (r.weight > 0)
    n = len(held)
    sums = np.concatenate(([0], np.cumsum(held)))
    pieces: list[Array] = []
    start = 0
    x = np.arange(length) - (length - 1) / 2
    while start + length <= n:
        if sums[start + length] - sums[start] == length:
            piece = r.y[start : start + length]
            pieces.append(piece - piece.mean() - x * float(piece @ x) / float(x @ x))
            start += length
        else:
            start += max(1, length // 4)
    return pieces


def _autoregression(windows: Array) -> tuple[Array, float]:
    """Return an AR filter and the standard deviation of the noise, freed of what detrending took out."""
    power = (windows**2).mean(axis=1)
    quiet = windows[power <= np.quantile(power, 0.9)]
    measured = _acf(quiet)
    # the same windows cut from noise of the first guess show how much detrending hides at each lag
    corrected = measured.copy()
    for _ in range(3):
        a, variance = _yule_walker(corrected)
        noise = lfilter(
            [np.sqrt(variance)], a, stream(0, "noise floor").standard_normal((400, 4 * quiet.shape[1])), axis=1
        )
        noise = noise[:, -quiet.shape[1] :]
        x = np.arange(noise.shape[1]) - (noise.shape[1] - 1) / 2
        true = _acf(noise)
        noise = noise - noise.mean(axis=1, keepdims=True)
        noise = noise - (noise @ x / (x @ x))[:, None] * x
        corrected = measured + (true - _acf(noise))
    a, _ = _yule_walker(corrected)
    # windows without the loudest tenth are a little too quiet
    return a, float(
        np.sqrt(corrected[0] * power.mean() / max(float(power[power <= np.quantile(power, 0.9)].mean()), 1e-300))
    )


def _acf(rows: Array) -> Array:
    n = rows.shape[1]
    lags = min(ORDER, n - 2)
    return np.array([np.mean(rows[:, lag:] * rows[:, : n - lag]) for lag in range(lags + 1)])


def _yule_walker(acf: Array) -> tuple[Array, float]:
    acf = acf.copy()
    acf[0] = max(acf[0] * (1.0 + 1e-4), 1e-18)
    phi = solve_toeplitz(acf[:-1], acf[1:])
    variance = float(acf[0] - phi @ acf[1:])
    roots = np.roots(np.concatenate(([1.0], -phi)))
    if variance <= 0 or np.any(np.abs(roots) >= 0.999):
        one = float(np.clip(acf[1] / acf[0], -0.99, 0.99))
        return np.array([1.0, -one]), float(acf[0] * (1 - one**2))
    return np.concatenate(([1.0], -phi)), variance


def _passed_on(sim: Simulator, theta: Array, coefficients: Array, sigma: float) -> tuple[float, Array]:
    """Return scatter (N, RMS) and mean (N, shape (samples,)) of what input noise does to the base prediction."""
    reference = sim.predict(theta, {})
    mean, square = np.zeros_like(reference), np.zeros_like(reference)
    for draw in range(DRAWS):
        inputs = [
            smoothed(r.u + _input_noise(r, coefficients, sigma, draw, i), r.smooth_halves)
            for i, r in enumerate(sim.problem.records)
        ]
        change = sim.with_inputs(inputs).predict(theta, {}) - reference
        mean += change / DRAWS
        square += change**2 / DRAWS
    variance = np.maximum(square - mean**2, 0.0) * DRAWS / (DRAWS - 1)
    scatter = SCATTER_FACTOR * float(np.sqrt(np.sum(sim.weight * variance) / max(sim.weight.sum(), 1.0)))
    return scatter, PUSH_FACTOR * _steady(sim, mean)


def _steady(sim: Simulator, mean: Array) -> Array:
    """Return the mean push averaged over a second: it is slow, what is fast of it is leftover scatter."""
    out = np.empty_like(mean)
    for r, s in zip(sim.problem.records, sim.slices(), strict=True):
        width = max(1, min(round(1.0 / (r.dt_s * r.factor)), len(r)))
        weight = np.convolve(np.ones(len(r)), np.ones(width), mode="same")
        out[s] = np.convolve(mean[s], np.ones(width), mode="same") / weight
    return out


def _input_noise(r: Record, coefficients: Array, sigma: float, draw: int, i: int) -> Array:
    """Return a draw of input noise on the simulation grid (N): the output's kind, at the input's level."""
    n = len(r)
    noise = lfilter([1.0], coefficients, stream(0, "input noise", draw, i).standard_normal(n + 200))[200:]
    noise *= sigma / np.sqrt(_gain(coefficients))
    # sensors of a rig are alike; where their white noise differs, so is the coloured part taken to
    out_white, in_white = max(white_noise(r.raw.tension_out_n), 1e-12), white_noise(r.raw.tension_in_n)
    noise *= float(np.clip(in_white / out_white, 0.2, 5.0))
    return np.interp(np.arange(n * r.factor), (np.arange(n) + 0.5) * r.factor - 0.5, noise)


def _gain(coefficients: Array) -> float:
    """Return the variance of the filter's response to unit white noise."""
    impulse = lfilter([1.0], coefficients, np.concatenate(([1.0], np.zeros(2000))))
    return float(np.sum(impulse**2))

