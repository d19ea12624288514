"""A load that stiffens as a sinh, behind a joint with play."""

from math import asinh, sqrt

from sstl_cli.physics.bristle.effect import Effect, Parts, Values
from sstl_cli.physics.given import Bounds

# Travel of the load end (mm) in which the play of its joint is taken up.
PLAY_SLIP_MM = 1.5e-3


def _build(made: Parts, v: Values) -> None:
    # sinh has the cubic term of k1 (y + k3 y^3) for q^2 = 6 k3
    k1, q, y0 = made.load.k1, sqrt(6.0 * v["k3_per_mm2"]), made.load.y0
    if q > 0.0:
        y0 = asinh(made.spec.pretension_n * q / k1) / q
    made.load = made.load._replace(q=q, y0=y0, half_play=0.5 * v["play_mm"], play_slip=PLAY_SLIP_MM)


EFFECT = Effect({"k3_per_mm2": Bounds(0.0, 0.0, 0.1), "play_mm": Bounds(0.0, 0.0, 2.0)}, build=_build)
