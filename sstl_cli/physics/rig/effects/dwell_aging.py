"""Static friction that grows with the logarithm of the rest."""

from sstl_cli.physics.given import Bounds
from sstl_cli.physics.rig.effect import Effect, Parts, Values


def _build(rig: Parts, v: Values) -> None:
    rig.contact_law = rig.contact_law._replace(dwell_b=v["b"], dwell_t0=v["t0_s"])


EFFECT = Effect({"b": Bounds(0.0, 0.0, 0.05), "t0_s": Bounds(1.0, 0.1, 10.0)}, build=_build)
