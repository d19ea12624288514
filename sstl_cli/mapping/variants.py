"""The five variants of Table III, by name."""

from __future__ import annotations

from dataclasses import dataclass, replace

from sstl_cli.core.errors import UsageError, nearest

WIDTH = 128
BLOCKS = 2
LAMBDA = 2e-3


@dataclass(frozen=True)
class Variant:
    """One row of Table III.

    Parameters
    ----------
    alpha : float or None
        Weight of the shortcut in ``h <- tanh(W2 tanh(W1 h) + alpha h)``; None for linear regression.
    weight_inv : float
        Weight lambda of the inverse-consistency term of Eq. (loss).
    """

    name: str
    title: str
    alpha: float | None
    weight_inv: float = 0.0


VARIANTS = (
    Variant("linear", "Linear regression", None),
    Variant("plain", "Plain MLP", 0.0),
    Variant("plain-inv", "Plain MLP + L_inv", 0.0, LAMBDA),
    Variant("skip", "Skip-MLP", 1.0),
    Variant("skip-inv", "Skip-MLP + L_inv", 1.0, LAMBDA),
)
NAMES = tuple(v.name for v in VARIANTS)


def chosen(text: str, weight_inv: float = LAMBDA) -> tuple[Variant, ...]:
    """Return the variants named in a comma-separated list, or all of them for ``all``, in the order of Table III.

    Raises
    ------
    UsageError
        E501 for an unknown name or none at all.
    """
    names = [n.strip() for n in text.split(",") if n.strip()]
    if names == ["all"]:
        names = list(NAMES)
    for name in names:
        if name not in NAMES:
            raise UsageError(f"no variant '{name}' ({nearest(name, NAMES)})", where="--variants", code="E501")
    if not names:
        known = ",".join(NAMES)
        raise UsageError("no variant given", where="--variants", fix=f"use all, or some of {known}", code="E501")
    return tuple(replace(v, weight_inv=weight_inv) if v.weight_inv else v for v in VARIANTS if v.name in names)
