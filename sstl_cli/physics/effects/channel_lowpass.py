"""An output channel behind a slow filter."""

from sstl_cli.physics.effect import INSTRUMENT, Array, Effect, Parameter, Sampling, Values
from sstl_cli.physics.filters import second_low_pass


def _output(tension: Array, _other: Array, run: Sampling, v: Values) -> Array:
    return second_low_pass(tension, run.dt_s, v[f"tau_{run.system}_s"], v["second"])


def _late_s(system: str, v: Values) -> float:
    return v[f"tau_{system}_s"]


EFFECT = Effect(
    id="channel_lowpass",
    title="Low-pass of first or second order on the output channel",
    stage=INSTRUMENT,
    equation="second tau^2 T_meas'' + tau T_meas' = T - T_meas; first order: tau = 1 / (2 pi f_c)",
    source="Catalogue entry [T]; Butterworth, Wireless Engineer 7 (1930)",
    parameters=(
        Parameter("tau_act_s", "s", 0.0, 0.0, 0.32, "time constant, actuation", system="act"),
        Parameter("tau_sstl_s", "s", 0.0, 0.0, 0.32, "time constant, SSTL", system="sstl"),
        Parameter(
            "second",
            "1",
            0.0,
            0.0,
            0.5,
            "1 / (2 zeta)^2: 0 first order, 1/4 two in a row, 1/2 Butterworth",
            shape=True,
            start=0.1,
            limits=(0.0, 0.5),
        ),
    ),
    excitation="Chirp or fast ramps with sharp corners.",
    order=70,
    look_alikes=("channel_delay", "viscous", "presliding"),
    output=_output,
    late_s=_late_s,
)
