"""A sheath that bends further with the local tension, and shortens with that at its begin."""

from sstl_cli.physics.given import Bounds
from sstl_cli.physics.rig.effect import Effect, Parts, Values


def _build(rig: Parts, v: Values) -> None:
    rig.tension_law = rig.tension_law._replace(c_t=v["c_t_per_n"])
    rig.setting = rig.setting._replace(sheath_compliance=v["k_sh_mm_per_n"])


EFFECT = Effect({"c_t_per_n": Bounds(0.0, 0.0, 0.01), "k_sh_mm_per_n": Bounds(0.0, 0.0, 0.2)}, build=_build)
