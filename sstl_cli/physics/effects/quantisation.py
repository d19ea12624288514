"""Recorders that round: a discrete level histogram."""

import numpy as np

from sstl_cli.physics.effect import INSTRUMENT, Array, Effect, Parameter, Sampling, Values


def _rounded(tension: Array, step: float) -> Array:
    return np.round(tension / step) * step if step > 0.0 else tension


def _output(tension: Array, _other: Array, _run: Sampling, v: Values) -> Array:
    return _rounded(tension, v["q_out_n"])


def _input(tension: Array, _other: Array, _run: Sampling, v: Values) -> Array:
    return _rounded(tension, v["q_in_n"])


EFFECT = Effect(
    id="quantisation",
    title="Quantisation",
    stage=INSTRUMENT,
    equation="T_meas = q round(T / q)",
    source="Catalogue entry [T]",
    parameters=(
        Parameter("q_in_n", "N", 0.0, 0.0, 0.5, "step of the input channel"),
        Parameter("q_out_n", "N", 0.0, 0.0, 0.5, "step of the output channel"),
    ),
    excitation="Any record at its own resolution.",
    order=90,
    fitted=False,
    output=_output,
    input=_input,
)
