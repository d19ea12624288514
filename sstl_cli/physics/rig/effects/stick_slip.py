"""Static friction above kinetic: a contact loses its excess when it slips, and has it back after a rest."""

from sstl_cli.physics.given import Bounds
from sstl_cli.physics.rig.effect import Effect, Parts, Values


def _build(rig: Parts, v: Values) -> None:
    rig.contact_law = rig.contact_law._replace(stick_ratio=v["ratio"], stick_speed=v["v_c_mm_s"])


EFFECT = Effect({"ratio": Bounds(1.0, 1.0, 1.5), "v_c_mm_s": Bounds(1.0, 0.1, 10.0)}, build=_build)
