"""Sensors whose zero creeps: successive loops shift."""

import numpy as np

from sstl_cli.physics.effect import INSTRUMENT, SENSORS, Array, Effect, Parameter, Sampling, Values, sensor_name


def _drift(side: str, run: Sampling, v: Values) -> Array:
    """Return how far a zero has drifted (N), shape (count,)."""
    warming, session = v["warming"], v[f"s_{side}_{run.system}_n"]
    passed = run.fraction if warming == 0.0 else np.expm1(-warming * run.fraction) / np.expm1(-warming)
    drift = np.asarray(v[f"r_{side}_{run.system}_n"] * passed)
    if session == 0.0:
        return drift
    return np.asarray(drift - session * np.expm1(-(run.begun_s + run.dt_s * np.arange(run.count)) / v["session_s"]))


def _output(tension: Array, _other: Array, run: Sampling, v: Values) -> Array:
    return tension + _drift("out", run, v)


def _input(tension: Array, _other: Array, run: Sampling, v: Values) -> Array:
    return tension + _drift("in", run, v)


def _input_inverse(tension: Array, _other: Array, run: Sampling, v: Values) -> Array:
    return tension - _drift("in", run, v)


def _over_a_session(side: str, system: str) -> Parameter:
    meaning = f"drift of the {sensor_name(side, system)} zero over a session"
    return Parameter(f"s_{side}_{system}_n", "N", 0.0, -1.0, 1.0, meaning, system=system)


EFFECT = Effect(
    id="zero_drift",
    title="Zero of a sensor that drifts, or differs from run to run",
    stage=INSTRUMENT,
    equation="z(t) = r t / duration, or r (1 - exp(-w t / duration)) / (1 - exp(-w)) as a bridge warms up; over a session s (1 - exp(-t / tau))",
    source="Catalogue entry [L]",
    parameters=(
        Parameter("r_in_act_n", "N", 0.0, -1.0, 1.0, "drift of the actuation input zero over a run", system="act"),
        Parameter("r_out_act_n", "N", 0.0, -1.0, 1.0, "drift of the actuation output zero over a run", system="act"),
        Parameter("r_in_sstl_n", "N", 0.0, -1.0, 1.0, "drift of the SSTL input zero over a run", system="sstl"),
        Parameter("r_out_sstl_n", "N", 0.0, -1.0, 1.0, "drift of the SSTL output zero over a run", system="sstl"),
        Parameter(
            "warming",
            "1",
            0.0,
            0.0,
            3.0,
            "duration over the time constant of a warm-up, 0: steadily",
            shape=True,
            start=0.0,
            limits=(0.0, 3.0),
        ),
        *(_over_a_session(side, system) for side, system in SENSORS),
        Parameter("session_s", "s", 120.0, 20.0, 5000.0, "time constant of the drift over a session", shape=True),
    ),
    laws=(
        *((f"s_{side}_{system}_n", "session_s") for side, system in SENSORS),
        # the same sensor reads both systems
        *((f"s_{side}_act_n", f"s_{side}_sstl_n", "session_s") for side in ("in", "out")),
    ),
    excitation="Several equal cycles in one run; slack pauses settle it.",
    order=61,
    look_alikes=("friction_drift",),
    output=_output,
    input=_input,
    input_inverse=_input_inverse,
)
