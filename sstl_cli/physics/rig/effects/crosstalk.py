"""Either sensor also feels a share of the other's tension."""

from sstl_cli.physics.given import Bounds
from sstl_cli.physics.rig.effect import Effect, Reading, Values


def _sense(seen: Reading, v: Values) -> None:
    seen.t_in, seen.t_out = seen.t_in + v["c_out_to_in"] * seen.t_out, seen.t_out + v["c_in_to_out"] * seen.t_in


EFFECT = Effect({"c_in_to_out": Bounds(0.0, 0.0, 0.05), "c_out_to_in": Bounds(0.0, 0.0, 0.05)}, order=40, sense=_sense)
