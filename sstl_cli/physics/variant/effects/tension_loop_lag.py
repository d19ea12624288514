"""A sluggish tension loop: a servo of second order, or one of first order behind a transport delay."""

import numpy as np

from sstl_cli.physics.variant.effect import Effect, Parts, Values, wide
from sstl_cli.physics.variant.filters import first_order, second_order
from sstl_cli.physics.variant.laws import Chosen, Law

LAWS = (
    Law("second_order", "T'' = w^2 (T_cmd - T) - 2 z w T', 2 z/w = tau", "textbook servo loop", 0.5, 0.9),
    Law("transport", "T_cmd late by tau/2, then tau/2 of first order; slew tanh", "textbook drive with transport delay"),
)


def _build(made: Parts, v: Values, law: Chosen) -> None:
    time, tau, inverse_slew = made.run.time_s, v["tau_s"], v["inverse_slew_s_per_n"]
    if tau == 0.0 and inverse_slew == 0.0:
        return
    if law.id == "second_order":
        made.command = second_order(time, made.command, tau, law.shape, inverse_slew)
        return
    late = np.interp(time - 0.5 * tau, time, made.command) if tau > 0.0 else made.command
    made.command = first_order(time, late, 0.5 * tau, inverse_slew)


EFFECT = Effect({"tau_s": wide(0.0, 0.0, 0.5), "inverse_slew_s_per_n": wide(0.0, 0.0, 0.2)}, LAWS, build=_build)
