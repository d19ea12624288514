"""Recorded runs on an equally spaced grid: readings with their own instants, and the stretches that nobody recorded.

A clock that is stamped but not steady puts each reading a little before or after its place on the grid. The reading is moved
there along the slope of the signal behind it, so that it keeps its own noise; between two readings nothing is made up.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from sstl_cli.core.runs import Run
from sstl_cli.core.stretches import stretches
from sstl_cli.diagnosis.constants import AS_BEFORE, AT_MOST, DOUBT_NATS, EVEN, FEW, FIRST_PLACED, HALF, PLACED, SHORTEST_READ, STEADY
from sstl_cli.diagnosis.latent import latent
from sstl_cli.diagnosis.recorder import fourths, quiet, slow_noise, white_noise

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
Places = NDArray[np.int64]


def since_first(runs: Sequence[Run]) -> list[float]:
    """Return how long (s) after the first of all runs each began; 0 for all where no clock went on from one to the next."""
    order = sorted(runs, key=lambda r: float(r.time_s[0]))
    if any(b.time_s[0] < a.time_s[-1] for a, b in itertools.pairwise(order)):
        return [0.0] * len(runs)
    return [float(r.time_s[0] - order[0].time_s[0]) for r in runs]


def before(amounts: Sequence[float], begun: Sequence[float], kinds: Sequence[str]) -> list[float]:
    """Return for each run what those of its kind that began before it on the same clock amount to together."""
    every = list(zip(amounts, begun, kinds, strict=True))
    return [sum(a for a, s, k in every if s < start and k == kind) for _, start, kind in every]


def paced(run: Run, finite: Mask) -> Run:
    """Return a run at the instants of a steady clock, where its readings say that only their stamps jitter.

    A converter keeps time; who writes its readings down need not. At the right instants the curve through neighbours misses a reading by
    its noise, at others by as much as the tension moves meanwhile as well.

    Parameters
    ----------
    finite : ndarray of bool, shape (n,)
        Samples that count.
    """
    time = run.time_s[finite]
    dt = float(np.median(np.diff(time)))
    steady = None if _even(time, dt) else _steady(time, dt)
    if steady is None:
        return run
    nats = 0.0
    for values in (run.tension_in_n[finite], run.tension_out_n[finite]):
        stamped, kept = (quiet(fourths(values, x)) for x in (time, steady))
        if min(stamped, kept) > 0.0:
            # each tells of as many readings together
            nats += len(time) / SHORTEST_READ * float(np.log(stamped / kept))
    if nats <= DOUBT_NATS:
        return run
    instants = run.time_s.copy()
    instants[finite] = steady
    return replace(run, time_s=instants)


def _steady(time: Array, dt: float) -> Array | None:
    """Return the instants (s) of a steady clock, one a reading; None where they are not told by the stamps."""
    count = np.arange(len(time))
    step, begin = np.polyfit(count, time - time[0], 1)
    if np.all(np.abs(time - time[0] - begin - step * count) < HALF * step):
        # nothing is missing
        return np.asarray(time[0] + begin + step * count)
    placed = _places(time, dt)
    return None if placed is None or not np.all(np.diff(placed[0]) > 0) else np.asarray(placed[2] + placed[0] * placed[1])


def _even(time: Array, dt: float) -> bool:
    return bool(np.all(np.abs(np.diff(time) - dt) < EVEN * dt))


def on_grid(run: Run, finite: Mask) -> Run:
    """Return the run on an equally spaced grid (as recorded where it already is); ``extra["gap"]`` marks what was bridged.

    Parameters
    ----------
    finite : ndarray of bool, shape (n,)
        Samples that count.
    """
    time = run.time_s[finite]
    dt = float(np.median(np.diff(time)))
    if finite.all() and _even(time, dt):
        return run
    placed = _places(time, dt)
    if placed is None:
        return _between(run, finite, time, dt)
    at, dt, begin = placed
    grid = begin + np.arange(at[-1] + 1) * dt
    kept = np.concatenate(([True], np.diff(at) > 0))
    at, index = at[kept], np.flatnonzero(finite)[kept]
    early = time[kept] - grid[at]

    def put(name: str, value: Array) -> Array:
        readings = run.extra[f"known_{name}"][index] > 0.5 if f"known_{name}" in run.extra else np.ones(len(at), bool)
        place = _commanded if name == "tension_ref_n" else _moved
        return place(value[index], at, len(grid), readings, early, dt)

    marks: dict[str, Array] = {"gap": _bridged(grid, time), "early_s": np.bincount(at, early, len(grid)).astype(float)}
    for name, values in run.extra.items():
        if name.startswith("known_"):
            marks[name] = np.bincount(at[values[index] > 0.5], minlength=len(grid)).clip(0, 1).astype(float)
    # the slope at an end has one neighbour only: a reading that was moved along it may be anywhere
    inner = slice(1, -1) if np.ptp(early) > EVEN * dt else slice(None)
    return _on_grid(run, grid[inner], {k: v[inner] for k, v in marks.items()}, lambda name, value: put(name, value)[inner])


def _places(time: Array, dt: float) -> tuple[Places, float, float] | None:
    """Return the place of each reading on a steady grid, its step and its first instant (s); None where the clock is far from one."""
    slope, start, n = dt, 0.0, 0
    while n < len(time):
        # a step that is a little wrong is a whole sample wrong at the end: twice as far with each step made better
        n = min(max(2 * n, FIRST_PLACED), len(time))
        at = np.rint((time[:n] - time[0] - start) / slope)
        if at[-1] - at[0] < 1.0:
            return None
        slope, start = np.polyfit(at, time[:n] - time[0], 1)
    early = time - time[0] - start - at * slope
    if np.std(early) > STEADY * slope or np.mean(np.diff(at) > 0.0) < PLACED:
        return None
    begin = time[0] + start + at[0] * slope
    at -= at[0]
    return at.astype(np.int64), float(slope), float(begin)


def _moved(values: Array, at: Places, n: int, readings: Mask, early: Array, dt: float) -> Array:
    """Return a channel on the grid: readings moved to their places along the slope of the signal, straight lines between them."""
    grid = np.arange(n)
    where = at[readings]
    signal = np.interp(grid, where, values[readings])
    known = np.zeros(n, bool)
    known[where] = True
    noise = white_noise(values) if readings.all() else slow_noise(values[readings], where.astype(float))
    slope = latent(signal, dt, noise, known).rate
    return np.interp(grid, where, values[readings] - early[readings] * slope[where])


def _commanded(values: Array, at: Places, n: int, readings: Mask, early: Array, dt: float) -> Array:
    """Return a command on the grid: of the loop's own steps or of the instants of the stamps, wherever it is smoother (it has no noise)."""
    stepped = np.interp(np.arange(n), at[readings], values[readings])
    return min(stepped, _moved(values, at, n, readings, early, dt), key=lambda x: float(np.nansum(np.abs(np.diff(x, 2)))))


def blurred(run: Run, rate: Array, thin: int) -> Array:
    """Return by how much (N) readings that were moved to their places may be off there, shape (n,): where the signal turned.

    Parameters
    ----------
    rate : ndarray, shape (n,)
        Rate of change (N/s) of a channel, on steps of ``thin`` samples.
    """
    early = run.extra.get("early_s")
    if early is None:
        return np.zeros(len(rate))
    moved = np.abs(early[: len(rate) * thin]).reshape(-1, thin).max(axis=1)
    turn = np.abs(np.diff(rate, prepend=rate[:1], append=rate[-1:]))
    return np.asarray(0.5 * moved * np.maximum(turn[1:], turn[:-1]))


def _between(run: Run, finite: Mask, time: Array, dt: float) -> Run:
    """Return a run whose clock is far from steady, on a grid of straight lines between its readings."""
    grid = np.arange(time[0], time[-1] + 0.5 * dt, dt)
    marks = {"gap": _bridged(grid, time)}
    for name, values in run.extra.items():
        if name.startswith("known_"):
            column = getattr(run, name.removeprefix("known_"))[finite]
            marks[name] = _marked(grid, time[values[finite] > 0.5], column[values[finite] > 0.5])
    return _on_grid(run, grid, marks, lambda _, value: np.interp(grid, time, value[finite]))


def _on_grid(run: Run, grid: Array, marks: dict[str, Array], put: Callable[[str, Array], Array]) -> Run:
    """Return a run at the instants of a grid, with marks beside its channels; ``put`` brings a channel, by its name, there."""

    def there(name: str, value: Array | None) -> Array | None:
        return None if value is None else put(name, value)

    return replace(
        run,
        time_s=grid,
        tension_in_n=put("tension_in_n", run.tension_in_n),
        tension_out_n=put("tension_out_n", run.tension_out_n),
        position_in_mm=there("position_in_mm", run.position_in_mm),
        tension_ref_n=there("tension_ref_n", run.tension_ref_n),
        extra=marks,
    )


def _bridged(grid: Array, time: Array) -> Array:
    """Return which instants of a grid (1, else 0) lie in stretches that are bridged by a line that nobody measured."""
    dt = grid[1] - grid[0]
    behind = np.searchsorted(time, grid).clip(1, len(time) - 1)
    distance = np.minimum(np.abs(grid - time[behind - 1]), np.abs(grid - time[behind]))
    found = np.zeros(len(grid))
    for a, b in stretches(distance > 0.5 * dt):
        if distance[a:b].max() > 2.0 * dt:
            found[a:b] = 1.0
    return found


def _marked(grid: Array, time: Array, readings: Array) -> Array:
    """Return which samples of a grid stand for a reading beside them (1) or for none.

    A reading at a turn of the signal stands for no other instant: what it would be there is further off than its noise.
    """
    step = grid[1] - grid[0]
    at = np.rint((time - grid[0]) / step).astype(int).clip(0, len(grid) - 1)
    slope = np.diff(readings) / np.diff(time)
    turn = np.zeros(len(readings))
    turn[1:-1] = np.abs(np.diff(slope))
    sound = np.abs(grid[at] - time) * turn <= 2.0 * slow_noise(readings, time)
    return np.bincount(at[sound], minlength=len(grid)).clip(0, 1).astype(float)


@dataclass(frozen=True)
class Corners:
    """Where an input may have passed its highest and lowest samples between them, shape (n,) each, 0 elsewhere.

    At the first sample after it: ``back`` is from there to the highest or lowest sample (N), ``beyond`` on from that to where the
    straight lines meet (N), ``short`` by how much less for each second that the drive lags (N/s).
    """

    back: Array
    beyond: Array
    short: Array

    def moved(self, lag_s: float) -> Array:
        """Return how far the input goes (N, shape (n,)) at the first samples after its corners, behind a drive of a lag (s)."""
        return np.asarray(self.back + np.sign(self.beyond) * np.maximum(np.abs(self.beyond) - lag_s * self.short, 0.0))


def cornered(u: Array, dt_s: float) -> Corners | None:
    """Return where the input may have passed its highest and lowest samples between them, None if nowhere.

    What a line holds after a turn is the extreme that was reached, not the one that was sampled: where the input turns at a
    corner, it is where the straight lines on both sides meet. A smooth turn leaves its tangents before they meet. Behind a drive
    with a first-order lag tau the extreme stays tau b ln(1 + a / b) before that point, for slopes a before and b behind it.

    Parameters
    ----------
    u : ndarray, shape (n,)
        Input (N) on a grid of ``dt_s``.
    """
    k = np.flatnonzero((u[1:-1] - u[:-2]) * (u[2:] - u[1:-1]) <= 0.0) + 1
    k = k[(k > 2) & (k < len(u) - 3)]
    # a smoothed rate turns a sample early: chords on both sides do not
    before, after = (u[k - 1] - u[k - 3]) / (2.0 * dt_s), (u[k + 3] - u[k + 1]) / (2.0 * dt_s)
    turning = before * after < 0.0
    k, before, after = k[turning], before[turning], after[turning]
    # from the samples beside: x is how long after sample k - 1 the lines meet
    x = (u[k + 1] - u[k - 1] - 2.0 * dt_s * after) / (before - after)
    beyond = u[k - 1] + before * x - u[k]
    expected = np.where(x > dt_s, u[k - 1] + before * dt_s, u[k + 1] - after * dt_s)
    sharp = (x > 0.0) & (x < 2.0 * dt_s) & (beyond * before > 0.0) & (np.abs(expected - u[k]) < HALF * np.abs(beyond))
    if not sharp.any():
        return None
    k, x, beyond, a, b = k[sharp], x[sharp], beyond[sharp], np.abs(before[sharp]), np.abs(after[sharp])
    # what turns after a sample has not turned at it; the next one is within the hold, where the input shows nowhere
    at = k + (x > dt_s)

    def placed(values: Array) -> Array:
        found = np.zeros(len(u))
        found[at] = values
        return found

    return Corners(placed(u[k] - u[at]), placed(beyond), placed(b * np.log1p(a / b)))


def tops(u: Array) -> tuple[Array, Array]:
    """Return how far (N) a smooth input passes its highest and lowest samples by the parabola through each and its neighbours, and how
    far it could at most, shape (n,) each; 0 elsewhere.

    Parameters
    ----------
    u : ndarray, shape (n,)
        Input (N) on an even grid.
    """
    beyond, most = np.zeros(len(u)), np.zeros(len(u))
    before, after = np.diff(u)[:-1], np.diff(u)[1:]
    bend = after - before
    k = np.flatnonzero(before * after < 0.0)
    # half a sample off, by half of the curvature
    most[k + 1] = -0.5 * 0.5**2 * bend[k]
    beyond[k + 1] = most[k + 1] * ((after[k] + before[k]) / bend[k]) ** 2
    return beyond, np.abs(most)


def hiding(gap: Mask, u: Array, step_n: Array, noise_n: float) -> list[tuple[int, int]]:
    """Return the stretches of a gap in which the input may have turned: a turn that nobody saw decides all that follows.

    It has not where it goes on as it came, and came as far as that takes.

    Parameters
    ----------
    gap : ndarray of bool, shape (n,)
    u, step_n : ndarray, shape (n,)
        Input (N), bridged, and its change per sample.
    """
    found, gaps = [], list(stretches(gap))
    ends, starts = [0, *(b for _, b in gaps)], [*(a for a, _ in gaps[1:]), len(u)]
    for (a, b), first, last in zip(gaps, ends, starts, strict=False):
        before, after = max(a - 1, 0), min(b, len(u) - 1)
        # what bridges a gap bends the input beside it: the mean of a few samples is its own
        came = float(np.mean(step_n[min(max(a - FEW, first), before) : before + 1]))
        goes = float(np.mean(step_n[after : max(min(b + FEW, last), after + 1)]))
        moved, usual = u[after] - u[before], 0.5 * (came + goes) * (after - before)
        same = came * goes > 0.0 and abs(moved - usual) <= AS_BEFORE * abs(moved) + AT_MOST * noise_n
        if not same:
            found.append((a, b))
    return found
