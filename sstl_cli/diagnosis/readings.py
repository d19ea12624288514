"""Which samples of a recording are readings: not copies of the one before, not spoilt, not at a limit."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from sstl_cli.core.runs import Run
from sstl_cli.diagnosis.constants import CHANCE_COPIES, CLIPPED_RUN, CLIPPED_SIGMA, COPIED, COPIED_NOISE_N, MIN_READINGS, MOST_ALIKE
from sstl_cli.diagnosis.recorder import Faults, limited, scan, stretches
from sstl_cli.identification.gate import Sensor, sensors_of

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]


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
        limit = _standing(top, 2.0 * CLIPPED_RUN * period) if sensor.held else limited(np.where(finite, values, np.min(values[finite])))
        fresh |= finite & limit
        rest = fresh[finite & ~limit]
        flickers = _flickers(sensor, values[fresh & ~limit])
        if rest.size and not flickers and _copies(sensor, 1.0 - float(np.mean(rest))) and fresh.sum() >= MIN_READINGS:
            if sensor.held:
                fresh |= finite & _alike(fresh, period)
            channels[sensor.column] = np.interp(run.time_s, run.time_s[fresh], values[fresh])
            marks[f"known_{sensor.column}"] = fresh.astype(float)
    return replace(run, extra={**run.extra, **marks}, **channels)


def _standing(top: Mask, longest: float) -> Mask:
    """Return where the highest level is held for longer than a few renewals: that may be a limit, and was read."""
    found = np.zeros_like(top)
    for a, b in stretches(top):
        found[a:b] = b - a > longest
    return found


def _alike(fresh: Mask, period: float) -> Mask:
    """Return the readings that happen to be equal to the one before: where a renewal was due and nothing changed.

    Left out, they would leave only readings that differ, and more noise than there is. Longer rests are no chance.

    Parameters
    ----------
    fresh : ndarray of bool, shape (n,)
        Samples that differ from the one before.
    period : float
        Samples between two renewals.
    """
    at = np.flatnonzero(fresh)
    due = np.rint(np.diff(at) / period).astype(int)
    missed = (due > 1) & (due <= MOST_ALIKE)
    found = np.zeros(len(fresh), bool)
    for a, b, parts in zip(at[:-1][missed], at[1:][missed], due[missed], strict=True):
        found[np.rint(np.linspace(a, b, parts + 1)[1:-1]).astype(int)] = True
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
    if readings.all():
        return scan(values)
    found = scan(values[readings])

    def spread(flags: Mask) -> Mask:
        out = np.zeros(len(values), bool)
        out[readings] = flags
        return out

    return replace(found, spike=spread(found.spike), frozen=spread(found.frozen), clipped=spread(found.clipped))


def agreed(usable: Sequence[tuple[Run, Faults, Faults]]) -> list[tuple[Run, Faults, Faults]]:
    """Return the runs without limits that other runs of the same sensor pass: a limit is one of the sensor, not of a run."""
    tops: dict[tuple[str, int], float] = {}
    for item in usable:
        for side, column in ((1, "tension_in_n"), (2, "tension_out_n")):
            key = (item[0].system, side)
            tops[key] = max(tops.get(key, -np.inf), float(getattr(item[0], column).max()))

    def judged(f: Faults, top: float) -> Faults:
        passed = f.clipped.any() and top > f.clip_level_n + CLIPPED_SIGMA * max(f.noise_n, f.step_n)
        return replace(f, clipped=np.zeros_like(f.clipped), clip_level_n=float("inf")) if passed else f

    return [(run, judged(a, tops[run.system, 1]), judged(b, tops[run.system, 2])) for run, a, b in usable]
