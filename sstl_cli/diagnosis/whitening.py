"""Coloured noise: one autoregressive filter per system, taken from the richest model, applied to all.

While the output is held it remembers one extreme of the input, so the noise of that moment shifts the whole hold. No
filter of innovations describes that: each hold has a level of its own, whose spread is taken from the same residual.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_toeplitz
from scipy.signal import lfilter

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
ORDER = 10
# holds of fewer samples are left to the filter
LEAST_HOLD = 12
# spread of the hold levels (standard deviations of the innovations) that are tried
LEVELS = np.concatenate(([0.0], np.geomspace(0.05, 50.0, 40)))


@dataclass(frozen=True)
class Holds:
    """Random levels of holds, taken out of whitened data: (I + t^2 w w')^(-1/2) for each hold's whitened indicator w.

    ``starts`` cuts all samples into stretches; ``unit`` is w, shape (samples,), 0 outside the holds; ``factor`` has
    one entry a stretch.
    """

    starts: NDArray[np.int64]
    unit: Array
    factor: Array

    def __call__(self, x: Array) -> Array:
        unit = self.unit if x.ndim == 1 else self.unit[:, None]
        level = np.add.reduceat(unit * x, self.starts, axis=0)
        level *= self.factor if x.ndim == 1 else self.factor[:, None]
        return np.asarray(x - unit * np.repeat(level, np.diff(self.starts, append=len(x)), axis=0))


@dataclass(frozen=True)
class Whitener:
    """Filters that turn the noise of each run into white noise of unit variance; ``level`` is the spread of holds (N)."""

    coefficients: tuple[Array, ...]
    scale: tuple[float, ...]
    slices: tuple[slice, ...]
    keep: Array
    level: tuple[float, ...] = ()
    holds: tuple[Holds, ...] = ()

    def __call__(self, columns: Array) -> Array:
        """Return whitened residuals or Jacobian columns, shape (samples,) or (samples, k)."""
        out = np.empty_like(columns)
        for s, a, sigma in zip(self.slices, self.coefficients, self.scale, strict=True):
            out[s] = lfilter(a, [1.0], columns[s], axis=0) / sigma
        out *= self.keep if columns.ndim == 1 else self.keep[:, None]
        for holds in self.holds:
            out = holds(out)
        return out


def identity(slices: list[slice], weight: Array, scale: float = 1.0) -> Whitener:
    """Return the whitener of white noise with one standard deviation (N)."""
    one = np.ones(1)
    return Whitener(tuple(one for _ in slices), tuple(scale for _ in slices), tuple(slices), weight.copy())


def fit_whitener(
    residual: Array, weight: Array, slices: list[slice], groups: list[str], order: int = ORDER, held: Mask | None = None
) -> Whitener:
    """Return autoregressive whiteners fitted to residuals, one per group of runs (system).

    Parameters
    ----------
    residual, weight : ndarray, shape (samples,)
        Residual of the richest model in N, and 0 where the record says nothing.
    groups : list of str
        Group of each run; runs of a group share a filter.
    held : ndarray of bool, shape (samples,), optional
        Where the output is held; then each hold has a level of its own.
    """
    filters = _filters(residual, weight, slices, groups, order)
    white = _assemble(filters, weight, slices, groups)
    if held is None:
        return white
    # the first filter took the levels for slow noise: once more without them
    for _ in range(2):
        spread, levels = _levels(white, residual, held, groups)
        filters = _filters(residual - levels, weight, slices, groups, order)
        white = _assemble(filters, weight, slices, groups)
    return _with_holds(white, held, groups, spread)


def _filters(
    residual: Array, weight: Array, slices: list[slice], groups: list[str], order: int
) -> dict[str, tuple[Array, float]]:
    filters: dict[str, tuple[Array, float]] = {}
    for group in sorted(set(groups)):
        members = [s for s, g in zip(slices, groups, strict=True) if g == group]
        acf = np.zeros(order + 1)
        count = np.zeros(order + 1)
        for s in members:
            x, w = residual[s], weight[s]
            for lag in range(min(order, len(x) - 1) + 1):
                both = w[lag:] * w[: len(w) - lag]
                acf[lag] += float(np.sum(both * x[lag:] * x[: len(x) - lag]))
                count[lag] += float(both.sum())
        acf = acf / np.maximum(count, 1.0)
        acf[0] = acf[0] * (1.0 + 1e-6) + 1e-14
        phi = solve_toeplitz(acf[:-1], acf[1:])
        variance = max(float(acf[0] - phi @ acf[1:]), 1e-3 * float(acf[0]), 1e-14)
        filters[group] = (np.concatenate(([1.0], -phi)), float(np.sqrt(variance)))
    return filters


def spread_whitener(
    sample: Whitener, sample_groups: list[str], weight: Array, slices: list[slice], groups: list[str], held: Mask | None = None
) -> Whitener:
    """Return the filters found on some runs, applied to all runs of the same groups."""
    filters = {g: (a, s) for g, a, s in zip(sample_groups, sample.coefficients, sample.scale, strict=True)}
    white = _assemble(filters, weight, slices, groups)
    if held is None or not sample.level:
        return white
    return _with_holds(white, held, groups, dict(zip(sample_groups, sample.level, strict=True)))


def _stretches(held: Mask, slices: Sequence[slice]) -> list[tuple[int, int, int]]:
    """Return run, start and stop of every hold that is long enough."""
    found = []
    for k, s in enumerate(slices):
        edges = np.flatnonzero(np.diff(np.concatenate(([0], held[s].view(np.int8), [0])))) + s.start
        found += [(k, int(a), int(b)) for a, b in zip(edges[::2], edges[1::2], strict=True) if b - a >= LEAST_HOLD]
    return found


def _indicators(white: Whitener, holds: Sequence[tuple[int, int, int]]) -> list[tuple[int, int, Array]]:
    """Return start, stop and whitened indicator of each hold, with the tail that the filter gives it."""
    found = []
    for k, start, stop in holds:
        a = white.coefficients[k]
        end = min(stop + len(a) - 1, white.slices[k].stop)
        x = np.zeros(end - start)
        x[: stop - start] = 1.0
        found.append((start, end, lfilter(a, [1.0], x) / white.scale[k] * white.keep[start:end]))
    return found


def _levels(white: Whitener, residual: Array, held: Mask, groups: list[str]) -> tuple[dict[str, float], Array]:
    """Return the most likely spread of hold levels (N) of each group, and the levels themselves, shape (samples,)."""
    r = white(residual)
    holds = _stretches(held, white.slices)
    found = _indicators(white, holds)
    power = np.array([float(w @ w) for _, _, w in found])
    guess = np.array([float(w @ r[a:b]) for a, b, w in found]) / np.maximum(power, 1e-300)
    spread: dict[str, float] = {}
    levels = np.zeros_like(residual)
    for group in sorted(set(groups)):
        mine = np.array([groups[k] == group for k, _, _ in holds], bool) & (power > 0)
        scale = white.scale[groups.index(group)]
        spread[group] = 0.0
        if mine.sum() < 4:
            continue
        variance = (LEVELS[:, None] * scale) ** 2 + 1.0 / power[mine]
        cost = np.sum(np.log(variance) + guess[mine] ** 2 / variance, axis=1)
        spread[group] = float(LEVELS[np.argmin(cost)] * scale)
        for i in np.flatnonzero(mine):
            _, a, b = holds[i]
            levels[a:b] = guess[i] * spread[group] ** 2 / (spread[group] ** 2 + 1.0 / power[i])
    return spread, levels


def _with_holds(white: Whitener, held: Mask, groups: list[str], spread: dict[str, float]) -> Whitener:
    holds = _stretches(held, white.slices)
    found = _indicators(white, holds)
    parts = []
    # tails reach into the next hold: every other one at a time
    for parity in (0, 1):
        unit = np.zeros(len(held))
        starts, factors = [0], [0.0]
        for (k, _, _), (a, b, w) in list(zip(holds, found, strict=True))[parity::2]:
            power, t = float(w @ w), spread[groups[k]]
            if t <= 0.0 or power <= 0.0 or a < starts[-1]:
                continue
            if a == starts[-1]:
                starts.pop()
                factors.pop()
            unit[a:b] = w
            starts += [a, b]
            factors += [(1.0 - 1.0 / np.sqrt(1.0 + t * t * power)) / power, 0.0]
        if starts[-1] >= len(held):
            starts.pop()
            factors.pop()
        parts.append(Holds(np.array(starts, np.int64), unit, np.array(factors)))
    return replace(white, holds=tuple(parts), level=tuple(spread[g] for g in groups))


def _assemble(
    filters: dict[str, tuple[Array, float]], weight: Array, slices: list[slice], groups: list[str]
) -> Whitener:
    keep = np.empty_like(weight)
    for s, g in zip(slices, groups, strict=True):
        w, order = weight[s], len(filters[g][0]) - 1
        bad = np.convolve(1.0 - w, np.ones(order + 1))[: len(w)] > 0
        keep[s] = np.where(bad, 0.0, 1.0)
        # the first samples have no past: they are left out rather than guessed
        keep[s][: min(order, len(w))] = 0.0
    return Whitener(tuple(filters[g][0] for g in groups), tuple(filters[g][1] for g in groups), tuple(slices), keep)
