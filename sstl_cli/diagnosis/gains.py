"""A wrong scale of a sensor: an output that no friction could make of its input."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from sstl_cli.core.runs import Run
from sstl_cli.diagnosis.records import Problem, Record
from sstl_cli.physics.transmission import play_operator

Array = NDArray[np.float64]
# outside of these a gain is no matter of alignment or calibration, but of a wrong scale or a broken sensor
LEAST, MOST = 0.5, 2.0
GAINS = np.geomspace(1 / 30, 30, 61)
THETAS = np.array([0.02, 0.1, 0.3, 0.55, 1.0])
# the wrong scale must leave less than this share of the squared error, and of the output's own variance
LEFT_OF_ERROR = 0.1
LEFT_OF_OUTPUT = 0.15


@dataclass(frozen=True)
class WrongScale:
    """Output over true output of one system, and the RMS error (N) before and after it is put right."""

    system: str
    gain: float
    rmse_n: float
    rmse_with_n: float


def wrong_scales(problem: Problem) -> list[WrongScale]:
    """Return the systems whose output has a scale that friction cannot give it.

    Friction lowers the pulled output by exp(-n theta) and raises the released one by as much: the product of
    both slopes is the squared gain whatever the friction (EFFECTS, fact 3), so a gross gain cannot be mistaken.
    """
    found = []
    for system in problem.systems:
        records = [r for r in problem.records if r.system == system]
        w = np.concatenate([r.weight for r in records])
        y = np.concatenate([r.y for r in records])
        passes = records[0].raw.passes
        step = np.array([_power(w, y, _base(records, passes, theta, np.ones(1))) for theta in THETAS])
        plain = float(step.min())
        swept = np.concatenate([_power(w, y, _base(records, passes, theta, GAINS)) for theta in THETAS])
        place = int(np.argmin(swept))
        gain, theta = float(GAINS[place % len(GAINS)]), float(THETAS[place // len(GAINS)])
        fine = gain * np.geomspace(0.9, 1.1, 21)
        near = _power(w, y, _base(records, passes, theta, fine))
        gain, left = float(fine[int(np.argmin(near))]), float(near.min())
        variance = float(np.sum(w * (y - np.average(y, weights=w)) ** 2)) if w.any() else 0.0
        outside = not LEAST <= gain <= MOST
        if outside and left < LEFT_OF_ERROR * plain and left < LEFT_OF_OUTPUT * variance:
            n = max(float(w.sum()), 1.0)
            found.append(WrongScale(system, gain, float(np.sqrt(plain / n)), float(np.sqrt(left / n))))
    return found


def corrected(runs: Sequence[Run], scales: Sequence[WrongScale]) -> list[Run]:
    """Return runs with their outputs divided by the wrong scales."""
    gain = {s.system: s.gain for s in scales}
    return [replace(r, tension_out_n=r.tension_out_n / gain.get(r.system, 1.0)) for r in runs]


def _base(records: Sequence[Record], passes: int, theta: float, gains: Array) -> Array:
    """Return the output of the base model times each gain, shape (gains, samples)."""
    lower, upper = np.exp(-passes * theta), np.exp(passes * theta)
    parts = []
    for r in records:
        # the hold at the start is known only as measured, so it scales with the gain
        start = r.start_n / gains
        u = r.u.reshape(-1, r.factor).mean(axis=1)
        parts.append(np.stack([g * play_operator(u, lower, 0.0, upper, 0.0, s) for g, s in zip(gains, start, strict=True)]))
    return np.concatenate(parts, axis=1)


def _power(w: Array, y: Array, prediction: Array) -> Array:
    return np.asarray(np.sum(w * (y - prediction) ** 2, axis=-1))
