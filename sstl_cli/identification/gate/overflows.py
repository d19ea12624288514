"""A number that overflows: beyond one end of its range a channel reads on from the other.

One channel alone cannot tell it from a drop. What tells is that it goes over from its highest reading to its lowest and back,
that with its range more it goes on as it came, that the other end of the line takes no notice, and that it then rises with that one.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from sstl_cli.identification.filtering import median, noise_sd, quantile

Array = NDArray[np.float64]
# part of the span that a jump takes, usual steps of the channel that it is beyond, and part of its span that the other channel moves by meanwhile
JUMP, BEYOND, STEADY = 0.7, 10.0, 0.1
# by how many of the steps beside it, and by how many noises, a channel goes on over the end of its range
AS_BESIDE, NOISES = 2.0, 8.0
# correlation from which on a channel rises with the other one; that of sound outputs with much friction goes down to 0.4
FOLLOWS = 0.2


def turns(values: Array, other: Array) -> NDArray[np.int64]:
    """Return how many times each reading has gone beyond the range of a channel, 0 everywhere where none overflows.

    What reads nothing but for its noise may have gone below it, to the top of the range: -1.

    Parameters
    ----------
    values, other : ndarray, shape (n,)
        Readings of the channel, and of the other end of the line (N) or what else moves with it.

    Examples
    --------
    >>> pull = np.concatenate((np.linspace(0.0, 12.0, 60), np.linspace(12.0, 0.0, 60)))
    >>> int(turns(pull % 10.0, 0.5 * pull).sum()) == int((pull >= 10.0).sum())
    True
    >>> int(turns(np.where(abs(pull - 6.0) < 0.5, 0.0, pull), 0.5 * pull).sum())
    0
    """
    found = _gone_over(values, other)
    return found[0] if found is not None and _follows(values, found[1], other) else np.zeros(len(values), np.int64)


def _follows(values: Array, whole: Array, other: Array) -> bool:
    """Whether a channel rises with the other one once its range is added, and better than as it reads: a line that is pulled does, what drops does not."""
    added, read = (float(np.corrcoef(v, other)[0, 1]) for v in (whole, values))
    return added > max(FOLLOWS, read)


def _gone_over(values: Array, other: Array) -> tuple[NDArray[np.int64], Array] | None:
    """Return how many times a channel has gone beyond its range, and what it would have read, None where it does not go on there as it came."""
    step = np.diff(values)
    over = np.abs(step) > JUMP * float(np.ptp(values))
    if not np.count_nonzero(over) >= 2:
        return None
    # as far as it jumps, and as it goes on meanwhile: its lowest and highest reading are farther apart where a recorder has interpolated between two
    size = median(np.abs(step[over]) + _goes_on(step, over))
    # steps between readings that are held say nothing of how far a channel goes in one
    if size <= BEYOND * median(np.abs(step[step != 0.0])):
        return None
    count = np.concatenate(([0], np.cumsum(-np.sign(step) * over))).astype(np.int64)
    count -= count.min()
    if len(np.unique(values[count != _usual(count)])) == 1:
        # one number again and again tells that a reading is missing
        return None
    whole = values + size * count
    moved = np.abs(np.diff(whole))
    noise = NOISES * noise_sd(whole)
    smooth = moved[over] <= AS_BESIDE * np.maximum(*_beside(moved))[over] + noise
    steady = quantile(np.abs(np.diff(other))[over], 0.9) < STEADY * float(np.ptp(other))
    if not (smooth.all() and steady) or _far_off(values, count, over, moved, noise):
        return None
    below = int(float(values[count == 0].min()) > float(values.max()) - noise)
    return count - below, whole - size * below


def _far_off(values: Array, count: NDArray[np.int64], over: NDArray[np.bool_], moved: Array, noise: float) -> bool:
    """Whether a channel jumps from where most of it reads, and not from an end of that as what goes over a range does: such readings are no tensions."""
    usual = count == _usual(count)
    low, high = quantile(values[usual], 0.02), quantile(values[usual], 0.98)
    k = np.flatnonzero(over)
    k = k[usual[k] != usual[k + 1]]
    if not len(k):
        return False
    # a recorder may have put one reading between the ends of the range
    places = np.where(usual[k], [k, np.maximum(k - 1, 0)], [k + 1, np.minimum(k + 2, len(values) - 1)])
    inside = np.min(np.maximum(np.minimum(values[places] - low, high - values[places]), 0.0), axis=0)
    near = np.maximum(*_beside(np.where(over, 0.0, moved)))[k]
    return median(inside) > AS_BESIDE * median(near) + noise


def _goes_on(step: Array, over: NDArray[np.bool_]) -> Array:
    """Return by how much a channel goes over the end of its range between two samples: as it does on either side."""
    onward = 0.5 * np.add(*_beside(np.where(over, 0.0, step)))
    return np.asarray((-np.sign(step) * onward)[over], np.float64)


def _beside(steps: Array) -> tuple[Array, Array]:
    """Return the step behind each and the one in front of it, 0 where there is none."""
    return np.append(steps[1:], 0.0), np.insert(steps[:-1], 0, 0.0)


def _usual(count: NDArray[np.int64]) -> int:
    """Return how many times most readings have gone beyond the range."""
    return int(np.argmax(np.bincount(count)))


def size_n(values: Array, count: NDArray[np.int64]) -> float:
    """Return the range (N) of a channel that overflows, NaN where it does not: that of its readings, or how far it jumps where they reach farther."""
    if not count.any():
        return math.nan
    over = np.diff(count) != 0
    step, span = np.diff(values), float(np.ptp(values))
    jump = median(np.abs(step[over]) + _goes_on(step, over))
    return span if span <= jump * (1.0 + STEADY) else jump
