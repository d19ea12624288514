"""Records laid end to end, and what their noise is whatever the model does: what no noise changes is laid out once.

A search for the likeliest noise asks for hundreds of noises of the same records.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sstl_cli.diagnosis import tails
from sstl_cli.diagnosis.kalman import BOTH_NEW, MEAN_KEPT, MEAN_NEW, STATE_KEPT, STATE_NEW, TURN
from sstl_cli.diagnosis.latent import block_mean
from sstl_cli.diagnosis.records import Record, starts_of
from sstl_cli.diagnosis.smoother import MOVES
from sstl_cli.diagnosis.wander import Levels, levels
from sstl_cli.diagnosis.whitening import Constants, Noise, Own, Sensor, step_of

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class Layout:
    """Records laid end to end: what their noise is made of and no noise changes, so that many noises are tried at little cost.

    ``begin`` are the samples at which a model begins, of record ``whose``; ``listening`` are those whose smoother was not told of the
    slow noise of the input; ``out`` and ``into`` are the steps of both sensors.
    """

    records: tuple[Record, ...]
    slices: tuple[slice, ...]
    begin: NDArray[np.intp]
    whose: NDArray[np.intp]
    error_n: Array
    first: Mask
    keep: Mask
    listening: Mask
    out: _Steps
    into: _Steps
    law: Array
    root_readings: Array
    jitter_n: Array
    wander: Levels | None

    def constants(self, noise: Noise) -> Constants:
        """Return what the noise of the records is whatever the model does."""
        own = np.column_stack(self.out.coloured(noise.output))
        misfit = scatter_n(self.records)
        for r, s in zip(self.records, self.slices, strict=True):
            if r.misfit_n is not None:
                own[s] = np.column_stack(_scattered(r, noise.output[r.system]))
            elif r.slower != 1.0:
                own[s] *= (1.0, r.slower**2, 1.0, r.slower**2, r.slower**2)
        outputs = [(r, noise.output[r.system]) for r in self.records]
        white_n, slow_n = np.array([(r.louder * s.white_n, r.slower * s.coloured_n) for r, s in outputs]).T
        start = np.zeros(len(self.first))
        start[self.begin] = self.error_n**2 + slow_n[self.whose] ** 2 + misfit[self.begin] ** 2
        law = self._law(noise)
        white = np.maximum(np.repeat(white_n, [len(r) for r in self.records]) / self.root_readings, 1e-9)
        moves = np.ascontiguousarray(law[:, :MOVES])
        return Constants(Own(own), white, law, moves, start, self.keep, self.first, self.jitter_n, self.wander)

    def _law(self, noise: Noise) -> Array:
        """Return the law of the error of the input, (n, 36), with the slow noise of its sensor."""
        law = self.law.copy()
        for r, s in zip(self.records, self.slices, strict=True):
            law[s, MOVES:] *= noise.smoother[r.system] ** 2
        at: Mask | slice = slice(None) if self.listening.all() else self.listening
        # the last state, and what it adds to the mean over a step
        decay, fresh, shown, both, mean = (x[at] for x in self.into.coloured(noise.input))
        law[at, STATE_KEPT], law[at, STATE_NEW], law[at, MEAN_KEPT], law[at, BOTH_NEW] = decay, fresh, shown, both
        law[at, MEAN_NEW] += mean
        # what was kept of it and what is new: at the end of a step less its mean
        power = np.repeat([noise.input[r.system].coloured_n ** 2 for r in self.records], [len(r) for r in self.records])[at]
        law[at, TURN] += power * (decay - shown) ** 2 + np.maximum(fresh + mean - 2.0 * both, 0.0)
        return law


@dataclass(frozen=True)
class _Steps:
    """Steps of a sensor: each is of a kind (system, its length in s, readings), ``which``; at ``begin`` nothing is known of it."""

    kinds: tuple[tuple[str, float, float], ...]
    which: NDArray[np.intp]
    begin: NDArray[np.intp]

    def coloured(self, sensors: Mapping[str, Sensor]) -> tuple[Array, ...]:
        """Return decay, fresh variance, weight in the mean, and variances of what is new in both and in the mean, each (n,)."""
        rows = [
            (step_of(readings, length_s / sensors[k].correlation_s), sensors[k].coloured_n ** 2) for k, length_s, readings in self.kinds
        ]
        table = np.array([(s.kept, s.shown, s.both, s.mean, power) for s, power in rows])
        kept, shown, both, mean, power = np.ascontiguousarray(table.T)[:, self.which]
        b = self.begin
        fresh = 1.0 - kept**2
        # before a record it has been what it is
        fresh[b], both[b], mean[b] = 1.0, (kept * shown + both)[b], (shown**2 + mean)[b]
        kept[b] = shown[b] = 0.0
        return kept, power * fresh, shown, power * both, power * mean


def layout(records: Sequence[Record]) -> Layout:
    """Return records laid end to end."""
    edges = np.concatenate(([0], np.cumsum([len(r) for r in records])))
    started = [(a + s.at // r.factor, i, s) for i, (a, r) in enumerate(zip(edges[:-1], records, strict=True)) for s in starts_of(r)]
    begin = np.array([at for at, _, _ in started])
    first = np.zeros(edges[-1], np.bool_)
    first[begin] = True

    def steps(readings: Sequence[Array]) -> _Steps:
        known: dict[tuple[str, float, float], int] = {}
        which = []
        for r, x in zip(records, readings, strict=True):
            counts, at = np.unique(np.round(x), return_inverse=True)
            which.append(np.array([known.setdefault((r.system, r.dt_s * r.factor, float(c)), len(known)) for c in counts], np.intp)[at])
        return _Steps(tuple(known), np.concatenate(which), begin)

    return Layout(
        tuple(records),
        tuple(slice(a, b) for a, b in itertools.pairwise(edges.tolist())),
        begin,
        np.array([i for _, i, _ in started]),
        np.array([s.error_n for _, _, s in started]),
        first,
        np.concatenate([r.weight for r in records]) > 0,
        np.concatenate([np.full(len(r), not r.told_n) for r in records]),
        steps([r.readings for r in records]),
        steps([np.full(len(r), float(r.factor)) for r in records]),
        np.concatenate([r.error_law for r in records]),
        np.sqrt(np.concatenate([r.readings for r in records])),
        np.concatenate([late_n(r) for r in records]),
        levels([r.wander for r in records], [len(r) for r in records], [(r.system, r.config) for r in records]),
    )


def constants(records: Sequence[Record], noise: Noise) -> Constants:
    """Return what the noise of records is whatever the model does."""
    return layout(records).constants(noise)


def scatter_n(records: Sequence[Record]) -> Array:
    """Return the standard deviation (N, shape (samples,)) of what is known to be left of records about its mean, 0 where nothing is known."""
    return np.concatenate([np.zeros(len(r)) if r.misfit_n is None else r.misfit_n for r in records])


def scatter_rms_n(records: Sequence[Record]) -> Array:
    """Return the root mean square (N, shape (samples,)) of what is known to be left of records about its mean, its jerks included."""
    return np.asarray(scatter_n(records) * np.sqrt(np.concatenate([np.full(len(r), tails.variance(r.tail)) for r in records])))


def late_n(r: Record) -> Array:
    """Return by how much (N, shape (n,)) the input differs where the clock is off: a standard deviation of the mean over a step."""
    return np.asarray(r.jitter_s * np.abs(block_mean(r.rate, r.factor)) / np.sqrt(r.readings))


def _scattered(r: Record, out: Sensor) -> tuple[Array, ...]:
    """Return the columns of ``Own`` of a record with the scatter of an accepted model, which was measured in means as it is."""
    assert r.misfit_n is not None
    slow, spread = coloured(r, out)
    kept = np.exp(-r.dt_s * r.factor / slow)
    before = np.concatenate((spread[:1], spread[:-1]))
    decay, fresh = kept * spread / np.maximum(before, 1e-300), spread**2 * (1.0 - kept**2)
    for s in starts_of(r):
        at = s.at // r.factor
        decay[at], fresh[at] = 0.0, out.coloured_n**2 + r.misfit_n[at] ** 2
    return decay, fresh, decay, fresh, fresh


def coloured(r: Record, out: Sensor) -> tuple[Array, Array]:
    """Return correlation time (s) and standard deviation (N) of what is added to the output, each of shape (n,).

    The scatter of an accepted model adds to the sensor's noise; one filter state carries both, as slow as they are together.
    """
    n = len(r)
    if r.misfit_n is None:
        return np.full(n, out.correlation_s), np.full(n, out.coloured_n)
    total = np.hypot(out.coloured_n, r.misfit_n)
    share = (r.misfit_n / np.maximum(total, 1e-300)) ** 2
    slow = np.exp(share * np.log(r.misfit_s) + (1.0 - share) * np.log(out.correlation_s))
    return slow, total
