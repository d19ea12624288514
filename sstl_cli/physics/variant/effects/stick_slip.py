"""Static friction above kinetic: a contact loses its excess when it slips, and has it back after a rest."""

from sstl_cli.physics.variant.effect import Effect, Parts, Values, positive, wide
from sstl_cli.physics.variant.laws import Chosen, Law

LAWS = (
    Law("kato", "1 + (r - 1)(1 - exp(-(t/tc)^m))", "Kato, Sato, Matsubayashi, J. Lubr. Technol. 94 (1972) 234", 0.36, 0.67),
    Law("armstrong", "1 + (r - 1) t / (t + tc)", "Armstrong-Helouvry, Dupont, Canudas de Wit, Automatica 30 (1994) 1083"),
)


def _build(made: Parts, v: Values, law: Chosen) -> None:
    made.rate = made.rate._replace(heal=v["ratio"] - 1.0, heal_s=made.healing_mm / v["v_c_mm_s"], heal_code=law.code, heal_shape=law.shape)


EFFECT = Effect({"ratio": wide(1.0, 1.0, 1.5), "v_c_mm_s": positive(1.0, 0.1, 10.0)}, LAWS, build=_build)
