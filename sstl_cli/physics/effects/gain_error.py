"""Sensors whose sensitivity differs: both slopes scale by the same ratio in every configuration."""

from sstl_cli.physics.effect import INSTRUMENT, Array, Effect, Parameter, Sampling, Values


def _output(tension: Array, _other: Array, run: Sampling, v: Values) -> Array:
    # a sensor that is too sensitive reads nothing where it did
    return run.zero_n + (tension - run.zero_n) * v[f"g_{run.system}"]


EFFECT = Effect(
    id="gain_error",
    title="Gain of the output sensor against the input sensor",
    stage=INSTRUMENT,
    equation="T_meas = g T; only the ratio of the two gains shows; in another unit about where that reads nothing",
    source="Catalogue entry [L]; slope products of Table II [C]",
    parameters=(
        Parameter("g_act", "1", 1.0, 0.85, 1.15, "output over input gain, actuation", system="act"),
        Parameter("g_sstl", "1", 1.0, 0.85, 1.15, "output over input gain, SSTL", system="sstl"),
    ),
    excitation="Several configurations; dead weights settle it.",
    order=55,
    look_alikes=("asymmetric_friction", "sensor_nonlinearity", "crosstalk", "pulley_friction"),
    output=_output,
)
