"""An output channel that is read late by a constant time."""

from sstl_cli.physics.given import Bounds
from sstl_cli.physics.rig.effect import Effect, Reading, Values


def _sample(seen: Reading, v: Values) -> None:
    seen.late_s = v[f"tau_{seen.system}_s"]


EFFECT = Effect({f"tau_{system}_s": Bounds(0.0, 0.0, 0.2) for system in ("act", "sstl")}, sample=_sample)
