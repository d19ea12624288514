"""A sluggish tension loop: lag of first order, its rate cut at a limit."""

from math import exp

from numba import njit

from sstl_cli.physics.bristle.effect import Effect, FloatArray, Parts, Values
from sstl_cli.physics.given import Bounds


@njit(cache=True)
def late_command(time: FloatArray, command: FloatArray, tau: float, inverse_slew: float) -> FloatArray:
    """What a sluggish tension loop makes of its command (N): a first-order lag, its rate cut at the slew limit."""
    reached = command.copy()
    for n in range(1, command.size):
        dt = time[n] - time[n - 1]
        keep = exp(-dt / tau) if tau > 0.0 else 0.0
        change = (1.0 - keep) * (command[n] - reached[n - 1])
        if inverse_slew > 0.0:
            change = max(-dt / inverse_slew, min(dt / inverse_slew, change))
        reached[n] = reached[n - 1] + change
    return reached


def _build(made: Parts, v: Values) -> None:
    if made.run.drive != "position" and (v["tau_s"] > 0.0 or v["inverse_slew_s_per_n"] > 0.0):
        made.command = late_command(made.run.time_s, made.command, v["tau_s"], v["inverse_slew_s_per_n"])


EFFECT = Effect({"tau_s": Bounds(0.0, 0.0, 0.5), "inverse_slew_s_per_n": Bounds(0.0, 0.0, 0.2)}, build=_build)
