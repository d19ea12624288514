"""An output channel behind a slow filter."""

from sstl_cli.physics.effect import INSTRUMENT, Array, Effect, Parameter, Sampling, Values
from sstl_cli.physics.filters import low_pass


def _output(tension: Array, _other: Array, run: Sampling, v: Values) -> Array:
    return low_pass(tension, run.dt_s, v[f"tau_{run.system}_s"])


def _late_s(system: str, v: Values) -> float:
    return v[f"tau_{system}_s"]


EFFECT = Effect(
    id="channel_lowpass",
    title="First-order low-pass on the output channel",
    stage=INSTRUMENT,
    equation="tau dT_meas/dt = T - T_meas, tau = 1 / (2 pi f_c)",
    source="Catalogue entry [T]",
    parameters=(
        Parameter("tau_act_s", "s", 0.0, 0.0, 0.32, "time constant, actuation", system="act"),
        Parameter("tau_sstl_s", "s", 0.0, 0.0, 0.32, "time constant, SSTL", system="sstl"),
    ),
    excitation="Chirp or fast ramps with sharp corners.",
    order=70,
    look_alikes=("channel_delay", "viscous", "presliding"),
    output=_output,
    late_s=_late_s,
)
