"""Sensors whose zero moves in proportion to time, over the run."""

from sstl_cli.physics.given import Bounds
from sstl_cli.physics.rig.effect import Effect, Reading, Values

SENSORS = tuple(f"{side}_{system}" for system in ("act", "sstl") for side in ("in", "out"))


def _sense(seen: Reading, v: Values) -> None:
    elapsed = (seen.time - seen.time[0]) / (seen.time[-1] - seen.time[0])
    seen.t_in = seen.t_in + v[f"r_in_{seen.system}_n"] * elapsed
    seen.t_out = seen.t_out + v[f"r_out_{seen.system}_n"] * elapsed


EFFECT = Effect({f"r_{sensor}_n": Bounds(0.0, -1.0, 1.0) for sensor in SENSORS}, order=65, sense=_sense)
