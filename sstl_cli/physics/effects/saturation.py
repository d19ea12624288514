"""Sensors that clip: a flat top whatever the direction."""

import numpy as np

from sstl_cli.physics.effect import INSTRUMENT, Array, Effect, Parameter, Sampling, Values


def _output(tension: Array, _other: Array, _run: Sampling, v: Values) -> Array:
    return np.minimum(tension, v["t_max_out_n"])


def _input(tension: Array, _other: Array, _run: Sampling, v: Values) -> Array:
    return np.minimum(tension, v["t_max_in_n"])


EFFECT = Effect(
    id="saturation",
    title="Saturation",
    stage=INSTRUMENT,
    equation="T_meas = min(T, T_max)",
    source="Catalogue entry [T]",
    parameters=(
        Parameter("t_max_in_n", "N", 1000.0, 1.0, 1000.0, "full scale of the input channel"),
        Parameter("t_max_out_n", "N", 1000.0, 1.0, 1000.0, "full scale of the output channel"),
    ),
    excitation="Tensions up to the full scale.",
    order=85,
    fitted=False,
    output=_output,
    input=_input,
)
