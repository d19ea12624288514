"""Sensors whose characteristic is curved or has play."""

import numpy as np

from sstl_cli.physics.effect import INSTRUMENT, Array, Effect, Parameter, Sampling, Values
from sstl_cli.physics.filters import play

FULL_SCALE_N = 50.0


def _curved(tension: Array, a: float) -> Array:
    return tension + a * tension * (1.0 - tension / FULL_SCALE_N)


def _output(tension: Array, _other: Array, run: Sampling, v: Values) -> Array:
    # what it reads at first it holds: where in its play it began is not for a model to choose
    return play(_curved(tension, v["a_out"]), v["h_n"], run.begin_n)


def _input(tension: Array, _other: Array, _run: Sampling, v: Values) -> Array:
    return _curved(tension, v["a_in"])


def _input_inverse(tension: Array, _other: Array, _run: Sampling, v: Values) -> Array:
    a = v["a_in"]
    root = np.sqrt(np.maximum((1.0 + a) ** 2 - 4.0 * a * tension / FULL_SCALE_N, 0.0))
    return np.asarray(2.0 * tension / (1.0 + a + root))


EFFECT = Effect(
    id="sensor_nonlinearity",
    title="Curved or sticky sensor characteristic",
    stage=INSTRUMENT,
    equation="T_meas = T + a T (1 - T / 50 N), play +-h",
    source="Catalogue entry [T]",
    parameters=(
        Parameter("a_in", "1", 0.0, -0.02, 0.02, "curvature of the input sensor", limits=(-0.9, 0.9)),
        Parameter("a_out", "1", 0.0, -0.02, 0.02, "curvature of the output sensor", limits=(-0.9, 0.9)),
        Parameter("h_n", "N", 0.0, 0.0, 0.1, "half-width of the play of the output sensor"),
    ),
    excitation="A wide span of tension; dead weights settle it.",
    order=52,
    look_alikes=("gain_error", "zero_offset", "load_dependent_friction"),
    output=_output,
    input=_input,
    input_inverse=_input_inverse,
)
