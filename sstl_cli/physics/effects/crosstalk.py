"""Sensors that feel one another's tension: the backlash holds acquire a slope."""

from sstl_cli.physics.effect import INSTRUMENT, SENSORS, Array, Effect, Parameter, Sampling, Values, sensor_name


def _output(tension: Array, other: Array, run: Sampling, v: Values) -> Array:
    return tension + (v["c_in_to_out"] + v[f"c_out_{run.system}"]) * other + v["m_out"] * (tension + other)


def _input(tension: Array, other: Array, run: Sampling, v: Values) -> Array:
    return tension + (v["c_out_to_in"] + v[f"c_in_{run.system}"]) * other + v["m_in"] * (tension + other)


def _input_inverse(tension: Array, other: Array, run: Sampling, v: Values) -> Array:
    return (tension - (v["c_out_to_in"] + v[f"c_in_{run.system}"] + v["m_in"]) * other) / (1.0 + v["m_in"])


def _one(side: str, system: str) -> Parameter:
    meaning = f"the other tension seen by the {sensor_name(side, system)} sensor alone"
    return Parameter(f"c_{side}_{system}", "1", 0.0, 0.0, 0.05, meaning, system=system)


EFFECT = Effect(
    id="crosstalk",
    title="Crosstalk between the tension sensors",
    stage=INSTRUMENT,
    equation="T_i,meas = T_i + c T_j, of all sensors or of one alone; through a common mount T_i + m (T_i + T_j)",
    source="Catalogue entry [L]; a mount that gives way to the sum of both tensions bends both sensors",
    parameters=(
        Parameter("c_in_to_out", "1", 0.0, 0.0, 0.05, "input tension seen by the output sensor"),
        Parameter("c_out_to_in", "1", 0.0, 0.0, 0.05, "output tension seen by the input sensor"),
        Parameter("m_out", "1", 0.0, 0.0, 0.05, "both tensions seen by the output sensor through its mount"),
        Parameter("m_in", "1", 0.0, 0.0, 0.05, "both tensions seen by the input sensor through its mount"),
        *(_one(side, system) for side, system in SENSORS),
    ),
    excitation="Long backlash holds; pulling one tendon only settles it.",
    order=54,
    look_alikes=("gain_error",),
    laws=tuple((f"c_{side}_{system}",) for side, system in SENSORS),
    variants=(("c_in_to_out",), ("c_out_to_in",), ("c_in_to_out", "c_out_to_in"), ("m_out",), ("m_in",), ("m_out", "m_in")),
    output=_output,
    input=_input,
    input_inverse=_input_inverse,
)
