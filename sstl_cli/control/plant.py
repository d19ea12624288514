"""What the controller acts on: a tension loop, and the tendon behind it.

The controller sees only the input tension, and the tension loop does not see the output. So the
loop is closed sample by sample in compiled code, and the tendon is any function from the whole
input tension to the output: the play operator here, a physical model, or hardware's record.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numba import njit
from numpy.typing import NDArray

from sstl_cli.control import law
from sstl_cli.control.controller import Controller, Theta, loop_gain
from sstl_cli.core.errors import SstlError

Array = NDArray[np.float64]
#: output tension (N) of a tendon for an input tension (N) sampled at a period (s)
Tendon = Callable[[Array, float], Array]
PRE_PULL = 500


@dataclass(frozen=True)
class TensionLoop:
    """The loop that makes the input tension follow its command: first-order lag, slew limit, dead time.

    Raises
    ------
    SstlError
        If the lag is no time.
    """

    tau_s: float = 0.0
    slew_n_s: float = float("inf")
    delay_s: float = 0.0
    noise_n: float = 0.0

    def __post_init__(self) -> None:
        if not self.tau_s >= 0.0:
            raise SstlError(f"a lag of {self.tau_s:g} s is no time", where="tension loop", fix="give 0 or more", code="E403")


@dataclass(frozen=True)
class PlayTendon:
    """A tendon that follows its propagation lines: out[k] = clip(out[k-1], pull(in), release(in))."""

    theta: Theta

    def __call__(self, tension_in: Array, dt_s: float) -> Array:
        t = self.theta
        return _play(np.ascontiguousarray(tension_in), t.gamma_p, t.beta_p, t.gamma_r, t.beta_r)


@dataclass(frozen=True)
class Plant:
    """A tension loop and the tendon behind it; the tendon is pre-pulled from rest before the first sample."""

    tendon: Tendon
    loop: TensionLoop = field(default_factory=TensionLoop)


@dataclass(frozen=True)
class Track:
    """What a controller and its plant did: tensions in N, phase codes, shape (n,) each."""

    command: Array
    tension_in: Array
    tension_out: Array
    phase: NDArray[np.int8]


def track(controller: Controller, plant: Plant, reference: Array, rng: np.random.Generator | None = None) -> Track:
    """Return what happens when the controller drives the plant along a reference (N, shape (n,)).

    Parameters
    ----------
    rng : numpy.random.Generator, optional
        Source of the noise of the input sensor; needed where the loop has noise.
    """
    controller.reset()
    reference = np.ascontiguousarray(reference, dtype=np.float64)
    dt, loop = controller.options.dt_s, plant.loop
    n = len(reference)
    noise = rng.standard_normal(n) * loop.noise_n if rng is not None and loop.noise_n > 0.0 else np.empty(0)
    command, tension_in, phase = np.empty(n), np.empty(n), np.empty(n, np.int8)
    start = controller.rest_tension(float(reference[0]))
    sampled = law.Loop(start, loop_gain(dt, loop.tau_s), loop.slew_n_s * dt, round(loop.delay_s / dt))
    law.close_loop(controller.vector, controller.state, reference, noise, sampled, command, tension_in, phase)
    return Track(command, tension_in, pulled(plant.tendon, tension_in, start, dt), phase)


def replay(controller: Controller, plant: Plant, reference: Array, recorded_in: Array) -> Track:
    """Return the commands for a recorded input tension, and the output the plant's tendon would give for them.

    The recorded tension drives the controller's phases; the output is that of the command behind
    an ideal tension loop, since the recorded tension answered another command.
    """
    controller.reset()
    command, phase = controller.replay(reference, recorded_in)
    return Track(command, recorded_in, pulled(plant.tendon, command, float(command[0]), controller.options.dt_s), phase)


def pulled(tendon: Tendon, tension_in: Array, start: float, dt_s: float) -> Array:
    """Return the output (N) after the tendon was pulled from rest to ``start`` before the first sample."""
    ramp = np.linspace(0.0, start, PRE_PULL)
    return tendon(np.concatenate((ramp, tension_in)), dt_s)[PRE_PULL:]


@njit(cache=True)
def _play(tension_in: Array, gp: float, bp: float, gr: float, br: float) -> Array:
    out = np.empty_like(tension_in)
    y = gp * tension_in[0] + bp if tension_in.size else 0.0
    for k in range(tension_in.size):
        y = max(gp * tension_in[k] + bp, min(y, gr * tension_in[k] + br))
        out[k] = y
    return out
