"""A load that stiffens with its stretch, behind a joint with play."""

from scipy.optimize import brentq

from sstl_cli.physics.given import Bounds
from sstl_cli.physics.rig.effect import Effect, Parts, Values

# Stretch of the load spring (mm) over which the play of its joint is passed.
PLAY_WIDTH_MM = 2e-3


def _build(rig: Parts, v: Values) -> None:
    k3, k1, y0 = v["k3_per_mm2"], rig.load.k1, rig.load.y0
    if k3 > 0.0 and y0 > 0.0:
        y0 = float(brentq(lambda y: k1 * (y + k3 * y**3) - rig.spec.pretension_n, 0.0, y0, xtol=1e-15))
    rig.load = rig.load._replace(k3=k3, y0=y0, half_play=0.5 * v["play_mm"], play_width=PLAY_WIDTH_MM)


EFFECT = Effect({"k3_per_mm2": Bounds(0.0, 0.0, 0.1), "play_mm": Bounds(0.0, 0.0, 2.0)}, build=_build)
