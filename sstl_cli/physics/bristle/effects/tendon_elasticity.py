"""A tendon of another stiffness than the data sheet says."""

from sstl_cli.physics.bristle.effect import Effect, Parts, Values
from sstl_cli.physics.given import Bounds


def _build(made: Parts, v: Values) -> None:
    if v["compliance_per_kn"] > 0.0:
        made.chain.compliance[:] = made.lengths * (1e-3 * v["compliance_per_kn"])


EFFECT = Effect({"compliance_per_kn": Bounds(0.0, 0.0, 0.33)}, build=_build)
