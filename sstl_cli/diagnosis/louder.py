"""Noise of an output that differs from run to run: by what factor each run is louder than its sensor mostly is."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from sstl_cli.diagnosis.constants import FINEST, HELD, LEVELS, MIN_READINGS, WHITE
from sstl_cli.diagnosis.holds import likelier
from sstl_cli.diagnosis.latent import block_mean
from sstl_cli.diagnosis.readings import known
from sstl_cli.diagnosis.recorder import THIRDS_ERROR, four_in_a_row, white_of_thirds
from sstl_cli.diagnosis.records import Record
from sstl_cli.diagnosis.white import least_white

Array = NDArray[np.float64]


def unalike(records: Sequence[Record], fitted: Sequence[Array], slides: Sequence[Array]) -> tuple[Record, ...]:
    """Return the records with what each is louder by, as far as noise differs between runs of a sensor by more than it is known.

    Third differences of what a model leaves hold neither movement nor what is slow. How far runs differ is itself estimated
    (DerSimonian and Laird 1986, of logarithms), so that runs as loud as one another are taken for equally loud. The slow noise
    differs as the white one does, or not at all: whichever makes the holds likelier.

    Parameters
    ----------
    fitted : sequence of ndarray, shape (n * factor,)
        What a model predicts of each record (N).
    slides : sequence of ndarray, shape (n,)
        Share of each step in which it slides.
    """
    found = list(records)
    for system in {r.system for r in records}:
        own = [i for i, r in enumerate(records) if r.system == system]
        louder = _of_sensor([records[i] for i in own], [fitted[i] for i in own], [slides[i] for i in own])
        for i, r in zip(own, louder, strict=True):
            found[i] = r
    return tuple(found)


def _of_sensor(records: list[Record], fitted: list[Array], slides: list[Array]) -> list[Record]:
    least = max(least_white(r, "tension_out_n") for r in records)
    seen = np.array([_seen(r, y, slide, least) for r, y, slide in zip(records, fitted, slides, strict=True)])
    shown, more = np.isfinite(seen[:, 1]), np.ones(len(records))
    more[shown] = np.exp(_shrunk(*seen[shown].T))
    if (more == 1.0).all():
        return records
    white = [replace(r, louder=float(k)) for r, k in zip(records, more, strict=True)]
    both = [replace(r, slower=r.louder) for r in white]
    white_n = float(np.exp(np.median(seen[shown, 0])))
    return both if likelier(both, white, slides, white_n, white_n * LEVELS) else white


def _seen(r: Record, fitted: Array, slide: Array, least_n: float) -> tuple[float, float]:
    """Return the logarithm of the white noise (N) in the holds of a record, and its error; infinite where they do not show it."""
    rests = (r.weight > 0) & (slide < HELD)
    third = np.abs(np.diff(r.y - block_mean(fitted, r.factor), 3))[four_in_a_row(rests)]
    if len(third) < MIN_READINGS or not known(r.raw, "tension_out_n").all():
        return 0.0, float("inf")
    # noise of one step, of which a sample of the analysis is a mean
    white = max(white_of_thirds(third) * float(np.sqrt(np.median(r.readings))), least_n)
    if white <= FINEST * float(np.ptp(r.u)):
        # arithmetic has left its rounding, or nothing: one of these over the other has no bound
        return 0.0, float("inf")
    return float(np.log(white)), float(np.hypot(WHITE, THIRDS_ERROR / np.sqrt(len(third))))


def _shrunk(values: Array, errors: Array) -> Array:
    """Return by what values differ from their middle as far as they differ by more than their errors, shape (k,)."""
    if len(values) < 2:
        return np.zeros(len(values))
    weight = errors**-2
    off = float(weight @ (values - weight @ values / weight.sum()) ** 2)
    between = max(off - (len(values) - 1), 0.0) / (weight.sum() - weight @ weight / weight.sum())
    return np.asarray(between / (between + errors**2) * (values - np.median(values)))
