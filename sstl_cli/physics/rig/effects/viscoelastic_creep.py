"""A tendon that creeps under load: a standard linear solid."""

from sstl_cli.physics.given import Bounds
from sstl_cli.physics.rig.effect import Effect, Parts, Values


def _build(rig: Parts, v: Values) -> None:
    rig.setting = rig.setting._replace(creep_fraction=v["fraction"], creep_tau=v["tau_s"])


EFFECT = Effect({"fraction": Bounds(0.0, 0.0, 0.3), "tau_s": Bounds(10.0, 1.0, 100.0)}, build=_build)
