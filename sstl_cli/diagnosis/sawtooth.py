"""Stick-slip told by its shape: the output lags, then jumps in the direction of motion, again and again.

The moment of each jump is chaotic, so that no simulation meets it; the skewness of the residual's
increments along the motion does not depend on the moment. Noise, ripple and hum have none.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sstl_cli.diagnosis.simulator import Simulator

Array = NDArray[np.float64]
STEP_S = 0.06
MIN_SAMPLES = 200
LEAST_SKEWNESS = 0.25
LEAST_RATIO = 1.25
COLOURED_RATIO = 0.8
# effects whose friction falls with slip, speed or motion after rest: all of them jump on an elastic line
FAMILY = ("dwell_aging", "stick_slip", "stribeck")


@dataclass(frozen=True)
class Sawtooth:
    """Skewness of increments along the motion, its standard error, and their power over that in holds."""

    skewness: float
    error: float
    power_ratio: float

    @property
    def forward(self) -> bool:
        """Whether increments are skewed along the motion beyond chance."""
        return self.skewness > LEAST_SKEWNESS and self.skewness > 5.0 * self.error

    def present(self, coloured: float) -> bool:
        """Whether jumps along the motion are beyond doubt; ``coloured`` is the share of coloured noise, 0 to 1.

        Coloured noise of the input passes through only while the line slides, which raises the ratio too.
        """
        quiet = LEAST_RATIO + COLOURED_RATIO * coloured
        return self.forward and self.power_ratio > quiet


def sawtooth(sim: Simulator, residual: Array, code: NDArray[np.int64]) -> Sawtooth:
    """Return the evidence of jumps in a residual (N, shape (samples,)), given the phase of each sample."""
    moving, still = [], []
    for r, s in zip(sim.problem.records, sim.slices(), strict=True):
        step = max(1, round(STEP_S / (r.dt_s * r.factor)))
        x, c, w = residual[s], code[s], r.weight
        increment = x[step:] - x[:-step]
        same = (c[step:] == c[:-step]) & (w[step:] > 0) & (w[:-step] > 0)
        slides = same & ((c[step:] == 1) | (c[step:] == 3))
        direction = np.where(c[step:] == 1, 1.0, -1.0)
        moving.append((direction * increment)[slides])
        still.append(increment[same & ((c[step:] == 0) | (c[step:] == 2))])
    along, held = np.concatenate(moving), np.concatenate(still)
    if len(along) < MIN_SAMPLES:
        return Sawtooth(0.0, 1.0, 1.0)
    along = along - np.median(along)
    power = float(np.mean(along**2))
    quiet = float(np.mean(held**2)) if len(held) >= MIN_SAMPLES else power
    skewness = float(np.mean(along**3) / max(power, 1e-300) ** 1.5)
    # overlapping increments: about one in three is independent
    return Sawtooth(skewness, float(np.sqrt(15.0 / (len(along) / 3.0))), power / max(quiet, 1e-300))
