"""Sensors whose zero is off: both propagation lines shift, at every rate."""

from sstl_cli.physics.effect import INSTRUMENT, Array, Effect, Parameter, Sampling, Values


def _output(tension: Array, _other: Array, run: Sampling, v: Values) -> Array:
    return tension + v[f"z_out_{run.system}_n"]


def _input(tension: Array, _other: Array, run: Sampling, v: Values) -> Array:
    return tension + v[f"z_in_{run.system}_n"]


def _input_inverse(tension: Array, _other: Array, run: Sampling, v: Values) -> Array:
    return tension - v[f"z_in_{run.system}_n"]


EFFECT = Effect(
    id="zero_offset",
    title="Zero offset of a tension sensor",
    stage=INSTRUMENT,
    equation="T_meas = T + z",
    source="Section III-C3 (bias terms); catalogue entry [P]",
    parameters=(
        Parameter("z_in_act_n", "N", 0.0, -2.0, 2.0, "zero of the actuation input sensor", system="act"),
        Parameter("z_out_act_n", "N", 0.0, -2.0, 2.0, "zero of the actuation output sensor", system="act"),
        Parameter("z_in_sstl_n", "N", 0.0, -2.0, 2.0, "zero of the SSTL input sensor", system="sstl"),
        Parameter("z_out_sstl_n", "N", 0.0, -2.0, 2.0, "zero of the SSTL output sensor", system="sstl"),
    ),
    excitation="Several configurations; a slack reading settles it.",
    order=60,
    look_alikes=("const_friction", "sensor_nonlinearity"),
    output=_output,
    input=_input,
    input_inverse=_input_inverse,
)
