"""Friction coefficient that changes with the tension: curved propagation lines."""

import numpy as np

from sstl_cli.physics.effect import FRICTION_LAW, Array, Effect, Law, Parameter, Values

REFERENCE_N = 10.0
FLOOR_N = 0.05
# within which part of its tension a step happens
STEP_WIDTH = 0.15


def _law(law: Law, v: Values) -> None:
    alpha, step, step_n, fall, fall_n = v["alpha"], v["step"], v["step_n"], v["fall"], v["fall_n"]
    if alpha != 0.0:

        def power(tension: Array) -> Array:
            return (np.maximum(tension, FLOOR_N) / REFERENCE_N) ** -alpha

        law.factors.append(power)
    if step != 0.0:

        def stepped(tension: Array) -> Array:
            return np.asarray(1.0 + step * np.tanh((step_n - tension) / (STEP_WIDTH * step_n)))

        law.factors.append(stepped)
    if fall != 0.0:

        def falling(tension: Array) -> Array:
            return np.asarray(1.0 + fall * np.exp(-np.maximum(tension, 0.0) / fall_n))

        law.factors.append(falling)
    rise, rise_n = v["rise"], v["rise_n"]
    if rise != 0.0:

        def rising(tension: Array) -> Array:
            return np.asarray(1.0 - rise * np.exp(-np.maximum(tension, 0.0) / rise_n))

        law.factors.append(rising)


EFFECT = Effect(
    id="load_dependent_friction",
    title="Friction coefficient that depends on the load",
    stage=FRICTION_LAW,
    equation="mu = mu0 (T / 10 N)^(-alpha); or, where the tendon changes sides, mu = mu0 (1 + s tanh((T_s - T) / (0.15 T_s))); "
    "or mu = mu0 (1 + f exp(-T / T_f)), mu0 (1 - r exp(-T / T_r))",
    source="Hertzian contact of polymers, catalogue entry [L]; slope products of Table II [C]",
    parameters=(
        Parameter("alpha", "1", 0.0, -0.1, 0.33, "load exponent; 1/3 is an elastic Hertz contact"),
        Parameter("step", "1", 0.0, -0.3, 0.3, "half of the step, as a part of the friction", limits=(-0.9, 0.9)),
        Parameter("step_n", "N", 10.0, 3.0, 20.0, "tension at which the friction steps", shape=True),
        # a tube that straightens does the same to the tensions: where this law would do, neither is named alone
        Parameter(
            "fall", "1", 0.0, 0.0, 1.0, "friction of an unloaded tendon beyond that of a loaded one, as a part of it", limits=(0.0, 5.0)
        ),
        Parameter("fall_n", "N", 8.0, 2.0, 40.0, "tension by which most of that is gone", shape=True),
        # and coils that close; a tube that yields on and on does not
        Parameter("rise", "1", 0.0, 0.0, 0.3, "friction that an unloaded tendon lacks, as a part of a loaded one's", limits=(0.0, 0.9)),
        Parameter("rise_n", "N", 6.0, 2.0, 15.0, "tension by which most of that has come", shape=True, limits=(0.5, 20.0)),
    ),
    excitation="A wide span of tension, or two amplitudes.",
    variants=(("alpha",), ("step", "step_n"), ("fall", "fall_n"), ("rise", "rise_n")),
    look_alikes=("sheath_compliance", "gain_error", "asymmetric_friction"),
    law=_law,
)
