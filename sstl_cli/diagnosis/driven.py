"""The latent input that drives the simulation of a run, and what is not known of it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sstl_cli.core.runs import Run
from sstl_cli.diagnosis.clock import Corners, blurred, cornered, tops
from sstl_cli.diagnosis.kalman import MEAN_NEW, TURN
from sstl_cli.diagnosis.latent import NOTHING, Told
from sstl_cli.diagnosis.means import bridged, latent_means
from sstl_cli.diagnosis.readings import gaps, known
from sstl_cli.diagnosis.recorder import Faults
from sstl_cli.diagnosis.smoother import error_of_means

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
# mean square of a number that is anywhere between 0 and 1
WITHIN = 1.0 / 3.0


@dataclass(frozen=True)
class Input:
    """The input of a record as the simulation is driven by it, and what is not known of it (see Record)."""

    u: Array
    rate: Array
    error_n: Array
    error_law: Array
    corner: Corners | None
    rounds: Array


def known_input(run: Run, faults: Faults) -> Mask:
    """Return which readings of the input say what it was, shape (n,)."""
    return np.asarray(~(faults.bad | faults.clipped) & (gaps(run) == 0))


def input_of(run: Run, faults: Faults, thin: int, factor: int, n: int, dt: float, told: Told = NOTHING) -> Input:
    """Return the input of a run on the grid of the simulation: ``n`` steps of ``thin`` readings, ``factor`` of them a sample of the analysis."""
    signal = bridged(run.tension_in_n, ~faults.bad)
    into = latent_means(signal, known_input(run, faults), known(run, "tension_in_n"), faults.rounding_n, thin, n, dt, told)
    # no corner is quite sharp: the extreme is anywhere between the sample and where the lines meet
    corner = None if told.rounded else cornered(into.value, dt)
    # where it is rounded, it is highest between samples, though by no law that is known
    top, most = tops(into.value) if told.rounded else (0.0, 0.0)
    error_law, error_n = error_of_means(into.chain, factor)
    open_ = np.hypot(0.5 * most, into.doubt) if corner is None else np.hypot(corner.beyond * np.sqrt(WITHIN), into.doubt)
    blur, shown = at_corners(np.hypot(blurred(run, into.rate, thin), open_), factor, None if corner is None else np.abs(corner.beyond))
    error_law[:, MEAN_NEW] += (shown * blur) ** 2
    error_law[:, TURN] += (1.0 - shown**2) * blur**2
    return Input(into.value + top, into.rate, np.hypot(error_n, blur), error_law, corner, into.rounds)


def at_corners(open_n: Array, factor: int, beyond: Array | None = None) -> tuple[Array, Array]:
    """Return what steps leave open of a corner (N), and the share of the step behind it, shape (n,) each.

    The mean over a step shows a corner from there on; what is held shows all of it. Where a corner goes ``beyond`` its sample, it is
    there, whatever else is open in its step: what is known of it later is taken off again at the same place.
    """
    steps = open_n.reshape(-1, factor)
    at = np.argmax(steps, axis=1)
    if beyond is not None:
        corners = beyond.reshape(-1, factor)
        at = np.where(corners.max(axis=1) > 0.0, np.argmax(corners, axis=1), at)
    return steps.max(axis=1), 1.0 - at / factor
