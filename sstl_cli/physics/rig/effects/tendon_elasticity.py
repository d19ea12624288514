"""A tendon of another stiffness than the data sheet says."""

from sstl_cli.physics.given import Bounds
from sstl_cli.physics.rig.effect import Effect, Parts, Values


def _build(rig: Parts, v: Values) -> None:
    if v["compliance_per_kn"] > 0.0:
        ea = 1000.0 / v["compliance_per_kn"]
        rig.chain.compliance[:], rig.chain.stiffness[:] = rig.lengths / ea, ea / rig.lengths


EFFECT = Effect({"compliance_per_kn": Bounds(0.0, 0.0, 0.33)}, build=_build)
