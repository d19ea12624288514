"""What a repeated reading says of a sensor: how likely its noise and its converter make it."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sstl_cli.core.stretches import stretches
from sstl_cli.identification.filtering import fast_part

Array = NDArray[np.float64]
# repeats from which on a stretch of them may be no noise
STUCK_SAMPLES = 8
# samples in which noise shows
ENOUGH = 4096
# chance in a whole record below which repeats are none (nats), and what a repeat counts at the most: two equal readings of a record in single precision are no wonder
RARE_NATS, MOST_NATS = -math.log(1e-6), 12.0
# samples on either side between which a channel passes so many levels, and fewest samples on such ways that tell its noise
BESIDE, LEVELS, PASSING = 8, 2.5, 64
# part of its largest reading that two levels differ by at the least
TINY = 1e-9


@dataclass(frozen=True)
class Live:
    """What repeats of one channel say: ``nats`` for each that its noise would not have made (0 where noise does not tell), noise and step in N."""

    nats: float
    noise_n: float
    step_n: float

    def most_repeats(self, samples: int) -> float:
        """Return how often a live sensor repeats a reading at the most in a record of so many samples."""
        return (RARE_NATS + math.log(samples)) / self.nats if self.nats > 0.0 else math.inf


def live_of(values: Array, step_n: float) -> Live:
    """Return what repeats of a channel say.

    Parameters
    ----------
    values : ndarray, shape (n,)
        Readings in N.
    step_n : float
        Step of the converter (N), 0 where there is none.

    Examples
    --------
    >>> noise = np.random.default_rng(0).standard_normal(4000)
    >>> live_of(noise, 0.0).nats, round(live_of(np.round(noise), 1.0).nats, 1)
    (12.0, 0.9)
    """
    gaps = np.diff(np.unique(values))
    # what arithmetic alone tells apart is one level
    gaps = gaps[gaps > TINY * float(np.max(np.abs(values)))]
    # few readings may not show the grid that they are on: its step is at the most the least that two of them differ by
    step = step_n if step_n > 0.0 or not len(gaps) else float(gaps.min())
    question = _in_question(values)
    if not noisy(values[~question]):
        return Live(0.0, 0.0, step)
    moving = ~question & _passes(values, step)
    # rounding adds a twelfth of the squared step, a sixth on a ramp of half a step a sample, and at rest at the edge of a level, which any noise crosses to and fro, a quarter
    rounding = step**2 / (6.0 if np.count_nonzero(moving) > PASSING else 4.0)
    second = fast_part(values[moving if np.count_nonzero(moving) > PASSING else ~question])
    # second differences of noise have 6 of its variances, and go together by -4 of them with the next; a movement adds to the first and takes from the second
    seen = min(float(np.mean(second**2)) / 6.0, -float(np.mean(second[1:] * second[:-1])) / 4.0)
    noise = math.sqrt(max(seen - rounding, 0.0))
    # in the middle of a level, from where noise leads to another one least often
    stays = math.erf(step / (2.0 * math.sqrt(2.0) * noise)) if noise > 0.0 else 1.0
    return Live(min(-math.log(max(stays, 1e-300)), MOST_NATS), noise, step)


def noisy(v: Array) -> bool:
    """Return whether second differences alternate as those of noise do, and do not follow each other as a motion's."""
    second = fast_part(v[:ENOUGH])
    if len(second) < 16:
        return False
    return float(np.sum(second[1:] * second[:-1])) < -0.3 * float(np.sum(second**2))


def lasting(flags: NDArray[np.bool_], least: int) -> NDArray[np.bool_]:
    """Return which flags belong to a stretch of at least so many."""
    out = np.zeros(len(flags), np.bool_)
    for a, b in stretches(flags):
        out[a:b] = b - a >= least
    return out


def _passes(values: Array, step_n: float) -> NDArray[np.bool_]:
    """Return which readings lie on a way through levels, so that rounding is a noise of its own and no level is rested at."""
    out = np.zeros(len(values), np.bool_)
    out[BESIDE:-BESIDE] = np.abs(values[2 * BESIDE :] - values[: -2 * BESIDE]) > LEVELS * step_n
    return out


def _in_question(values: Array) -> NDArray[np.bool_]:
    """Return which readings may be none of a live sensor: the longest repeat, and all long ones of the extremes. Leaving out others would leave but those that noise changed."""
    edges = np.concatenate(([0], np.flatnonzero(np.diff(values) != 0.0) + 1, [len(values)]))
    lengths, held = np.diff(edges), values[edges[:-1]]
    odd = (held == values.max()) | (held == values.min())
    odd[np.argmax(lengths)] = True
    return np.repeat(odd & (lengths > STUCK_SAMPLES), lengths)
