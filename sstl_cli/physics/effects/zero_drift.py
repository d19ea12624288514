"""Sensors whose zero creeps: successive loops shift."""

import numpy as np

from sstl_cli.physics.effect import INSTRUMENT, Array, Effect, Parameter, Sampling, Values


def _passed(run: Sampling, v: Values) -> Array:
    """Return the part of the drift that has passed, from 0 to 1 over the run, shape (count,)."""
    warming = v["warming"]
    if warming == 0.0:
        return run.fraction
    return np.asarray(np.expm1(-warming * run.fraction) / np.expm1(-warming))


def _output(tension: Array, _other: Array, run: Sampling, v: Values) -> Array:
    return tension + v[f"r_out_{run.system}_n"] * _passed(run, v)


def _input(tension: Array, _other: Array, run: Sampling, v: Values) -> Array:
    return tension + v[f"r_in_{run.system}_n"] * _passed(run, v)


def _input_inverse(tension: Array, _other: Array, run: Sampling, v: Values) -> Array:
    return tension - v[f"r_in_{run.system}_n"] * _passed(run, v)


EFFECT = Effect(
    id="zero_drift",
    title="Zero of a sensor that drifts, or differs from run to run",
    stage=INSTRUMENT,
    equation="z(t) = r t / duration, or r (1 - exp(-w t / duration)) / (1 - exp(-w)) as a bridge warms up",
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
    ),
    excitation="Several equal cycles in one run; slack pauses settle it.",
    order=61,
    look_alikes=("friction_drift",),
    output=_output,
    input=_input,
    input_inverse=_input_inverse,
)
