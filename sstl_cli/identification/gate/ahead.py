"""An output that comes before its input by so little that friction alone leaves hardly more than noise.

What tells it is the likelihood: lines with a delay leave nothing but the noise of the samples that they are fitted to, and lines without one,
a gain, a zero, creep or friction by speed all leave more. Friction of whatever kind that turns an output early leaves more than noise beside a delay.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sstl_cli.identification.gate.causes import CREEP, GAIN, MORE, ZERO_IN, ZERO_OUT, Causes, best_fit, bundled, by_speed, floor_of
from sstl_cli.identification.gate.playfit import PlayFit
from sstl_cli.identification.gate.sensors import Sensor

Array = NDArray[np.float64]
# standard errors and periods (of log and sensors) from which on a delay is asked about
ERRORS, PERIODS = 6.0, 2.5
# noises that lines with a delay may leave: what is fitted to a thousand samples says their noise to some percent
FITS = 1.1


@dataclass(frozen=True)
class Ahead:
    """By how much an output comes before its input (s, negative), and the noises that are left of it with that delay and with the best of all else."""

    delay_s: float
    left: float
    else_left: float

    @property
    def sure(self) -> bool:
        """Whether the delay explains all but noise, and nothing else does."""
        return self.left < FITS and self.shown

    @property
    def shown(self) -> bool:
        """Whether all that has no delay leaves more than noise."""
        return self.else_left > MORE

    @property
    def tells(self) -> bool:
        """Whether lines with the delay leave less than friction of any law does without one."""
        return self.left < self.else_left


def ahead_of(time_s: Array, x: Array, y: Array, sensors: tuple[Sensor, Sensor], means: int, play: PlayFit, causes: Causes) -> Ahead | None:
    """Return by how much an output leads, None where it does not.

    Parameters
    ----------
    time_s, x, y : ndarray, shape (n,)
        Time in s, input and output in N, each the mean of ``means`` samples.
    """
    a, b = sensors
    period = float(time_s[-1] - time_s[0]) / max(1, len(time_s) - 1) / means
    least = max(ERRORS * play.delay_se, PERIODS * max(period, a.refresh_s, b.refresh_s))
    # samples that a sensor renews together are one
    noises = [s.noise_n / math.sqrt(max(1.0, means / max(1, s.stride))) for s in sensors]
    noise_n = math.hypot(noises[1], math.exp(-causes.friction.wrap) * noises[0])
    if not play.delay_s < -least or not noise_n > 0.0:
        return None
    left, rest = play.delayed_rms_n / noise_n, min(play.rms_n, causes.friction.rms_n) / noise_n
    if not (left < FITS and rest > MORE):
        # an agreeing delay of other runs is all that could be said of it
        return Ahead(play.delay_s, left, rest)
    floor = floor_of(noises[1], y)
    known = [c.rms_n for c in (causes.gain, causes.zero_in, causes.zero_out, causes.creep)]
    if not all(map(math.isfinite, known)):
        known = [best_fit(x, y, bundled(free), floor, play).rms_n for free in (GAIN, ZERO_IN, ZERO_OUT, CREEP)]
    speed = causes.speed.rms_n if math.isfinite(causes.speed.rms_n) else by_speed(time_s, x, y, floor, play).rms_n
    return Ahead(play.delay_s, left, min(rest, speed / noise_n, *(v / noise_n for v in known)))
