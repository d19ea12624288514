"""An output sensor of another sensitivity than the input sensor's."""

from sstl_cli.physics.bristle.effect import Effect, Reading, Values
from sstl_cli.physics.given import Bounds


def _sense(seen: Reading, v: Values) -> None:
    seen.t_out = v[f"g_{seen.system}"] * seen.t_out


EFFECT = Effect({f"g_{system}": Bounds(1.0, 0.85, 1.15) for system in ("act", "sstl")}, order=55, sense=_sense)
