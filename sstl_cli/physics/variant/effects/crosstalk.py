"""Either sensor also feels a share of the other's tension, or of both through a common mount."""

from sstl_cli.physics.variant.effect import Effect, Reading, Values, wide
from sstl_cli.physics.variant.laws import Chosen, Law

LAWS = (
    Law("both_ways", "T_i + c T_j, and s c back", "Catalogue: cross-talk both ways", 0.3, 1.0),
    Law("mounting", "T_i + c (T_i + T_j) through a common mount", "Catalogue: mounting stiffness"),
)


def _sense(seen: Reading, v: Values, law: Chosen) -> None:
    to_out, to_in, t_in, t_out = v["c_in_to_out"], v["c_out_to_in"], seen.t_in, seen.t_out
    if law.id == "mounting":
        both = t_in + t_out
        seen.t_in, seen.t_out = t_in + to_in * both, t_out + to_out * both
        return
    s = law.shape
    seen.t_in, seen.t_out = t_in + (to_in + s * to_out) * t_out, t_out + (to_out + s * to_in) * t_in


EFFECT = Effect({"c_in_to_out": wide(0.0, 0.0, 0.05), "c_out_to_in": wide(0.0, 0.0, 0.05)}, LAWS, order=40, sense=_sense)
