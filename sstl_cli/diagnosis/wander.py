"""How a known rig varies from stretch to stretch: no change, however large it looks beside the noise.

A rig that was modelled is never quite the same twice: friction, zeros and slopes wander a little about what the model says.
Each strength of an effect, and theta, is taken to be drawn anew in every stretch of a record, by as much as it did in the
record that the model was accepted on (variance components of a mixed model, Harville 1977); so it is from run to run, and for the record as a whole. Added to the covariance as directions, this is common to all models that are compared: what
follows such a direction by no more than usual is worth little to any of them, and what goes on alike for many stretches is a change.
"""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sstl_cli.diagnosis.constants import DECIDES_NATS, VARIANCES
from sstl_cli.physics.filters import delayed

Array = NDArray[np.float64]
# which samples
Block = NDArray[np.intp] | slice
Levels = tuple[tuple[Array, Sequence[Block]], ...]


@dataclass(frozen=True)
class Wander:
    """How a record is known to vary: columns (N, shape (n, k)) from stretch to stretch, from run to run, in all that
    was recorded of its system and configuration, and as a whole.

    ``stretches`` are those of the first; no columns stand for nothing.
    """

    stretch: Array
    run: Array
    bend: Array
    whole: Array
    stretches: tuple[slice, ...]

    def late(self, samples: float) -> Wander:
        """Return how it varies where the output is read late by a number of samples."""
        return Wander(
            _late(self.stretch, samples), _late(self.run, samples), _late(self.bend, samples), _late(self.whole, samples), self.stretches
        )


def nowhere(samples: int) -> Wander:
    """Return how a record varies that is not known to vary."""
    none = np.zeros((samples, 0))
    return Wander(none, none, none, none, ())


def _late(columns: Array, samples: float) -> Array:
    return np.column_stack([delayed(c, samples) for c in columns.T]) if columns.size else columns


def levels(records: Sequence[Wander | None], count: Sequence[int], bends: Sequence[Hashable]) -> Levels | None:
    """Return the columns of each level over all records with the blocks in which they are drawn anew; None where nothing is known.

    Parameters
    ----------
    count : sequence of int
        Samples of each record.
    bends : sequence
        System and configuration of each record.
    """
    known = [w for w in records if w is not None]
    if not known or len(known) < len(records):
        return None
    ends = np.cumsum(count)
    runs = [np.arange(int(e) - n, int(e)) for n, e in zip(count, ends, strict=True)]
    stretches = [r[s] for r, w in zip(runs, known, strict=True) for s in w.stretches]
    alike = [np.concatenate([r for r, b in zip(runs, bends, strict=True) if b == bend]) for bend in dict.fromkeys(bends)]
    parts = (
        (np.concatenate([w.stretch for w in known]), stretches),
        (np.concatenate([w.run for w in known]), runs),
        (np.concatenate([w.bend for w in known]), alike),
        (np.concatenate([w.whole for w in known]), [np.arange(int(ends[-1]))]),
    )
    return tuple((columns, [_compact(b) for b in blocks]) for columns, blocks in parts if columns.shape[1])


def _compact(rows: NDArray[np.intp]) -> Block:
    """Return rows that follow one another as a slice, of which no copy need be made."""
    return slice(int(rows[0]), int(rows[-1]) + 1) if len(rows) and rows[-1] - rows[0] == len(rows) - 1 else rows


@dataclass(frozen=True)
class Turned:
    """Innovations with what varies from stretch to stretch taken out; ``log_det`` is what it adds to that of the covariance.

    ``axes`` are orthonormal, (samples, k) of each block, ``less`` by how much each axis is shortened.
    """

    blocks: tuple[Block, ...]
    axes: tuple[Array, ...]
    less: tuple[Array, ...]
    log_det: float

    def __call__(self, columns: Array) -> Array:
        """Return whitened columns, shape (samples, k), from innovations."""
        out = columns.copy()
        for s, axes, less in zip(self.blocks, self.axes, self.less, strict=True):
            out[s] -= axes @ (less[:, None] * (axes.T @ columns[s]))
        return out


def turned(directions: Array, stretches: Sequence[Block]) -> Turned:
    """Return what makes innovations white again where directions vary.

    Parameters
    ----------
    directions : ndarray, shape (samples, k)
        Innovations of one standard deviation of each direction: their covariance is 1 + D D' within a stretch.
    """
    axes, less, log_det = [], [], 0.0
    for s in stretches:
        d = directions[s]
        size, way = np.linalg.eigh(d.T @ d)
        seen = size > 1e-9 * max(float(size.max(initial=0.0)), 1e-9)
        size = size[seen]
        axes.append(d @ (way[:, seen] / np.sqrt(size)))
        less.append(1.0 - 1.0 / np.sqrt(1.0 + size))
        log_det += float(np.sum(np.log1p(size)))
    return Turned(tuple(stretches), tuple(axes), tuple(less), log_det)


def components(directions: Array, remains: Array, stretches: Sequence[Block]) -> Array:
    """Return the standard deviation of each direction from stretch to stretch, in units of the directions; 0 where none is seen.

    One at a time, each time the one whose variance makes what is left most likely beside those before it, as long as that is
    beyond doubt (49 to 1): directions that show alike are then one, and never large against each other: of none more than it shows alone.

    Parameters
    ----------
    directions : ndarray, shape (samples, k)
        Innovations of each direction.
    remains : ndarray, shape (samples,)
        Innovations of what the model leaves.
    """
    found, alone = np.zeros(directions.shape[1]), np.full(directions.shape[1], np.inf)
    seen, left = directions, remains[:, None]
    for _ in range(directions.shape[1]):
        information = np.array([np.sum(seen[s] ** 2, axis=0) for s in stretches])
        score = np.array([seen[s].T @ left[s, 0] for s in stretches])
        variance, gain = _likeliest(information, score)
        # two that nearly cancel one another would vary by far more than either is seen to
        alone = variance = np.minimum(variance, alone)
        gain[found > 0.0] = 0.0
        best = int(np.argmax(gain))
        # one of many directions and few stretches gains a little by chance: what is known to vary is beyond that
        if gain[best] < DECIDES_NATS:
            break
        found[best] = np.sqrt(variance[best])
        turn = turned(seen[:, best : best + 1] * found[best], stretches)
        seen, left = turn(seen), turn(left)
    return found


def _likeliest(information: Array, score: Array) -> tuple[Array, Array]:
    """Return for each direction, alone, its most likely variance and what that gains (nats); of shape (stretches, k) each."""
    usual = information.mean(axis=0)
    # a direction that does not show is not known to vary
    shown = usual > 1e-18 * max(float(usual.max(initial=0.0)), 1e-18)
    scale = np.where(shown, usual, 1.0)
    # variances over what one stretch tells: from a tenth of it to far more than any record shows
    tries = VARIANCES[:, None, None] / scale
    grown = 1.0 + information * tries
    gains = 0.5 * np.sum(score**2 * tries / grown - np.log(grown), axis=1)
    best = np.argmax(gains, axis=0)
    every = np.arange(len(usual))
    return VARIANCES[best] / scale, np.where(shown, gains[best, every], 0.0)


def cut(samples: int, duration_s: float, stretch_s: float) -> list[slice]:
    """Return the stretches of a record, as near to ``stretch_s`` long as whole ones can be."""
    count = max(1, round(duration_s / stretch_s))
    edges = np.linspace(0, samples, count + 1).round().astype(int)
    return [slice(int(a), int(b)) for a, b in zip(edges[:-1], edges[1:], strict=True) if b > a]
