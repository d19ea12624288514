"""Drag along the tube or where it is bent, in proportion to a power of the speed or less."""

from sstl_cli.physics.variant.effect import Effect, Parts, Values, wide
from sstl_cli.physics.variant.laws import Chosen, Law

LAWS = (
    Law("curvature", "c v per bend angle, none in the straight", "lubricant film under normal load, textbook"),
    Law("power", "c v0 (v/v0)^n per length", "Ostwald-de Waele shear-thinning grease", 0.5, 0.8),
    Law("eyring", "c v0 asinh(v/v0) per length", "Johnson, Tevaarwerk, Proc. R. Soc. A 356 (1977) 215", 0.5, 3.0),
)


def _build(made: Parts, v: Values, law: Chosen) -> None:
    made.rate = made.rate._replace(drag=v["c_l_n_s_per_mm"], drag_code=law.code, drag_shape=law.shape)
    made.line.drag[:] += v["c_l_n_s_per_mm"] * (made.bend if law.id == "curvature" else made.length)


EFFECT = Effect({"c_l_n_s_per_mm": wide(0.0, 0.0, 0.05)}, LAWS, build=_build)
