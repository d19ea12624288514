"""Friction that does not depend on tension: where the tube is bent, or at both ends of a pass."""

from sstl_cli.physics.variant.effect import Effect, Parts, Values, wide
from sstl_cli.physics.variant.laws import Chosen, Law

LAWS = (
    Law("adhesive", "dT = -zeta mu kappa (T + A) ds: by bend angle", "Derjaguin, Z. Phys. 88 (1934) 661: F = mu (N + A)"),
    Law("terminal", "half of w L at either end of a pass", "Catalogue, fingerprint of terminal friction; seals, textbook"),
)


def _build(made: Parts, v: Values, law: Chosen) -> None:
    made.line.weight[:] += v["w_l_n"] * (made.bend if law.id == "adhesive" else made.ends)


EFFECT = Effect({"w_l_n": wide(0.0, 0.0, 0.5)}, LAWS, order=20, build=_build)
