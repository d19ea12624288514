"""A load that stiffens with its stretch or rubs in itself, behind a joint with play."""

from math import log

from sstl_cli.physics.variant.effect import Effect, Parts, Values, wide
from sstl_cli.physics.variant.laws import Chosen, Law

LAWS = (
    Law("fung", "T = k1/b (exp(b x) - 1); play over dT", "Fung, Biomechanics (1993)", 0.3, 3.0),
    Law("hysteretic", "T = k1 x + z, |z| <= 1.5 N; play over dT", "Jenkins element: Iwan, J. Appl. Mech. 33 (1966) 893", 0.3, 3.0),
)


def _build(made: Parts, v: Values, law: Chosen) -> None:
    steeper = log(1.0 + 27.0 * v["k3_per_mm2"])
    fung = law.code == 0
    made.spring = made.spring._replace(
        fung=steeper / 3.0 if fung else 0.0, joint_share=0.0 if fung else steeper, play=v["play_mm"], play_n=law.shape
    )


EFFECT = Effect({"k3_per_mm2": wide(0.0, 0.0, 0.1), "play_mm": wide(0.0, 0.0, 2.0)}, LAWS, build=_build)
