"""Sensors whose zero is off."""

from sstl_cli.physics.given import Bounds
from sstl_cli.physics.rig.effect import Effect, Reading, Values

SENSORS = tuple(f"{side}_{system}" for system in ("act", "sstl") for side in ("in", "out"))


def _sense(seen: Reading, v: Values) -> None:
    seen.t_in = seen.t_in + v[f"z_in_{seen.system}_n"]
    seen.t_out = seen.t_out + v[f"z_out_{seen.system}_n"]


EFFECT = Effect({f"z_{sensor}_n": Bounds(0.0, -2.0, 2.0) for sensor in SENSORS}, order=60, sense=_sense)
