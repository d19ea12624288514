"""Tendons that share a tube: a neighbour's tension bends it, and with it the friction of this tendon.

A tendon at distance d from the neutral axis bends the body by T_n d / (E I) per length (D. B. Camarillo et al., IEEE
Trans. Robotics 24 (2008) 1262-1273: moments of several tendons add in one compliant body). The wrap angle of every
other tendon grows by the length of the bend times that, or falls where the neighbour lies on the other side, and the
capstan equation, Eq. (1), takes the angle that is there: theta = theta_0 (1 + c T_n), c = d L / (E I Phi_0). The base
has c = 0. Sensors that feel one another are the effect ``crosstalk``.
"""

import numpy as np

from sstl_cli.physics.effect import FRICTION_LAW, Array, Drive, Effect, Law, Parameter, Values

# a tube that is bent straight keeps a little friction
LEAST_SHARE = 0.05


def _law(law: Law, v: Values) -> None:
    c = v["c_bend_per_n"]
    if c != 0.0:

        def scale(drive: Drive) -> Array:
            if drive.neighbour_n is None:
                return np.ones(1)
            return np.maximum(1.0 + c * drive.neighbour_n, LEAST_SHARE)

        law.friction_scale.append(scale)


EFFECT = Effect(
    id="tendon_crosstalk",
    title="Neighbouring tendons that bend the shared tube",
    stage=FRICTION_LAW,
    equation="theta = theta_0 (1 + c_bend T_n), T_n = summed input tension of the other tendons",
    source="Camarillo et al., IEEE T-RO 24 (2008) 1262 (tendons add moments in one body), put into Eq. (1)",
    parameters=(Parameter("c_bend_per_n", "1/N", 0.0, -0.01, 0.02, "relative change of the wrap angle per N of the neighbours"),),
    excitation="Several tendons recorded at once that do not move alike; one held while the other moves is best.",
    # only a log with the neighbours' tension can show it
    channel="neighbour",
    systems=("act",),
    look_alikes=("sheath_compliance", "friction_drift"),
    law=_law,
    along=True,
)
