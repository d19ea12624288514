"""A tendon that creeps under load: several Kelvin elements."""

import numpy as np

from sstl_cli.physics.variant.effect import Effect, Parts, Values, positive, wide
from sstl_cli.physics.variant.laws import Chosen, Law
from sstl_cli.physics.variant.line import Array

LAWS = (
    Law("two_times", "two Kelvin elements, tau/s and tau s", "Findley, Lai, Onaran, Creep and Relaxation (1976) ch. 5", 3.0, 6.0),
    Law("power", "J = C f (t/tau)^n over four decades (Prony series)", "Findley, Lai, Onaran (1976) ch. 5; Nutting 1921", 0.15, 0.5),
)


def creep_spectrum(tau_s: float, law: Chosen) -> tuple[Array, Array]:
    """Return the time constants (s) and shares of the Kelvin elements of a creep law."""
    if law.id == "two_times":
        return np.array([tau_s / law.shape, tau_s * law.shape]), np.array([0.5, 0.5])
    ratio = 10.0 ** np.arange(-2.0, 2.5, 0.5)
    share = ratio**law.shape
    # as far after tau as a standard linear solid
    share *= (1.0 - np.exp(-1.0)) / np.sum(share * (1.0 - np.exp(-1.0 / ratio)))
    return tau_s * ratio, share


def _build(made: Parts, v: Values, law: Chosen) -> None:
    taus, shares = creep_spectrum(v["tau_s"], law)
    made.spring = made.spring._replace(creep=v["fraction"])
    at_rest = v["fraction"] * made.spec.pretension_n * np.outer(made.line.compliance, shares)
    made.line = made.line._replace(crept=at_rest, creep_share=shares, creep_s=taus)


EFFECT = Effect({"fraction": wide(0.0, 0.0, 0.3), "tau_s": positive(10.0, 1.0, 100.0)}, LAWS, build=_build)
