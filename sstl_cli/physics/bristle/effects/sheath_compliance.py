"""A sheath that bends with the local tension, the less the more it has closed, and shortens with that at its begin."""

from sstl_cli.physics.bristle.effect import Effect, Parts, Values
from sstl_cli.physics.given import Bounds


def _build(made: Parts, v: Values) -> None:
    made.law = made.law._replace(c_t=v["c_t_per_n"])
    made.setting = made.setting._replace(sheath_compliance=v["k_sh_mm_per_n"])


EFFECT = Effect({"c_t_per_n": Bounds(0.0, 0.0, 0.01), "k_sh_mm_per_n": Bounds(0.0, 0.0, 0.2)}, build=_build)
