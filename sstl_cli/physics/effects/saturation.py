"""Sensors that clip: a flat top whatever the direction."""

import numpy as np

from sstl_cli.physics.effect import INSTRUMENT, Array, Effect, Parameter, Sampling, Values

LEAST_LOST = 0.8


def _output(tension: Array, _other: Array, run: Sampling, v: Values) -> Array:
    compressed = tension
    if v["soft_out"] != 0.0:
        width, knee = v["width_n"], v["knee_n"]
        if run.system == "sstl" and v["knee_sstl_n"] > 0.0:
            knee = v["knee_sstl_n"]
        compressed = tension - v["soft_out"] * width * np.logaddexp(0.0, (tension - knee) / width)
    return np.minimum(compressed, v["t_max_out_n"])


def _input(tension: Array, _other: Array, _run: Sampling, v: Values) -> Array:
    return np.minimum(tension, v["t_max_in_n"])


EFFECT = Effect(
    id="saturation",
    title="Saturation",
    stage=INSTRUMENT,
    equation="T_meas = min(T, T_max); or T - s w ln(1 + exp((T - T_knee) / w))",
    source="Catalogue entry [T]; compression of an amplifier",
    parameters=(
        Parameter("t_max_in_n", "N", 1000.0, 1.0, 1000.0, "full scale of the input channel"),
        Parameter("t_max_out_n", "N", 1000.0, 1.0, 1000.0, "full scale of the output channel"),
        # what keeps more of its slope than a fifth beyond a knee is a curved sensor
        Parameter(
            "soft_out",
            "1",
            0.0,
            0.0,
            1.0,
            "part of the tension beyond a knee that the output channels lack: nothing, or 0.8 to 1",
            limits=(LEAST_LOST, 1.0),
        ),
        Parameter("knee_n", "N", 10.0, 2.0, 15.0, "where that begins", shape=True),
        Parameter("width_n", "N", 0.3, 0.05, 2.0, "within what tension it begins", shape=True),
        Parameter(
            "knee_sstl_n", "N", 0.0, 0.0, 15.0, "where that begins in the SSTL output, 0: as in the other", system="sstl", shape=True
        ),
    ),
    knees=("knee_n", "knee_sstl_n"),
    laws=(("soft_out", "knee_n", "width_n"), ("soft_out", "knee_n", "width_n", "knee_sstl_n")),
    excitation="Tensions up to the full scale.",
    order=85,
    fitted=False,
    output=_output,
    input=_input,
)
