"""Friction coefficient that changes with the tension: curved propagation lines."""

import numpy as np

from sstl_cli.physics.effect import FRICTION_LAW, Array, Effect, Law, Parameter, Values

REFERENCE_N = 10.0
FLOOR_N = 0.05


def _law(law: Law, v: Values) -> None:
    alpha = v["alpha"]
    if alpha != 0.0:

        def factor(tension: Array) -> Array:
            return (np.maximum(tension, FLOOR_N) / REFERENCE_N) ** -alpha

        law.factors.append(factor)


EFFECT = Effect(
    id="load_dependent_friction",
    title="Friction coefficient that depends on the load",
    stage=FRICTION_LAW,
    equation="mu = mu0 (T / 10 N)^(-alpha)",
    source="Hertzian contact of polymers, catalogue entry [L]; slope products of Table II [C]",
    parameters=(Parameter("alpha", "1", 0.0, -0.1, 0.33, "load exponent; 1/3 is an elastic Hertz contact"),),
    excitation="A wide span of tension, or two amplitudes.",
    look_alikes=("sheath_compliance", "gain_error", "asymmetric_friction"),
    law=_law,
)
