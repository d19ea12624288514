"""Friction that begins higher or lower and settles, over time, with its heat or with its wear."""

from sstl_cli.physics.variant.effect import Effect, Parts, Values, positive, wide
from sstl_cli.physics.variant.laws import Chosen, Law
from sstl_cli.physics.variant.line import REFERENCE_N

LAWS = (
    Law("time", "1 + d exp(-t/tau), tau = path / s", "Blau, Tribol. Int. 38 (2005) 1007: running-in by time", 3.0, 10.0),
    Law("heat", "1 + d (1 - h), dh = dW/W0 (1 - h) - h dt/tau_c", "friction heat with Newtonian cooling, textbook", 20.0, 120.0),
    Law(
        "wear",
        "1 + d exp(-W_j/W0) at each place, W = friction work",
        "Archard, J. Appl. Phys. 24 (1953) 981; Fouvry et al., Wear 255 (2003) 287",
    ),
)


def _build(made: Parts, v: Values, law: Chosen) -> None:
    made.rate = made.rate._replace(drift=v["d_mu"], drift_code=law.code, drift_path=v["path_n"], drift_shape=law.shape)
    path = v["path_n"] * 0.5 * (0.5 * made.per_pass + 1.0 / made.spec.load_k1_n_per_mm)
    made.line.wear_n_mm[:] = (made.line.angle * REFERENCE_N + made.line.weight) * path


EFFECT = Effect({"d_mu": wide(0.0, -0.3, 0.3), "path_n": positive(200.0, 10.0, 5000.0)}, LAWS, build=_build)
