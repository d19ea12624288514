"""Drag along the sheath, in proportion to the sliding speed."""

from sstl_cli.physics.given import Bounds
from sstl_cli.physics.rig.effect import Effect, Parts, Values


def _build(rig: Parts, v: Values) -> None:
    rig.chain.drag[rig.sheathed] += v["c_l_n_s_per_mm"] / rig.spec.nodes


EFFECT = Effect({"c_l_n_s_per_mm": Bounds(0.0, 0.0, 0.05)}, build=_build)
