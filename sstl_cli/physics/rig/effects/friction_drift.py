"""Friction that begins higher or lower and settles over the path of the input tension."""

from sstl_cli.physics.given import Bounds
from sstl_cli.physics.rig.effect import Effect, Parts, Values


def _build(rig: Parts, v: Values) -> None:
    rig.contact_law = rig.contact_law._replace(drift=v["d_mu"], drift_path_n=v["path_n"])


EFFECT = Effect({"d_mu": Bounds(0.0, -0.3, 0.3), "path_n": Bounds(200.0, 10.0, 5000.0)}, build=_build)
