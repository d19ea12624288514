"""Sensors that feel one another's tension: the backlash holds acquire a slope."""

from sstl_cli.physics.effect import INSTRUMENT, Array, Effect, Parameter, Sampling, Values


def _output(tension: Array, other: Array, _run: Sampling, v: Values) -> Array:
    return tension + v["c_in_to_out"] * other


def _input(tension: Array, other: Array, _run: Sampling, v: Values) -> Array:
    return tension + v["c_out_to_in"] * other


def _input_inverse(tension: Array, other: Array, _run: Sampling, v: Values) -> Array:
    return tension - v["c_out_to_in"] * other


EFFECT = Effect(
    id="crosstalk",
    title="Crosstalk between the tension sensors",
    stage=INSTRUMENT,
    equation="T_i,meas = T_i + c T_j",
    source="Catalogue entry [L]",
    parameters=(
        Parameter("c_in_to_out", "1", 0.0, 0.0, 0.05, "input tension seen by the output sensor"),
        Parameter("c_out_to_in", "1", 0.0, 0.0, 0.05, "output tension seen by the input sensor"),
    ),
    excitation="Long backlash holds; pulling one tendon only settles it.",
    order=58,
    look_alikes=("gain_error",),
    output=_output,
    input=_input,
    input_inverse=_input_inverse,
)
