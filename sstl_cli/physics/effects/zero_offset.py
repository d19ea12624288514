"""Sensors whose zero is off: both propagation lines shift, at every rate."""

from sstl_cli.physics.effect import INSTRUMENT, NOMINAL_THETA, SENSORS, Array, Effect, Parameter, Sampling, Values, sensor_name


def _zero(side: str, run: Sampling, v: Values) -> float:
    """Return the zero of a sensor (N); a preload grows with the bend, from nothing or from what a straight tube has."""
    bent = v[f"preload_{side}_{run.system}_n"] * run.theta / NOMINAL_THETA
    return v[f"z_{side}_{run.system}_n"] + v[f"straight_{side}_{run.system}_n"] + bent


def _output(tension: Array, _other: Array, run: Sampling, v: Values) -> Array:
    return tension + _zero("out", run, v)


def _input(tension: Array, _other: Array, run: Sampling, v: Values) -> Array:
    return tension + _zero("in", run, v)


def _input_inverse(tension: Array, _other: Array, run: Sampling, v: Values) -> Array:
    return tension - _zero("in", run, v)


def _preload(side: str, system: str) -> Parameter:
    meaning = f"preload of the {sensor_name(side, system)} at theta = {NOMINAL_THETA}, in proportion to theta"
    return Parameter(f"preload_{side}_{system}_n", "N", 0.0, -2.0, 2.0, meaning, system=system)


def _straight(side: str, system: str) -> Parameter:
    return Parameter(
        f"straight_{side}_{system}_n", "N", 0.0, -2.0, 2.0, f"preload of the {sensor_name(side, system)} in a straight tube", system=system
    )


EFFECT = Effect(
    id="zero_offset",
    title="Zero offset of a tension sensor",
    stage=INSTRUMENT,
    equation="T_meas = T + z; or, as a preload that grows with the bend, T + z_0 + z theta / 0.53",
    source="Section III-C3 (bias terms); catalogue entry [P]",
    parameters=(
        Parameter("z_in_act_n", "N", 0.0, -2.0, 2.0, "zero of the actuation input sensor", system="act"),
        Parameter("z_out_act_n", "N", 0.0, -2.0, 2.0, "zero of the actuation output sensor", system="act"),
        Parameter("z_in_sstl_n", "N", 0.0, -2.0, 2.0, "zero of the SSTL input sensor", system="sstl"),
        Parameter("z_out_sstl_n", "N", 0.0, -2.0, 2.0, "zero of the SSTL output sensor", system="sstl"),
        *(_preload(side, system) for side, system in SENSORS),
        *(_straight(side, system) for side, system in SENSORS),
    ),
    laws=(
        *((f"preload_{side}_{system}_n",) for side, system in SENSORS),
        *((f"straight_{side}_{system}_n", f"preload_{side}_{system}_n") for side, system in SENSORS),
        *((f"preload_{side}_act_n", f"preload_{side}_sstl_n") for side in ("in", "out")),
    ),
    excitation="Several configurations; a slack reading settles it.",
    order=60,
    look_alikes=("const_friction", "sensor_nonlinearity"),
    output=_output,
    input=_input,
    input_inverse=_input_inverse,
)
