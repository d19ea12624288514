"""Friction that runs in or wears: both slopes open or close over the cycles, biases stay."""

import numpy as np

from sstl_cli.physics.effect import FRICTION_LAW, Array, Drive, Effect, Law, Parameter, Values


def _law(law: Law, v: Values) -> None:
    d_mu, path = v["d_mu"], v["path_n"]
    if d_mu != 0.0:

        def scale(drive: Drive) -> Array:
            return 1.0 + d_mu * np.exp(-drive.path_n / path)

        law.friction_scale.append(scale)


EFFECT = Effect(
    id="friction_drift",
    title="Friction that drifts with use",
    stage=FRICTION_LAW,
    equation="mu(t) = mu_inf (1 + d_mu exp(-W / path)), W = path of the input tension",
    source="Run-in, heat and wear; catalogue entry [L]",
    parameters=(
        Parameter("d_mu", "1", 0.0, -0.3, 0.3, "relative friction above its final value at the start"),
        Parameter("path_n", "N", 200.0, 10.0, 5000.0, "input-tension path of the run-in", shape=True),
    ),
    excitation="Several equal cycles in one run.",
    look_alikes=("zero_drift",),
    law=_law,
)
