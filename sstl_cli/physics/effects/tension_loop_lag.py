"""A tension loop that follows its command late."""

from sstl_cli.physics.effect import TRANSITION, Array, Effect, Parameter, Values
from sstl_cli.physics.filters import first_order


def _loop(command: Array, dt_s: float, v: Values) -> Array:
    return first_order(command, dt_s, v["tau_s"], v["inverse_slew_s_per_n"])


EFFECT = Effect(
    id="tension_loop_lag",
    title="Lag of the tension loop",
    stage=TRANSITION,
    equation="tau dT_in/dt = T_cmd - T_in, |dT_in/dt| <= slew",
    source="Catalogue entry [P, L]; the reversals of Section VI",
    parameters=(
        Parameter("tau_s", "s", 0.0, 0.0, 0.5, "time constant of the loop"),
        Parameter("inverse_slew_s_per_n", "s/N", 0.0, 0.0, 0.2, "one over the slew limit"),
    ),
    excitation="The reference recorded beside the input tension, with fast changes.",
    channel="loop",
    needs=("tension_ref_n",),
    look_alikes=("channel_delay",),
    loop=_loop,
)
