"""Sensors whose zero moves in proportion to time, over the run."""

from sstl_cli.physics.bristle.effect import Effect, Reading, Values
from sstl_cli.physics.given import Bounds

SENSORS = ("in_act", "out_act", "in_sstl", "out_sstl")


def _sense(seen: Reading, v: Values) -> None:
    passed = (seen.time - seen.time[0]) / (seen.time[-1] - seen.time[0])
    seen.zero_in = seen.zero_in + v[f"r_in_{seen.system}_n"] * passed
    seen.zero_out = seen.zero_out + v[f"r_out_{seen.system}_n"] * passed


EFFECT = Effect({f"r_{sensor}_n": Bounds(0.0, -1.0, 1.0) for sensor in SENSORS}, order=65, sense=_sense)
