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
    ROUNDS,
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

    Both controllers come from one procedure (:func:`_designed`) that asks their own model alone, and both drive the accepted one. So
    models that are alike give the same error twice, and what is known of the effect may turn out to be of no use, or worse.

    Parameters
    ----------
    model, before : Scenario
        The accepted simulator, and the re-tuned one without what was found.

    Raises
    ------
    SstlError
        E920 if one of them shows no propagation.
    """
    plant, own = plant_of(model, config_id), plant_of(before, config_id)
    without, known = _of_stroke(own), _of_stroke(plant)
    found = []
    for reference in (sinusoid(DT_S), random(stream(0, "downstream"), DT_S, RANDOM_S)):
        blind, knowing = _designed(without, own, reference), _designed(known, plant, reference)
        errors = (_rmse(track(c, plant, reference.tension_n), reference) for c in (blind, knowing))
        found.append(Tracking(reference.name, *errors))
    return found


def _of_stroke(model: Plant) -> list[Controller]:
    """Return the controllers that are fitted to what a model does on a full stroke: of one play, and of several where it is rounded."""
    t_in = _stroke()
    t_out = model.tendon(t_in, DT_S)
    lines = _lines(t_in, t_out)
    widths = _rounding(lines, t_in, t_out)
    rounded = [] if widths is None else [Controller(lines, OPTIONS.model_copy(update={"widths": widths}))]
    return [Controller(lines, OPTIONS), *rounded]


def _designed(of_stroke: list[Controller], model: Plant, reference: Reference) -> Controller:
    """Return which controller tracks a reference best by the model it is designed from: one of a full stroke, or a fit to the task.

    Friction that follows load, speed, time or path shows other lines on a full stroke than on the task.
    """
    best, least = of_stroke[0], np.inf
    for first in of_stroke:
        tried = first
        for left in reversed(range(ROUNDS + 1)):
            answer = track(tried, model, reference.tension_n)
            error = _rmse(answer, reference)
            if error < least:
                best, least = tried, error
            if left:
                tried = _fitted(first, answer, _scored(reference))
    return best


def _fitted(first: Controller, answer: Track, scored: slice) -> Controller:
    """Return the controller whose lines, and widths if ``first`` has some, describe best what a model made of a command where it is scored."""
    lines = _nearest(first.theta, np.ones(1), answer, scored)
    if first.options.widths is None:
        return Controller(lines, OPTIONS)
    widths = _rounding(lines, answer.tension_in, answer.tension_out)
    if widths is not None:
        lines = _nearest(lines, np.array(widths), answer, scored)
    return Controller(lines, OPTIONS.model_copy(update={"widths": widths}))


def _nearest(start: Theta, widths: Array, answer: Track, scored: slice) -> Theta:
    """Return the lines whose plays of relative ``widths`` leave the least squares of the output; ``start`` if they are none."""
    from scipy.optimize import least_squares

    t_in, t_out = answer.tension_in, answer.tension_out
    own = np.array([start.gamma_p, start.beta_p, start.gamma_r, start.beta_r])
    fit = least_squares(lambda x: (play_sum(t_in, widths, *x) - t_out)[scored], own, x_scale="jac")
    gamma_p, beta_p, gamma_r, beta_r = (float(v) for v in fit.x)
    # the pull line of the widest play must rise, too
    least = 1.0 - float(widths.mean() / widths.max())
    return Theta(gamma_p, beta_p, gamma_r, beta_r) if least < gamma_p <= gamma_r else start


def _rounding(lines: Theta, t_in: Array, t_out: Array) -> tuple[float, ...] | None:
    """Return the widths of the plays that a loop adds up to, None where one play explains it as well."""

    def misfit(shares: Array) -> float:
        model = play_sum(t_in, shares, lines.gamma_p, lines.beta_p, lines.gamma_r, lines.beta_r)
        return float(np.sqrt(np.mean((model - t_out) ** 2)))

    sharp = misfit(np.ones(1))
    if sharp <= LEAST_MISFIT_N:
        return None
    widths = fit_widths(lines, t_in, t_out)
    return widths if misfit(np.array(widths)) < sharp else None


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
    scored = _scored(reference)
    return score(reference.tension_n[scored], done.tension_out[scored]).rmse_n


def _scored(reference: Reference) -> slice:
    """Return where a reference is scored: behind its first cycle."""
    return list(windows(reference.time_s, reference.cycle_s).values())[-1]
