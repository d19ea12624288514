"""Sensors whose zero is off."""

from sstl_cli.physics.bristle.effect import Effect, Reading, Values
from sstl_cli.physics.given import Bounds

SENSORS = ("in_act", "out_act", "in_sstl", "out_sstl")


def _sense(seen: Reading, v: Values) -> None:
    seen.zero_in = seen.zero_in + v[f"z_in_{seen.system}_n"]
    seen.zero_out = seen.zero_out + v[f"z_out_{seen.system}_n"]


EFFECT = Effect({f"z_{sensor}_n": Bounds(0.0, -2.0, 2.0) for sensor in SENSORS}, order=60, sense=_sense)
