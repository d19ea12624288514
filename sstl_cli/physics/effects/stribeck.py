"""Friction that falls with sliding speed, without jumps."""

import numpy as np

from sstl_cli.physics.effect import FRICTION_LAW, Array, Drive, Effect, Law, Parameter, Values, sliding_mm_per_n

def _law(law: Law, v: Values) -> None:
    ratio, v_s = v["ratio"], v["v_s_mm_s"]
    if ratio != 1.0:

        def scale(drive: Drive) -> Array:
            speed = np.abs(drive.rate_n_s) * sliding_mm_per_n(drive)
            return 1.0 + (ratio - 1.0) * np.exp(-((speed / v_s) ** 2))

        law.friction_scale.append(scale)


EFFECT = Effect(
    id="stribeck",
    title="Friction that falls with speed (Stribeck)",
    stage=FRICTION_LAW,
    equation="mu(v) = mu_c (1 + (ratio - 1) exp(-(v / v_s)^2))",
    source="Stribeck curve as in the LuGre model; catalogue entry [L, T]",
    parameters=(
        Parameter("ratio", "1", 1.0, 1.0, 1.5, "static over kinetic friction"),
        Parameter("v_s_mm_s", "mm/s", 1.0, 0.1, 10.0, "Stribeck speed", shape=True),
    ),
    excitation="At least two, better three, speeds a decade apart.",
    look_alikes=("stick_slip", "viscous"),
    law=_law,
)
