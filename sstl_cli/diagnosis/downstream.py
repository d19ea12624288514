"""What a diagnosis is worth: tracking error of a controller designed without and with the named effect."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sstl_cli.control.controller import Controller, Options, Theta
from sstl_cli.control.plant import Plant, Track, track
from sstl_cli.control.presliding import fit_widths, play_sum
from sstl_cli.control.references import Reference, random, sinusoid
from sstl_cli.control.scoring import score, windows
from sstl_cli.control.sim_plant import plant_of
from sstl_cli.core.errors import SstlError
from sstl_cli.core.rng import stream
from sstl_cli.diagnosis.constants import (
    COS_END,
    CYCLE_S,
    DT_S,
    LEAST_MISFIT_N,
    LEAST_SAMPLES,
    LEAST_SLOPE,
    RANDOM_S,
    ROUNDED,
    SLIDING,
    STEEP,
    STROKE_N,
)
from sstl_cli.physics.scenario import Scenario

Array = NDArray[np.float64]


OPTIONS = Options(dt_s=DT_S, reversal="play")


@dataclass(frozen=True)
class Tracking:
    """RMSE (N) of tracking a reference with a controller designed without and with the effect."""

    reference: str
    rmse_without_n: float
    rmse_with_n: float


def tracking(model: Scenario, config_id: str, before: Scenario) -> list[Tracking]:
    """Return tracking errors on the accepted model of one configuration.

    Without the effect the controller is fitted to a full stroke of the re-tuned simulator as it was given, with what it held. With
    it, it is fitted to what the accepted model does on a full stroke and on the task itself, and kept as it was where the model says
    that this is better.

    Parameters
    ----------
    model, before : Scenario
        The accepted simulator, and the re-tuned one without what was found.

    Raises
    ------
    SstlError
        E920 if one of them shows no propagation.
    """
    plant = plant_of(model, config_id)
    without, known = _designed(plant_of(before, config_id)), _designed(plant)
    references = (sinusoid(DT_S), random(stream(0, "downstream"), DT_S, RANDOM_S))
    return [_compared(without, known, plant, r) for r in references]


def _designed(plant: Plant) -> Controller:
    """Return the controller that is fitted to what a plant does on a full stroke."""
    t_in = _stroke()
    t_out = plant.tendon(t_in, DT_S)
    lines = _lines(t_in, t_out)
    return Controller(lines, OPTIONS.model_copy(update={"widths": _rounding(lines, t_in, t_out)}))


def _compared(without: Controller, known: Controller, plant: Plant, reference: Reference) -> Tracking:
    """Return the error of a controller, and the least of it, of one that knows a full stroke, and of fits to what both make of the task.

    Friction that follows load, speed, time or path shows other lines on a full stroke than on the task.
    """
    errors = []
    for first in (without, known):
        answer = track(first, plant, reference.tension_n)
        fitted = _fitted(Controller(known.theta, OPTIONS), answer)
        errors += [_rmse(answer, reference), _rmse(track(fitted, plant, reference.tension_n), reference)]
    return Tracking(reference.name, errors[0], min(errors))


def _fitted(start: Controller, answer: Track) -> Controller:
    """Return the controller whose lines and widths describe best what a plant made of a command."""
    lines = _nearest(start.theta, np.ones(1), answer.tension_in, answer.tension_out)
    widths = _rounding(lines, answer.tension_in, answer.tension_out)
    if widths is not None:
        lines = _nearest(lines, np.array(widths), answer.tension_in, answer.tension_out)
    return Controller(lines, OPTIONS.model_copy(update={"widths": widths}))


def _nearest(start: Theta, widths: Array, t_in: Array, t_out: Array) -> Theta:
    """Return the lines whose plays of relative ``widths`` leave the least squares of the output; ``start`` if they are none."""
    from scipy.optimize import least_squares

    own = np.array([start.gamma_p, start.beta_p, start.gamma_r, start.beta_r])
    fit = least_squares(lambda x: play_sum(t_in, widths, *x) - t_out, own, x_scale="jac")
    found = Theta(*(float(v) for v in fit.x))
    return found if 0.0 < found.gamma_p <= found.gamma_r else start


def _rounding(lines: Theta, t_in: Array, t_out: Array) -> tuple[float, ...] | None:
    """Return the widths of the plays that a loop adds up to, None where one play explains it about as well."""
    widths = fit_widths(lines, t_in, t_out)

    def misfit(shares: Array) -> float:
        model = play_sum(t_in, shares, lines.gamma_p, lines.beta_p, lines.gamma_r, lines.beta_r)
        return float(np.sqrt(np.mean((model - t_out) ** 2)))

    sharp = misfit(np.ones(1))
    return widths if misfit(np.array(widths)) < ROUNDED * sharp and sharp > LEAST_MISFIT_N else None


def lines_of(plant: Plant, stroke_n: tuple[float, float] = STROKE_N) -> Theta:
    """Return the propagation lines that a plant shows on a full stroke (N) at the speed of the task, by least squares.

    Raises
    ------
    SstlError
        E920 if it shows no propagation.
    """
    t_in = _stroke(stroke_n)
    return _lines(t_in, plant.tendon(t_in, DT_S))


def _stroke(stroke_n: tuple[float, float] = STROKE_N) -> Array:
    """Return the input tension (N) of two cycles over the stroke."""
    low, high = stroke_n
    return np.asarray(0.5 * (low + high) - 0.5 * (high - low) * np.cos(_phase()))


def _phase() -> Array:
    return np.asarray(2.0 * np.pi * np.arange(0.0, 2.0 * CYCLE_S, DT_S) / CYCLE_S)


def _lines(t_in: Array, t_out: Array) -> Theta:
    rate_in, rate_out = np.gradient(t_in), np.gradient(t_out)
    # at the ends of the stroke a central difference mixes both directions; the first cycle begins on the pull line
    trimmed = (np.abs(np.cos(_phase())) < COS_END) & (_phase() >= 2.0 * np.pi)
    lines = []
    for side in (rate_in > 0.0, rate_in < 0.0):
        stretch = trimmed & side
        slope = rate_out[stretch] / rate_in[stretch]
        # fully sliding: a loop that rounds into its line has a lower slope before
        sliding = slope > SLIDING * np.quantile(slope, STEEP)
        if not np.all(np.isfinite(slope)) or slope.max() <= LEAST_SLOPE or sliding.sum() < LEAST_SAMPLES:
            raise SstlError("the accepted model shows no propagation on a full stroke", code="E920")
        lines += [float(v) for v in np.polyfit(t_in[stretch][sliding], t_out[stretch][sliding], 1)]
    return Theta(*lines)


def _rmse(done: Track, reference: Reference) -> float:
    window = list(windows(reference.time_s, reference.cycle_s).values())[-1]
    return score(reference.tension_n[window], done.tension_out[window]).rmse_n
