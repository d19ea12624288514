"""Signs of something that no catalogue effect holds: a steady tone, and a bend that changes in mid-run.

Both hide from a comparison of candidates where they are small: no candidate gains, so nothing would be said.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import median_filter

from sstl_cli.diagnosis.fit import Fit
from sstl_cli.diagnosis.records import Record
from sstl_cli.diagnosis.simulator import Simulator
from sstl_cli.diagnosis.whitening import Whitener

Array = NDArray[np.float64]
# movements and their reversals fill the spectrum below
LEAST_HZ = 5.0
NEIGHBOURS = 41
# a bin of noise exceeds this multiple of its neighbours' mean once in 10^10
PEAK = 24.0
LEAST_RUNS = 0.6
LEAST_TONE = 0.15
SPLITS = np.array([0.3, 0.4, 0.5, 0.6, 0.7])
BLOCK_S = 2.0
# what noise does to a play operator differs from movement to movement: with nothing missing z reached 12 and the change
# 0.7 % on rig runs
LEAST_SHIFT_Z = 12.0
LEAST_SHIFT = 0.01


@dataclass(frozen=True)
class Tone:
    """A steady oscillation of the output: frequency (Hz) and RMS (N)."""

    frequency_hz: float
    rms_n: float


@dataclass(frozen=True)
class Shift:
    """A change of theta in mid-run: size (share of theta), place (share of the run) and its z-score."""

    share: float
    place: float
    z: float


def tone(records: tuple[Record, ...], predictions: list[Array], noise_n: float) -> Tone | None:
    """Return the steady tone that most runs share in what the model leaves, or None.

    Parameters
    ----------
    predictions : list of ndarray
        Output of the model on each record's simulation grid (N).
    noise_n : float
        White noise of the output at that rate (N).
    """
    found: list[tuple[float, float]] = []
    for r, prediction in zip(records, predictions, strict=True):
        x = (r.y_fine - prediction[: len(r.y_fine)]) * r.weight_fine
        if len(x) < 4 * NEIGHBOURS:
            continue
        window = np.hanning(len(x))
        power = np.abs(np.fft.rfft((x - x.mean()) * window)) ** 2
        hz = np.fft.rfftfreq(len(x), r.dt_s)
        # the median of exponential noise is ln 2 of its mean
        around = median_filter(power, NEIGHBOURS, mode="mirror") / np.log(2.0)
        ratio = np.where(hz > LEAST_HZ, power / np.maximum(around, 1e-300), 0.0)
        at = int(np.argmax(ratio))
        if ratio[at] > PEAK:
            # a Hann window spreads a line over three bins and keeps 3/8 of its power
            near = power[max(at - 2, 0) : at + 3].sum()
            found.append((float(hz[at]), float(np.sqrt(near * 2.0 / np.sum(window**2) / len(x)))))
    if len(found) < max(2.0, LEAST_RUNS * len(records)):
        return None
    middle = float(np.median([f for f, _ in found]))
    same = [a for f, a in found if abs(f - middle) < 0.02 * middle + 0.2]
    rms = float(np.median([a for _, a in found]))
    if len(same) < LEAST_RUNS * len(records) or rms < LEAST_TONE * noise_n:
        return None
    return Tone(middle, rms)


def shifts(sim: Simulator, whiten: Whitener, fit: Fit) -> tuple[Shift, Shift]:
    """Return the clearest change of theta between the runs of a configuration, and the clearest within a run.

    Each block of two seconds gives its own theta; their scatter is taken from neighbours in time, so that a change
    does not hide itself in it. Runs of a configuration are taken in the order of their names.
    """
    own, r = whiten(fit.jacobian)[:, 0], whiten(fit.residual)
    runs: list[tuple[int, Array, Array]] = []
    noise: list[float] = []
    for record, s in zip(sim.problem.records, sim.slices(), strict=True):
        length = max(1, round(BLOCK_S / (record.dt_s * record.factor)))
        index = np.arange(len(record)) // length
        h = np.asarray(np.bincount(index, own[s] ** 2), np.float64)
        g = np.asarray(np.bincount(index, own[s] * r[s]), np.float64)
        good = h > 1e-3 * max(float(h.max(initial=0.0)), 1e-300)
        if good.sum() >= 6:
            h, g = h[good], g[good]
            noise += list(np.diff(g / h) ** 2 / (1.0 / h[1:] + 1.0 / h[:-1]))
            runs.append((record.config, g, h))
    inflation = max(float(np.mean(noise)), 1.0) if noise else 1.0
    between = within = Shift(0.0, 0.5, 0.0)
    for config, g, h in runs:
        cuts = np.unique((SPLITS * len(g)).astype(np.int64))
        within = max(within, _clearest(g, h, cuts, inflation, float(fit.theta[config])), key=lambda x: abs(x.z))
    for config in sorted({c for c, _, _ in runs}):
        own_runs = [(g.sum(), h.sum()) for c, g, h in runs if c == config]
        scores, weights = np.array([a for a, _ in own_runs]), np.array([b for _, b in own_runs])
        found = _clearest(scores, weights, np.arange(1, len(scores), dtype=np.int64), inflation, float(fit.theta[config]))
        between = max(between, found, key=lambda x: abs(x.z))
    return between, within


def _clearest(g: Array, h: Array, cuts: NDArray[np.int64], inflation: float, theta: float) -> Shift:
    """Return the cut of a sequence of scores and informations on whose sides theta differs most clearly."""
    best = Shift(0.0, 0.5, 0.0)
    for cut in cuts:
        a, b = h[:cut].sum(), h[cut:].sum()
        if a <= 0.0 or b <= 0.0:
            continue
        contrast = g[cut:].sum() / b - g[:cut].sum() / a
        z = contrast / np.sqrt(inflation * (1.0 / a + 1.0 / b))
        if abs(z) > abs(best.z):
            best = Shift(float(contrast / theta), float(cut / len(g)), float(z))
    return best
