"""Noise that a sensor shows where what it reads stays as it is: windows of holds, freed of their straight line."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtri

from sstl_cli.core.stretches import stretches
from sstl_cli.diagnosis.constants import (
    ALIKE,
    AT_MOST,
    CORRELATIONS_S,
    DECIDES_NATS,
    HELD,
    HOLD_ROUNDS,
    LEAST_WINDOWS,
    LOUDER,
    MEASURED,
    SHORTEST_WINDOW,
    UNKNOWN_COLOUR,
    UNMEASURED,
    WINDOWS_S,
)
from sstl_cli.diagnosis.latent import block_mean
from sstl_cli.diagnosis.records import Record
from sstl_cli.diagnosis.whitening import Step, step_of

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Held:
    """Coloured noise seen in holds: standard deviation (N), by what (natural logarithm) it may be off, correlation time (s)."""

    coloured_n: float
    correlation_s: float
    spread: float = MEASURED


class _Windows(NamedTuple):
    """Windows of holds, one a row, over how much louder than others their white noise is (N), and what that makes of their slow noise.

    NaN where a sensor was not read: one that is refreshed more slowly than it is logged has no two readings in a row.
    """

    rows: Array
    slow: Array

    @property
    def free(self) -> Array:
        """How many numbers of each window are not its straight line, shape (windows,)."""
        return np.asarray(np.isfinite(self.rows).sum(axis=1) - 2.0)


def of_input(r: Record) -> Record:
    """Return a record that holds the means of its input (N) in place of those of its output."""
    block = r.thin * r.factor
    return replace(r, y=block_mean(r.raw.tension_in_n[: len(r) * block], block), louder=1.0, slower=1.0)


def moving(r: Record, white_n: float) -> Array:
    """Return where (1, else 0) the input of a record goes further than its white noise may while a window lasts, shape (n,)."""
    return (np.abs(block_mean(r.rate, r.factor)) * WINDOWS_S[-1] > AT_MOST * white_n).astype(float)


def held_noise(records: Sequence[Record], slides: Sequence[Array], white_n: float, levels: Array) -> tuple[Held, float]:
    """Return the coloured noise that holds show beside the white one, at one of several levels (N), and the white noise (N) there.

    The most likely ones of windows without their straight line (restricted likelihood), from the quieter half of them at
    first, then from all that they can have made: holds that something else disturbs do not count. A sensor behind a filter has
    less noise from one reading to the next, where third differences look, than in means: the white one is then larger.
    """
    windows = _windows(records, slides)
    if len(windows.rows) < LEAST_WINDOWS:
        return Held(UNKNOWN_COLOUR * white_n, CORRELATIONS_S[1], UNMEASURED), white_n
    tries = [(c, tau) for tau in CORRELATIONS_S for c in levels]
    every = _costs(windows, records[0], white_n * LOUDER, levels)
    kept = _undisturbed(every[0], windows.free)
    usual = UNKNOWN_COLOUR * white_n
    nats = np.array([_believed(tries, costs[:, kept, 0].sum(axis=1), usual)[1] for costs in every])
    louder = int(np.argmin(nats)) if nats[0] - nats.min() > DECIDES_NATS else 0
    costs = every[louder]
    kept = _undisturbed(costs, windows.free)
    return _believed(tries, costs[:, kept, 0].sum(axis=1), usual)[0], white_n * float(LOUDER[louder])


def likelier(one: Sequence[Record], other: Sequence[Record], slides: Sequence[Array], white_n: float, levels: Array) -> bool:
    """Whether the same holds are likelier by what the noise of one set of records is than by that of the other; not where there are too few."""
    windows = [_windows(records, slides) for records in (one, other)]
    if len(windows[0].rows) < LEAST_WINDOWS:
        return False
    costs = [_costs(w, records[0], np.array([white_n]), levels)[0] for w, records in zip(windows, (one, other), strict=True)]
    kept = np.logical_and(*(_undisturbed(c, w.free) for c, w in zip(costs, windows, strict=True)))
    of_one, of_other = (c[:, kept, 0].sum(axis=1).min() for c in costs)
    return bool(of_one < of_other)


def _windows(records: Sequence[Record], slides: Sequence[Array]) -> _Windows:
    """Return the longest windows of holds of which there are enough; the last tried where there are not."""
    found: list[tuple[Array, float]] = []
    for window_s in WINDOWS_S:
        length = max(SHORTEST_WINDOW, round(window_s / (records[0].dt_s * records[0].factor)))
        read = [(r, np.where(r.weight > 0, r.y, np.nan), slide < HELD) for r, slide in zip(records, slides, strict=True)]
        found = [(p / r.louder, r.slower / r.louder) for r, y, held in read for p in _pieces(y, held, length)]
        if len(found) >= LEAST_WINDOWS:
            break
    return _Windows(np.array([p for p, _ in found]).reshape(len(found), length), np.array([k for _, k in found]))


def _costs(windows: _Windows, first: Record, white_n: Array, levels: Array) -> Array:
    """Return what coloured noise of every time (s) and level (N) costs on each window beside each white noise (N).

    See ``_window_costs``; shape (whites, times x levels, windows, 2).
    """
    readings, step_s = float(np.median(first.readings)), first.dt_s * first.factor
    white, coloured = np.repeat(white_n / np.sqrt(readings), len(levels)), np.tile(levels, len(white_n))
    found = np.empty((len(CORRELATIONS_S), len(white), len(windows.rows), 2))
    for slow in np.unique(windows.slow):
        at = windows.slow == slow
        for i, tau in enumerate(CORRELATIONS_S):
            found[i, :, at] = _window_costs(windows.rows[at], white, slow * coloured, step_of(readings, step_s / tau)).swapaxes(0, 1)
    return np.concatenate([c.reshape(len(white_n), len(levels), *c.shape[1:]) for c in found], axis=1)


def _undisturbed(costs: Array, free: Array) -> NDArray[np.bool_]:
    """Return the windows that noise alone can have made, shape (windows,): of those that the quieter half of them allow."""
    spread = costs[0, :, 1] / free
    kept = spread <= np.median(spread)
    # the sum of squares of a window has so many degrees of freedom; more than the largest of all windows is no noise
    limit = chdtri(free, 0.5 / len(kept))
    for _ in range(HOLD_ROUNDS):
        now = costs[int(np.argmin(costs[:, kept, 0].sum(axis=1))), :, 1] <= limit
        if (now == kept).all() or now.sum() < LEAST_WINDOWS:
            break
        kept = now
    return kept


def _believed(tries: Sequence[tuple[float, float]], costs: Array, usual_n: float) -> tuple[Held, float]:
    """Return the noise that windows leave possible beside what is usual (N), and its cost (nats).

    What is slower than a window shows next to nothing in it: its level is then what is usual, by a prior (Cauchy's of the
    logarithm, as wide as two sensors are apart) that gives way to what windows say.
    """
    level = np.array([c for c, _ in tries])
    costs = costs + np.log1p((np.log(level / usual_n) / ALIKE) ** 2)
    weight = np.exp(costs.min() - costs)
    nats = float(costs.min() - np.log(weight.mean()))
    weight /= weight.sum()
    centre = float(weight @ np.log(level))
    spread = float(np.sqrt(weight @ (np.log(level) - centre) ** 2))
    near = min(np.unique(level), key=lambda c: abs(np.log(c) - centre))
    slow = [(cost, tau) for (c, tau), cost in zip(tries, costs, strict=True) if c == near]
    return Held(float(np.exp(centre)), min(slow)[1], float(np.clip(spread, MEASURED, ALIKE))), nats


def _window_costs(rows: Array, white_n: float | Array, coloured_n: Array, step: Step) -> Array:
    """Return minus the restricted log likelihood (nats) and the sum of whitened squares of each window.

    Freed of its straight line, a window is turned into the axes of the coloured noise, which are those of every level of it, whatever is white.

    Parameters
    ----------
    rows : ndarray, shape (windows, n)
        Readings (N), NaN where there is none.
    white_n : float or ndarray, shape (levels,)
    coloured_n : ndarray, shape (levels,)

    Returns
    -------
    ndarray, shape (levels, windows, 2)
    """
    length = rows.shape[1]
    lag = np.abs(np.subtract.outer(np.arange(length), np.arange(length)))
    alike = np.where(lag > 0, step.lasting * step.kept ** np.maximum(lag - 1, 0), step.variance)
    line = np.stack((np.ones(length), np.linspace(-1.0, 1.0, length)), axis=1)
    white2 = np.broadcast_to(white_n, coloured_n.shape)[:, None] ** 2
    patterns, which = np.unique(np.isfinite(rows), axis=0, return_inverse=True)
    found = np.empty((len(coloured_n), len(rows), 2))
    for i, read in enumerate(patterns):
        mine = which == i
        free = np.linalg.qr(line[read], mode="complete")[0][:, 2:]
        power, axes = np.linalg.eigh(free.T @ alike[np.ix_(read, read)] @ free)
        variance = coloured_n[:, None] ** 2 * np.maximum(power, 0.0) + white2
        square = (1.0 / variance) @ ((rows[np.ix_(mine, read)] @ (free @ axes)) ** 2).T
        found[:, mine] = np.stack((0.5 * (square + np.log(variance).sum(axis=1, keepdims=True)), square), axis=2)
    return found


def _pieces(y: Array, held: NDArray[np.bool_], length: int) -> list[Array]:
    """Return stretches of a hold that have enough readings, NaN being none."""
    every = [y[start : start + length] for a, b in stretches(held) for start in range(a, b - length + 1, length)]
    return [piece for piece in every if np.count_nonzero(np.isfinite(piece)) >= min(length, SHORTEST_WINDOW)]
