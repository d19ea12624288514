"""Whether an output rests and jumps where a line should slide: evidence of a line that sticks, whatever its law.

At what moments a line jumps no model foretells, so that its likelihood takes jumps for scatter. They are told from scatter by what the
output does meanwhile: nothing at all.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.special import ndtr

from sstl_cli.diagnosis.constants import FEWEST_WINDOWS, MIXTURE_ROUNDS, MIXTURE_WIDTHS, STILL_N, WINDOW_TRAVEL
from sstl_cli.diagnosis.records import Record
from sstl_cli.diagnosis.white import least_white

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
TINY = 1e-300


def rests(records: Sequence[Record], predicted: Sequence[Array]) -> float:
    """Return the evidence (nats) that outputs rest between movements within strokes in which a model slides, 0 where there is none.

    A stroke is cut where the model has come as far as rest and movement can be told apart by. What the output has come there over what
    it should have is scattered about some value in any way, more often near it than far off; or it is nothing in part of the
    windows, within the noise. Both mixtures are the likeliest ones (Kiefer and Wolfowitz 1956). Before an output moves and after it has moved for the
    last time in a stroke it may rest for other reasons: backlash, stiction at a turn, a limit.

    Parameters
    ----------
    predicted : sequence of ndarray, shape (n * factor,)
        What the model makes of each record (N).
    """
    noise_n = {system: max(_noise_n(r) for r in records if r.system == system) for system in {r.system for r in records}}
    parts = [
        _windows(r.y_fine, m, r.weight_fine > 0, np.sqrt(2.0) * noise_n[r.system], WINDOW_TRAVEL)
        for r, m in zip(records, predicted, strict=True)
    ]
    ratio, error = (np.concatenate(x) for x in zip(*parts, strict=True))
    return _spike(ratio, error) if len(ratio) >= FEWEST_WINDOWS else 0.0


def _noise_n(r: Record) -> float:
    """Return what an output may be off by at rest (N): a converter's step is no movement, nor is the error of a model on a grid.

    One that never changes has neither noise nor a step.
    """
    faults = r.faults_out
    return max(float(np.hypot(faults.noise_n / np.sqrt(r.thin), faults.step_n)), least_white(r, "tension_out_n"), STILL_N)


def _spike(ratio: Array, error: Array) -> float:
    """Return by how much a share of exactly nothing makes ratios likelier, shape (windows,) each."""
    widths = float(np.median(error)) * MIXTURE_WIDTHS

    scattered = []
    for off in (ratio - 1.0, ratio - float(np.mean(ratio))):
        # every law that falls off alike to both sides is a mixture of uniform ones (Khinchin 1938)
        scattered.append(np.column_stack([_normal(off, error), *(_uniform(off, w, error) for w in widths)]))
    resting = _normal(ratio, error)
    with_rests = max(_mixture(np.column_stack((s, resting))) for s in scattered)
    return max(with_rests - max(_mixture(s) for s in scattered), 0.0)


def _normal(x: Array, sd: Array) -> Array:
    return np.asarray(np.maximum(np.exp(-0.5 * (x / sd) ** 2) / (sd * np.sqrt(2.0 * np.pi)), TINY))


def _uniform(x: Array, half: Array | float, sd: Array) -> Array:
    """Return the density of what is uniform up to ``half`` to either side of nothing, read with an error."""
    return np.asarray(np.maximum((ndtr((x + half) / sd) - ndtr((x - half) / sd)) / (2.0 * half), TINY))


def _mixture(densities: Array) -> float:
    """Return the log likelihood of the likeliest mixture of components, shape (samples, components), by expectation maximisation."""
    share = np.full(densities.shape[1], 1.0 / densities.shape[1])
    for _ in range(MIXTURE_ROUNDS):
        share *= (densities / (densities @ share)[:, None]).mean(axis=0)
    return float(np.log(densities @ share).sum())


@njit(cache=True, nogil=True)
def _windows(y: Array, m: Array, good: Mask, error_n: float, travel: float) -> tuple[Array, Array]:
    """Return what an output has come over what it should have, in windows of strokes of a model, and the error of that."""
    n = m.size
    ratio, error = np.empty(n), np.empty(n)
    count = i = 0
    while i < n - 1:
        way = np.sign(m[i + 1] - m[i])
        if way == 0.0 or not good[i]:
            i += 1
            continue
        begin = stroke = i
        first = kept = count
        moved = False
        while i < n - 1 and way * (m[i + 1] - m[i]) >= 0.0 and good[i + 1]:
            i += 1
            due = m[i] - m[begin]
            if abs(due) < travel * error_n:
                continue
            part = (y[i] - y[begin]) / due
            begin = i
            moves = part > 0.5
            moved = moved or moves
            if moved:
                ratio[count], error[count] = part, error_n / abs(due)
                count += 1
                kept = count if moves else kept
        count = kept if moved else first
        i = max(i, stroke + 1)
    return ratio[:count], error[:count]
