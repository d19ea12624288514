"""Sensors whose zero creeps: successive loops shift."""

from sstl_cli.physics.effect import INSTRUMENT, Array, Effect, Parameter, Sampling, Values


def _output(tension: Array, _other: Array, run: Sampling, v: Values) -> Array:
    return tension + v[f"r_out_{run.system}_n"] * run.fraction


def _input(tension: Array, _other: Array, run: Sampling, v: Values) -> Array:
    return tension + v[f"r_in_{run.system}_n"] * run.fraction


def _input_inverse(tension: Array, _other: Array, run: Sampling, v: Values) -> Array:
    return tension - v[f"r_in_{run.system}_n"] * run.fraction


EFFECT = Effect(
    id="zero_drift",
    title="Drift of a sensor's zero",
    stage=INSTRUMENT,
    equation="z(t) = r t / duration",
    source="Catalogue entry [L]",
    parameters=(
        Parameter("r_in_act_n", "N", 0.0, -1.0, 1.0, "drift of the actuation input zero over a run", system="act"),
        Parameter("r_out_act_n", "N", 0.0, -1.0, 1.0, "drift of the actuation output zero over a run", system="act"),
        Parameter("r_in_sstl_n", "N", 0.0, -1.0, 1.0, "drift of the SSTL input zero over a run", system="sstl"),
        Parameter("r_out_sstl_n", "N", 0.0, -1.0, 1.0, "drift of the SSTL output zero over a run", system="sstl"),
    ),
    excitation="Several equal cycles in one run; slack pauses settle it.",
    order=61,
    look_alikes=("friction_drift",),
    output=_output,
    input=_input,
    input_inverse=_input_inverse,
)
