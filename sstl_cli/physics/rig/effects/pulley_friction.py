"""The pulley between the two passes as one more node: a share of the tension, by direction, and a constant."""

import numpy as np

from sstl_cli.physics.given import Bounds
from sstl_cli.physics.rig.effect import Effect, Parts, Values


def _build(rig: Parts, v: Values) -> None:
    # Chosen so that across the node T+ = T- exp(-+m) -+ f0 holds exactly.
    pull, release = np.tanh(0.5 * v["m_p"]), np.tanh(0.5 * v["m_r"])
    pulley = ~rig.sheathed
    rig.chain.slope_pull[pulley], rig.chain.bias_pull[pulley] = 2.0 * pull, v["f0_n"] * (1.0 + pull)
    rig.chain.slope_release[pulley], rig.chain.bias_release[pulley] = 2.0 * release, v["f0_n"] * (1.0 - release)


EFFECT = Effect({"m_p": Bounds(0.0, 0.0, 0.25), "m_r": Bounds(0.0, 0.0, 0.25), "f0_n": Bounds(0.0, 0.0, 2.0)}, build=_build)
