"""The state of a rig with rate-independent friction, and functions over it.

The state of a line is its input, the direction, and how far it has come since it turned (the first level of its memory);
where motion drives the line, the place along the stroke takes that part. A function over it is a sum of hat functions.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from sstl_cli.diagnosis.constants import ALIKE_INPUT, ALIKE_OTHER, ALIKE_WAYS, CLEAR, UNSEEN_SHARE
from sstl_cli.diagnosis.latent import block_mean
from sstl_cli.diagnosis.records import Record

Array = NDArray[np.float64]


def turning(u: Array) -> tuple[Array, Array]:
    """Return the direction of a signal (1 or -1) and its distance from where it last turned, both of shape (n,).

    A reversal shows once the signal has come a clear way back; it has turned where it stood farthest.
    """
    return _turned(np.ascontiguousarray(u, np.float64), CLEAR * float(np.ptp(u)))


@njit(cache=True, nogil=True)
def _turned(u: Array, clear: float) -> tuple[Array, Array]:
    way, since = np.empty(u.size), np.empty(u.size)
    top = bottom = begun = 0
    direction = 0.0
    for i in range(u.size):
        if u[i] >= u[top]:
            top = i
        if u[i] <= u[bottom]:
            bottom = i
        falls = direction >= 0.0 and u[top] - u[i] > clear
        if falls or (direction <= 0.0 and u[i] - u[bottom] > clear):
            turn = top if falls else bottom
            direction = -1.0 if falls else 1.0
            # before the first reversal the direction is the one to where it turns
            way[begun : turn + 1] = -direction if turn > 0 else direction
            begun, top, bottom = turn + 1, i, i
    way[begun:] = direction if direction != 0.0 else 1.0
    last = u[0]
    for i in range(u.size):
        if i > 0 and way[i] != way[i - 1]:
            last = u[i - 1]
        since[i] = abs(u[i] - last)
    return way, since


def state(r: Record) -> tuple[Array, Array, Array]:
    """Return input, second coordinate and direction of a record at its analysis rate, each of shape (n,)."""
    u = block_mean(r.u, r.factor)
    if r.slip is None or r.raw.position_in_mm is None:
        way, since = turning(u)
        return u, since, way
    place = block_mean(block_mean(r.raw.position_in_mm, r.thin)[: len(r.u)], r.factor)
    return u, place, np.where(block_mean(r.slip, r.factor) < 0.0, -1.0, 1.0)


def knots(x: Array, count: int) -> Array:
    """Return knots, shape (count,), that span all but the ends of what a coordinate was; one where it never moved."""
    low, high = np.quantile(x, (UNSEEN_SHARE, 1.0 - UNSEEN_SHARE))
    return np.linspace(low, high, count) if high > low else np.array([low])


def hats(x: Array, knots: Array) -> Array:
    """Return the hat functions of knots at points, shape (n, knots); beyond the ends they stay as they are there."""
    if len(knots) == 1:
        return np.ones((len(x), 1))
    at = np.clip((x - knots[0]) / (knots[1] - knots[0]), 0.0, len(knots) - 1.0)
    return np.asarray(np.maximum(1.0 - np.abs(at[:, None] - np.arange(len(knots))), 0.0))


def design(u: Array, other: Array, way: Array, first: Array, second: Array) -> Array:
    """Return the weights of all knots at states, shape (n, 2 first second): input, then the other; pulling, then releasing."""
    both = (hats(u, first)[:, :, None] * hats(other, second)[:, None, :]).reshape(len(u), -1)
    return np.concatenate((both * (way > 0)[:, None], both * (way < 0)[:, None]), axis=1)


def alike(first: int, second: int) -> Array:
    """Return how alike a function is at the knots of the state, shape (2 first second, 2 first second)."""

    def along(count: int, reach: float) -> Array:
        return np.asarray(np.exp(-np.abs(np.subtract.outer(np.arange(count), np.arange(count))) / reach))

    ways = np.array([[1.0, ALIKE_WAYS], [ALIKE_WAYS, 1.0]])
    return np.asarray(np.kron(ways, np.kron(along(first, ALIKE_INPUT), along(second, ALIKE_OTHER))))


def lasting(r: Record, slow_s: float, far: float) -> Array:
    """Return for how long (s, shape (n,)) what a model leaves of a record is alike: a time, and on the move a path.

    The misfit of a line with rate-independent friction goes along with its state: it stays in a hold, and passes in a slide.
    """
    speed = block_mean(np.abs(r.rate if r.slip is None else r.slip), r.factor)
    return np.asarray(1.0 / (1.0 / slow_s + speed / far))
