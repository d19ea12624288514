"""Sensors whose characteristic is curved or has play."""

import numpy as np

from sstl_cli.physics.effect import INSTRUMENT, SENSORS, Array, Effect, Parameter, Sampling, Values, sensor_name
from sstl_cli.physics.filters import play

FULL_SCALE_N = 50.0


def _curve(side: str, run: Sampling, v: Values) -> tuple[float, float]:
    """Return curvature and slope at nothing of a sensor: T -> T + slope T - curvature T^2 / 50 N."""
    one = v[f"a_{side}_{run.system}"]
    a = v[f"a_{side}"] + one
    return a, v[f"a_{side}"] + v["chord"] * one


def _curved(tension: Array, curve: tuple[float, float]) -> Array:
    a, slope = curve
    return tension + tension * (slope - a * tension / FULL_SCALE_N)


def _output(tension: Array, _other: Array, run: Sampling, v: Values) -> Array:
    # what it reads at first it holds: where in its play it began is not for a model to choose
    return play(_curved(tension, _curve("out", run, v)), v["h_n"], run.begin_n)


def _input(tension: Array, _other: Array, run: Sampling, v: Values) -> Array:
    return _curved(tension, _curve("in", run, v))


def _input_inverse(tension: Array, _other: Array, run: Sampling, v: Values) -> Array:
    a, slope = _curve("in", run, v)
    root = np.sqrt(np.maximum((1.0 + slope) ** 2 - 4.0 * a * tension / FULL_SCALE_N, 0.0))
    return np.asarray(2.0 * tension / (1.0 + slope + root))


def _one(side: str, system: str) -> Parameter:
    meaning = f"curvature of the {sensor_name(side, system)} sensor alone"
    return Parameter(f"a_{side}_{system}", "1", 0.0, -0.02, 0.02, meaning, system=system, limits=(-0.9, 0.9))


EFFECT = Effect(
    id="sensor_nonlinearity",
    title="Curved or sticky sensor characteristic",
    stage=INSTRUMENT,
    equation="T_meas = T + a T (1 - T / 50 N), play +-h; of one sensor alone T + a T (s - T / 50 N)",
    source="Catalogue entry [T]; calibration polynomials, ISO 376",
    parameters=(
        Parameter("a_in", "1", 0.0, -0.02, 0.02, "curvature of the input sensors", limits=(-0.9, 0.9)),
        Parameter("a_out", "1", 0.0, -0.02, 0.02, "curvature of the output sensors", limits=(-0.9, 0.9)),
        Parameter("h_n", "N", 0.0, 0.0, 0.1, "half-width of the play of the output sensor"),
        *(_one(side, system) for side, system in SENSORS),
        Parameter(
            "chord",
            "1",
            0.6,
            0.0,
            1.2,
            "where the curve of one sensor is back on the line, over 50 N",
            shape=True,
            start=0.6,
            limits=(0.0, 1.2),
        ),
    ),
    plays=("h_n",),
    laws=(
        *((f"a_{side}_{system}", "chord") for side, system in SENSORS),
        *((f"a_{side}_act", f"a_{side}_sstl", "chord") for side in ("in", "out")),
    ),
    excitation="A wide span of tension; dead weights settle it.",
    order=52,
    look_alikes=("gain_error", "zero_offset", "load_dependent_friction"),
    output=_output,
    input=_input,
    input_inverse=_input_inverse,
)
