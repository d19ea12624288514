"""The white noise of a channel: from third differences where it rests, or from parabolas through the few readings of a slow sensor."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from sstl_cli.diagnosis.constants import HELD, MIN_READINGS, RESOLVED, WHITE
from sstl_cli.diagnosis.driven import known_input
from sstl_cli.diagnosis.readings import gaps, known
from sstl_cli.diagnosis.recorder import FOURTHS_ERROR, Faults, fourths, slow_noise, white_noise, white_of_fourths
from sstl_cli.diagnosis.records import Record

Array = NDArray[np.float64]


def averaged(records: Sequence[Record]) -> float:
    """Return by what factor the white noise of an output falls in the mean over a step of the simulation."""
    return float(np.sqrt(np.median([r.averaged("tension_out_n") for r in records])))


def white_of_output(mine: Sequence[tuple[Record, Array]]) -> tuple[float, float]:
    """Return the white noise (N) of an output and by what (natural logarithm) it may be off.

    A slow sensor has few readings in a run, and between them the line moves: it shows where all runs together hold.

    Parameters
    ----------
    mine : sequence of (Record, ndarray)
        Runs of the sensor, and by which share each step slides.
    """
    column = "tension_out_n"
    missed = [np.empty(0)]
    for r, s in mine:
        readings = known(r.raw, column)
        if not readings.all():
            rests = np.repeat(s < HELD, r.factor * r.thin) & (gaps(r.raw) == 0)[: len(s) * r.factor * r.thin]
            at = np.flatnonzero(readings[: len(rests)])
            missed.append(fourths(r.raw.tension_out_n[at], r.raw.time_s[at], rests[at]))
    rested = np.concatenate(missed)
    if len(rested) < MIN_READINGS:
        # what bridges a gap or a fault has no noise
        held = [np.repeat(s < HELD, r.factor) & (r.weight_fine > 0) for r, s in mine]
        return typical([white_of(r.y_fine, r, column, h) / r.louder for (r, _), h in zip(mine, held, strict=True)]), WHITE
    white = max(white_of_fourths(rested), typical([least_white(r, column) for r, _ in mine]))
    return white, float(np.hypot(WHITE, FOURTHS_ERROR / np.sqrt(len(rested))))


def white_of(fine: Array, r: Record, column: str, held: NDArray[np.bool_] | None = None) -> float:
    """Return the white noise (N) of a channel of a record, of a slow sensor that of its readings.

    Where the output is ``held`` for long enough it shows there alone: what slides may jump.
    """
    readings, raw = known(r.raw, column), getattr(r.raw, column)
    there = known_input(r.raw, _faults(r, column)) if held is None else held
    white = white_noise(fine, there) if readings.all() else slow_noise(raw[readings], r.raw.time_s[readings])
    return max(white, least_white(r, column))


def least_white(r: Record, column: str) -> float:
    """Return the white noise (N) of a channel that its rounding and that of the model make by themselves."""
    return max(_faults(r, column).rounding_n, RESOLVED * float(np.ptp(getattr(r.raw, column))))


def _faults(r: Record, column: str) -> Faults:
    return r.faults_in if column == "tension_in_n" else r.faults_out


def spacing(records: Sequence[Record], column: str) -> float:
    """Return the time (s) between the values whose third differences show the white noise of a channel."""
    found = []
    for r in records:
        readings = known(r.raw, column)
        found.append(
            float(np.median(np.diff(r.raw.time_s[readings]))) if not readings.all() else r.dt_s if column == "tension_out_n" else r.raw.dt_s
        )
    return float(np.median(found))


def typical(values: Sequence[float]) -> float:
    """Return the middle one of the noises of several runs (N), never 0."""
    return max(float(np.median(values)), 1e-6)
