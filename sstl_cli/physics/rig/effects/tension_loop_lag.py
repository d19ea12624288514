"""A sluggish tension loop: lag of first order and a limit on the slew."""

from math import exp

from numba import njit

from sstl_cli.physics.given import Bounds
from sstl_cli.physics.rig.effect import Effect, FloatArray, Parts, Values


@njit(cache=True)
def shape_command(time: FloatArray, command: FloatArray, tau: float, inverse_slew: float) -> FloatArray:
    """Command after the lag and the slew limit of a sluggish tension loop; the command itself at neutral values."""
    shaped = command.copy()
    if tau == 0.0 and inverse_slew == 0.0:
        return shaped
    for n in range(1, command.size):
        dt = time[n] - time[n - 1]
        share = 1.0 if tau == 0.0 else 1.0 - exp(-dt / tau)
        step = share * (command[n] - shaped[n - 1])
        if inverse_slew > 0.0:
            reach = dt / inverse_slew
            step = min(max(step, -reach), reach)
        shaped[n] = shaped[n - 1] + step
    return shaped


def _build(rig: Parts, v: Values) -> None:
    if rig.run.drive != "position":
        rig.command = shape_command(rig.run.time_s, rig.command, v["tau_s"], v["inverse_slew_s_per_n"])


EFFECT = Effect({"tau_s": Bounds(0.0, 0.0, 0.5), "inverse_slew_s_per_n": Bounds(0.0, 0.0, 0.2)}, build=_build)
