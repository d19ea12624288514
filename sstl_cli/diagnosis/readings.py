"""Which samples of a recording are readings: not copies of the one before, not spoilt, not at a limit."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import median_filter, uniform_filter1d

from sstl_cli.core.runs import Run
from sstl_cli.core.sound import TENSIONS
from sstl_cli.core.stretches import stretches
from sstl_cli.diagnosis.clipping import Limit, Pair, limit_of
from sstl_cli.diagnosis.constants import (
    CHANCE_COPIES,
    CLIPPED_SIGMA,
    COPIED,
    COPIED_NOISE_N,
    DOUBT_NATS,
    FEW,
    HALF,
    MIN_READINGS,
    MOST_ALIKE,
    SPIKE_RUN,
)
from sstl_cli.diagnosis.recorder import Faults, limited, scan
from sstl_cli.identification.gate import Sensor, overflows, sensors_of

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
Ranges = Mapping[str, tuple[float, float]]


def unfolded(run: Run, finite: Mask) -> tuple[Run, Ranges]:
    """Return a run whose channels go on beyond their ranges where they overflow, and range and highest reading (N) of those that do.

    Parameters
    ----------
    finite : ndarray of bool, shape (n,)
        Samples that count.
    """
    ranges, whole = {}, {}
    for column, other in (TENSIONS, TENSIONS[::-1]):
        values = getattr(run, column)
        count = overflows.turns(values[finite], getattr(run, other)[finite])
        if count.any():
            size, whole[column] = overflows.size_n(values[finite], count), values.copy()
            whole[column][finite] += size * count
            gone, over = whole[column][finite], np.diff(count) != 0
            # the highest reading, or where what is beyond the range has been seen to jump over its end
            sides = np.sort(np.stack((gone[:-1][over], gone[1:][over])), axis=0)
            top = float(values[finite].max())
            ranges[column] = (size, top if size >= float(np.ptp(values[finite])) else float(np.median(sides)))
    return replace(run, **whole), ranges


def folded(run: Run, ranges: Ranges) -> Run:
    """Return a run as its channels read where they overflow; by how much (N) they are beyond stands in ``extra`` under ``beyond_``."""
    read, beyond = {}, {}
    for column, (size, top) in ranges.items():
        values = getattr(run, column)
        beyond[f"beyond_{column}"] = size * np.maximum(np.ceil((values - top) / size), 0.0)
        read[column] = values - beyond[f"beyond_{column}"]
    return replace(run, extra={**run.extra, **beyond}, **read)


def renewed(run: Run, finite: Mask) -> Run:
    """Return a run whose slow sensors follow straight lines between the instants at which they are renewed.

    A sensor that is refreshed more slowly than it is logged repeats itself: the copies are no readings. Which samples are
    stands in ``extra`` under ``known_`` and the channel.
    """
    channels, marks = {}, {}
    for sensor in sensors_of(run):
        values = getattr(run, sensor.column)
        fresh = finite & np.concatenate(([True], np.diff(values) != 0.0))
        period = sensor.refresh_s / sensor.period_s
        top = values >= np.max(values[finite])
        limit = _standing(top, 2.0 * FEW * period) if sensor.held else limited(np.where(finite, values, np.min(values[finite])))
        fresh |= finite & limit
        rest = fresh[finite & ~limit]
        flickers = _flickers(sensor, values[fresh & ~limit])
        if rest.size and not flickers and _copies(sensor, 1.0 - float(np.mean(rest))) and fresh.sum() >= MIN_READINGS:
            # what is read first, and behind a gap, may be a copy of what was not recorded
            fresh &= limit | np.concatenate(([False], finite[:-1] & (np.rint(np.diff(run.time_s) / sensor.period_s) <= 1.0)))
            if sensor.held:
                fresh |= finite & _alike(fresh, run.time_s / sensor.period_s, period)
            channels[sensor.column] = np.interp(run.time_s, run.time_s[fresh], values[fresh])
            marks[f"known_{sensor.column}"] = fresh.astype(float)
    return replace(run, extra={**run.extra, **marks}, **channels)


def switched(runs: Sequence[Run]) -> dict[str, str]:
    """Return the runs whose outputs take two values and no others in all runs of their system, with what that means.

    Two levels say on which side of one tension the output is. Any slope, zero and curve may lie in between, so that tensions have no
    likelihood; three, as far apart as the converter has them, are a scale. One level is a hold.
    """
    levels: dict[str, dict[str, Array]] = {}
    for run in runs:
        read = run.tension_out_n[gaps(run) == 0]
        if not np.isin(read, (read.min(), read.max())).all():
            # stray samples are no levels
            read = median_filter(read, 2 * SPIKE_RUN + 1, mode="nearest")
        levels.setdefault(run.system, {})[run.run_id] = np.unique(read)
    told = "the output takes two values: they say on which side of one tension it is, and nothing of a slope"
    two = [own for own in levels.values() if len(np.unique(np.concatenate(list(own.values())))) == 2]
    return {run_id: told for own in two for run_id in own}


def _standing(top: Mask, longest: float) -> Mask:
    """Return where the highest level is held for longer than a few renewals: that may be a limit, and was read."""
    found = np.zeros_like(top)
    for a, b in stretches(top):
        found[a:b] = b - a > longest
    return found


def _alike(fresh: Mask, time: Array, period: float) -> Mask:
    """Return the readings that happen to be equal to the one before: where a renewal was due and nothing changed.

    Left out, they would leave only readings that differ, and more noise than there is. Longer rests are no chance.

    Parameters
    ----------
    fresh : ndarray of bool, shape (n,)
        Samples that differ from the one before.
    time : ndarray, shape (n,)
        Instants, a sample apart where nothing is missing.
    period : float
        Samples between two renewals.
    """
    at = np.flatnonzero(fresh)
    due = np.maximum(np.rint(np.diff(time[at]) / period), 1.0).astype(int)
    number = np.concatenate(([0], np.cumsum(due)))
    # a renewal shows at the first sample after it, half a sample late in the mean of the readings around
    clock = uniform_filter1d(time[at] - period * number, 2 * MIN_READINGS + 1) - HALF
    found = np.zeros(len(fresh), bool)
    for k in np.flatnonzero((due > 1) & (due <= MOST_ALIKE)):
        instants = clock[k] + period * (number[k] + np.arange(1, due[k]))
        places = np.clip(np.searchsorted(time, instants), at[k] + 1, at[k + 1] - 1)
        # what was renewed where nothing was recorded nobody saw
        found[places[np.abs(time[places] - instants) <= 1.0]] = True
    return found


def _copies(sensor: Sensor, repeated: float) -> bool:
    """Return whether samples that repeat the one before are copies: noise above the converter's step hardly ever makes one."""
    if sensor.held:
        return True
    if sensor.noise_n <= max(0.5 * sensor.step_n, COPIED_NOISE_N):
        return False
    return repeated > max(COPIED, CHANCE_COPIES * sensor.step_n / (2.0 * float(np.sqrt(np.pi)) * sensor.noise_n))


def _flickers(sensor: Sensor, changed: Array) -> bool:
    """Return whether samples that differ from the one before go to and fro between two levels of the converter.

    Those of a coarse converter at rest do, and look noisier than they are: independent readings with that much noise would
    differ by more from each other.
    """
    if sensor.held or sensor.step_n <= 0.0 or len(changed) < 2:
        return False
    return float(np.mean(np.abs(np.diff(changed)))) < 2.0 / float(np.sqrt(np.pi)) * sensor.noise_n


def gaps(run: Run) -> Array:
    """Return 1 where a run was not recorded and is bridged, 0 elsewhere, shape (n,)."""
    return run.extra.get("gap", np.zeros(len(run)))


def known(run: Run, column: str) -> Mask:
    """Return which samples of a channel are readings, and no copies of the one before."""
    marked = run.extra.get(f"known_{column}")
    return np.ones(len(run), bool) if marked is None else marked > 0.5


def scanned(run: Run, column: str) -> Faults:
    """Return the recorder faults of a channel, looked for among its readings."""
    readings, values = known(run, column), getattr(run, column)
    beyond = run.extra.get(f"beyond_{column}", np.zeros(len(values)))[readings]
    found = scan(values[readings] + beyond, None if readings.all() else run.time_s[readings], (gaps(run) == 0)[readings])
    if beyond.any():
        # what overflows is beyond the limit, and everything else was looked for as if it had not
        found = replace(found, clipped=beyond > 0.0, clip_level_n=float(np.max(values[readings][beyond == 0.0])))
    if readings.all():
        return found

    def spread(flags: Mask) -> Mask:
        out = np.zeros(len(values), bool)
        out[readings] = flags
        return out

    return replace(found, spike=spread(found.spike), frozen=spread(found.frozen), clipped=spread(found.clipped))


def agreed(usable: Sequence[tuple[Run, Faults, Faults]]) -> list[tuple[Run, Faults, Faults]]:
    """Return the runs with the limits that their sensors have: a limit is one of the sensor, not of a run.

    A level that readings share to the last digit is none where another run passes it. Where no reading repeats another, noise may
    enter behind the limit.
    """
    systems = [run.system for run, _, _ in usable]
    sensors = [(system, is_out) for system in sorted(set(systems)) for is_out in (False, True)]
    tried = {s: _limited([u for u, own in zip(usable, systems, strict=True) if own == s[0]], s[1]) for s in sensors}
    # what readings say themselves is no rest of a line, and tells nothing of those of other sensors
    limits = {s: t.limit for s, t in tried.items() if t.limit is not None and not any(f.clipped.any() for f in t.given)}
    sides = {s: iter(t.faults(_usual(s, limits))) for s, t in tried.items()}
    return [(run, next(sides[run.system, False]), next(sides[run.system, True])) for run, _, _ in usable]


@dataclass(frozen=True)
class _Tried:
    """The faults of one sensor in all of its runs, which readings count, and the limit it may have; None where its readings show another."""

    given: list[Faults]
    used: list[Mask]
    limit: Limit | None = None

    def faults(self, usual: float) -> list[Faults]:
        """Return the faults with the limit, if it is beyond doubt where lines are usually short by a share of their tension."""
        return self.given if self.limit is None else _behind_noise(self.given, self.used, self.limit, usual)


def _usual(sensor: tuple[str, bool], limits: Mapping[tuple[str, bool], Limit]) -> float:
    """Return by which share of its tension the line is short at the highest rests of the other sensors; those at one level may share a limit."""
    own = limits.get(sensor)
    others = [
        o for s, o in limits.items() if own is not None and s[1] == sensor[1] and abs(o.level_n - own.level_n) > CLIPPED_SIGMA * own.off_n
    ]
    return max((o.share for o in others), default=0.0)


def _limited(usable: Sequence[tuple[Run, Faults, Faults]], is_out: bool) -> _Tried:
    """Return the faults of one sensor in all of its runs, and the limit that it may have."""
    column = "tension_out_n" if is_out else "tension_in_n"
    given = [b if is_out else a for _, a, b in usable]
    faults = _unpassed(given, max(float(getattr(run, column).max()) for run, _, _ in usable))
    used = [known(run, column) & ~(a.bad | b.bad) & (gaps(run) == 0) for run, a, b in usable]
    if not all(u.any() for u in used):
        return _Tried(faults, used)
    pairs = [Pair(r.tension_in_n[u], r.tension_out_n[u], f.noise_n, is_out) for (r, _, _), f, u in zip(usable, faults, used, strict=True)]
    limit = limit_of(pairs)
    # readings that repeat a limit, to the last digit or to a coarse level, may scatter below it where noise enters behind it, too
    shown = [f.clip_level_n for f in faults if f.clipped.any()]
    near = all(abs(limit.level_n - level) < CLIPPED_SIGMA * max(f.noise_n for f in faults) for level in shown)
    return _Tried(faults, used, limit if near else None)


def _unpassed(faults: Sequence[Faults], top: float) -> list[Faults]:
    """Return the faults of a sensor without limits that its highest reading (N) is beyond by more than noise."""

    def passed(f: Faults) -> bool:
        return bool(f.clipped.any()) and top > f.clip_level_n + CLIPPED_SIGMA * max(f.noise_n, f.step_n)

    return [replace(f, clipped=np.zeros_like(f.clipped), clip_level_n=float("inf")) if passed(f) else f for f in faults]


def _behind_noise(faults: Sequence[Faults], used: Sequence[Mask], limit: Limit, usual: float) -> list[Faults]:
    """Return the faults of a sensor with the limit about which those of its readings scatter that were ``used``, if it is beyond doubt."""
    if limit.nats(usual) <= DOUBT_NATS:
        return list(faults)
    found = []
    for f, u, there in zip(faults, used, limit.there, strict=True):
        clipped = f.clipped.copy()
        clipped[u] |= there
        found.append(replace(f, clipped=clipped, clip_level_n=limit.level_n) if there.any() else f)
    return found
