"""What a diagnosis is worth: tracking error of a controller designed without and with the named effect."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sstl_cli.control.controller import Controller, Options, Theta
from sstl_cli.control.plant import Plant, track
from sstl_cli.control.references import Reference, random, sinusoid
from sstl_cli.control.scoring import score, windows
from sstl_cli.control.sim_plant import plant_of
from sstl_cli.core.errors import SstlError
from sstl_cli.core.rng import stream
from sstl_cli.physics.scenario import Scenario

Array = NDArray[np.float64]
DT_S = 0.01
STROKE_N = (1.0, 35.0)


@dataclass(frozen=True)
class Tracking:
    """RMSE (N) of tracking a reference with a controller designed without and with the effect."""

    reference: str
    rmse_without_n: float
    rmse_with_n: float


def tracking(model: Scenario, config_id: str, theta_base: float) -> list[Tracking]:
    """Return tracking errors on the accepted model of one configuration.

    Without the effect the controller knows the lines exp(-+theta) of the re-tuned base; with it, the
    lines that the accepted model shows on a full stroke.
    """
    plant = plant_of(model, config_id)
    options = Options(dt_s=DT_S, reversal="play")
    without = Theta(float(np.exp(-theta_base)), 0.0, float(np.exp(theta_base)), 0.0)
    known = lines_of(plant)
    out = []
    for reference in (sinusoid(DT_S), random(stream(0, "downstream"), DT_S, 200.0)):
        errors = [_rmse(Controller(lines, options), plant, reference) for lines in (without, known)]
        out.append(Tracking(reference.name, *errors))
    return out


def lines_of(plant: Plant) -> Theta:
    """Return the propagation lines that a plant shows on a slow full stroke, by least squares."""
    low, high = STROKE_N
    t_in = np.interp(np.arange(0, 80.0, DT_S), [0, 20, 40, 60, 80], [low, high, low, high, low])
    t_out = plant.tendon(t_in, DT_S)
    moving = np.abs(np.gradient(t_out)) > 0.2 * np.abs(np.gradient(t_in))
    half = len(t_in) // 2
    late = np.arange(len(t_in)) >= half
    rising = np.gradient(t_in) > 0
    lines = []
    for side in (rising, ~rising):
        chosen = late & moving & side
        if chosen.sum() < 20:
            raise SstlError("the accepted model shows no propagation on a full stroke", code="E920")
        lines += [float(v) for v in np.polyfit(t_in[chosen], t_out[chosen], 1)]
    return Theta(*lines)


def _rmse(controller: Controller, plant: Plant, reference: Reference) -> float:
    done = track(controller, plant, reference.tension_n)
    window = list(windows(reference.time_s, reference.cycle_s).values())[-1]
    return score(reference.tension_n[window], done.tension_out[window]).rmse_n
