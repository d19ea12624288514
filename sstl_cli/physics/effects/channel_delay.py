"""An output channel that is recorded late."""

from sstl_cli.physics.effect import INSTRUMENT, Array, Effect, Parameter, Sampling, Values
from sstl_cli.physics.filters import delayed


def _output(tension: Array, _other: Array, run: Sampling, v: Values) -> Array:
    return delayed(tension, v[f"tau_{run.system}_s"] / run.dt_s)


def _late_s(system: str, v: Values) -> float:
    return v[f"tau_{system}_s"]


EFFECT = Effect(
    id="channel_delay",
    title="Delay of the output channel",
    stage=INSTRUMENT,
    equation="T_meas(t) = T(t - tau)",
    source="Catalogue entry [T]",
    parameters=(
        Parameter("tau_act_s", "s", 0.0, 0.0, 0.2, "delay, actuation", system="act"),
        Parameter("tau_sstl_s", "s", 0.0, 0.0, 0.2, "delay, SSTL", system="sstl"),
    ),
    excitation="Fast ramps, chirp.",
    order=75,
    look_alikes=("channel_lowpass", "viscous"),
    output=_output,
    late_s=_late_s,
)
