"""Sensors whose characteristic is curved or has play."""

import numpy as np

from sstl_cli.physics.effect import INSTRUMENT, SENSORS, SYSTEMS, Array, Effect, Parameter, Sampling, Values, sensor_name
from sstl_cli.physics.filters import play

FULL_SCALE_N = 50.0
# plays whose mean is a loop that is round at its turning points, over their middle one
WIDTHS = (0.3, 1.0, 3.0)


def _curve(side: str, run: Sampling, v: Values) -> tuple[float, float]:
    """Return curvature and slope at nothing of a sensor: T -> T + slope T - curvature T^2 / 50 N."""
    one = v[f"a_{side}_{run.system}"]
    a = v[f"a_{side}"] + one
    return a, v[f"a_{side}"] + v["chord"] * one


def _curved(tension: Array, curve: tuple[float, float]) -> Array:
    a, slope = curve
    return tension + tension * (slope - a * tension / FULL_SCALE_N)


def _beyond(tension: Array, b: float, v: Values) -> Array:
    """Return what a sensor reads more beyond its knee (N)."""
    return b * np.maximum(tension - v["knee_n"], 0.0)


def _output(tension: Array, _other: Array, run: Sampling, v: Values) -> Array:
    # what it reads at first it holds: where in its play it began is not for a model to choose
    curved = run.zero_n + _curved(tension - run.zero_n, _curve("out", run, v))
    if v["b_out"] != 0.0:
        curved = curved + _beyond(tension, v["b_out"], v)
    read = play(curved, v["h_n"] + v[f"h_{run.system}_n"], run.begin_n)
    part = v[f"k_{run.system}"]
    if part == 0.0:
        return read
    behind = np.mean([play(read, v["width_n"] * ratio) for ratio in WIDTHS], axis=0)
    return np.asarray(read + part * (behind - read))


def _input(tension: Array, _other: Array, run: Sampling, v: Values) -> Array:
    curved = _curved(tension, _curve("in", run, v))
    return curved + _beyond(tension, v["b_in"], v) if v["b_in"] != 0.0 else curved


def _input_inverse(tension: Array, _other: Array, run: Sampling, v: Values) -> Array:
    if v["b_in"] != 0.0:
        # a law of its own: nothing else is curved
        return tension - _beyond(tension, v["b_in"] / (1.0 + v["b_in"]), v)
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
    equation="T_meas = T + a T (1 - T / 50 N), play +-h; of one sensor alone T + a T (s - T / 50 N); (1 - k) T + k times the mean of plays of T; T + b max(T - knee, 0)",
    source="Catalogue entry [T]; calibration polynomials, ISO 376; hysteresis of elastic bodies, Prandtl (1928); a spring that comes to rest on a stop",
    parameters=(
        Parameter("a_in", "1", 0.0, -0.02, 0.02, "curvature of the input sensors", limits=(-0.9, 0.9)),
        Parameter("a_out", "1", 0.0, -0.02, 0.02, "curvature of the output sensors", limits=(-0.9, 0.9)),
        Parameter("h_n", "N", 0.0, 0.0, 0.1, "half-width of the play of the output sensor"),
        *(_one(side, system) for side, system in SENSORS),
        *(
            Parameter(f"h_{s}_n", "N", 0.0, 0.0, 0.1, f"half-width of the play of the {sensor_name('out', s)} sensor alone", system=s)
            for s in SYSTEMS
        ),
        *(
            Parameter(
                f"k_{s}", "1", 0.0, 0.0, 0.1, f"part of the {sensor_name('out', s)} that comes behind plays", system=s, limits=(0.0, 1.0)
            )
            for s in SYSTEMS
        ),
        Parameter("b_out", "1", 0.0, -0.1, 0.1, "part of the tension beyond a knee that the output sensors read more", limits=(-0.9, 0.9)),
        Parameter("b_in", "1", 0.0, -0.1, 0.1, "part of the tension beyond a knee that the input sensors read more", limits=(-0.5, 0.5)),
        Parameter("knee_n", "N", 10.0, 2.0, 15.0, "where that begins", shape=True),
        Parameter("width_n", "N", 1.0, 0.1, 5.0, "half-width of the middle one of those plays", shape=True),
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
    plays=("h_n", "h_act_n", "h_sstl_n"),
    knees=("knee_n",),
    laws=(
        *((f"a_{side}_{system}", "chord") for side, system in SENSORS),
        *((f"a_{side}_act", f"a_{side}_sstl", "chord") for side in ("in", "out")),
        *((f"h_{s}_n",) for s in SYSTEMS),
        *((f"k_{s}", "width_n") for s in SYSTEMS),
        ("k_act", "k_sstl", "width_n"),
        ("b_out", "knee_n"),
        ("b_in", "knee_n"),
    ),
    excitation="A wide span of tension; dead weights settle it.",
    order=52,
    look_alikes=("gain_error", "zero_offset", "load_dependent_friction"),
    output=_output,
    input=_input,
    input_inverse=_input_inverse,
)
