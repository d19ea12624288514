"""A friction coefficient that differs between pulling and releasing."""

from sstl_cli.physics.variant.effect import Effect, Parts, Values, wide
from sstl_cli.physics.variant.laws import Chosen, Law

LAWS = (
    Law("one_sided", "mu_p = mu (1 + 2a), mu_r = mu", "Section III-C2 of the paper, all of it in the pull [G]"),
    Law("by_load", "mu (1 +- a (T/10)^n)", "tilted asperities whose contact grows with load [G]", 0.33, 0.67),
)


def _build(made: Parts, v: Values, law: Chosen) -> None:
    made.rub = made.rub._replace(lean=v["a"], lean_code=law.code, lean_shape=law.shape)


EFFECT = Effect({"a": wide(0.0, -0.2, 0.2)}, LAWS, build=_build)
