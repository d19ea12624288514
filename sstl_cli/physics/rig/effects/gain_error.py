"""An output sensor of another sensitivity than the input sensor's."""

from sstl_cli.physics.given import Bounds
from sstl_cli.physics.rig.effect import Effect, Reading, Values


def _sense(seen: Reading, v: Values) -> None:
    seen.t_out = seen.t_out * v[f"g_{seen.system}"]


EFFECT = Effect({f"g_{system}": Bounds(1.0, 0.85, 1.15) for system in ("act", "sstl")}, order=55, sense=_sense)
