"""Tables I and II and the biases of Section III-C3 as entries, from a Theta table."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from sstl_cli.core.errors import SstlError
from sstl_cli.mapping.pairs import pairs_of
from sstl_cli.mapping.relations import relations, summary

Array = NDArray[np.float64]
Key = tuple[str, str, str]
MIN_PAIRS = 3


def slope_entries(theta: pa.Table) -> dict[Key, float]:
    """Return every entry of Tables I and II and of Section III-C3 that a Theta table shows.

    Raises
    ------
    SstlError
        If fewer than three configurations have both systems identified.
    """
    pairs = pairs_of(theta)
    if len(pairs) < MIN_PAIRS:
        raise SstlError(f"only {len(pairs)} configurations have both systems identified", fix="look at the status column", code="E801")
    rows = theta.to_pylist()
    betas = {
        (system, d): np.array([r[f"beta_{d}"] for r in rows if r["system"] == system and r[f"beta_{d}"] is not None])
        for system in ("act", "sstl")
        for d in "pr"
    }
    return line_entries(pairs.sstl, pairs.act, betas)


def line_entries(sstl: Array, act: Array, betas: Mapping[tuple[str, str], Array]) -> dict[Key, float]:
    """Return the entries of Tables I and II and of Section III-C3.

    Parameters
    ----------
    sstl, act : ndarray, shape (n, 2)
        Slopes (Gamma_p, Gamma_r) of both systems.
    betas : mapping
        Biases (N) by system and direction (p or r).
    """
    found = relations(sstl, act)
    done: dict[Key, float] = {}
    for row, fit in found.correlation.items():
        named = {"R": fit.pearson_r, "rmse_id": fit.identity_rmse, "slope": fit.slope, "bias": fit.bias, "rmse_fit": fit.fit_rmse}
        done.update({("I", row, column): value for column, value in named.items()})
    for system, quantities in found.slopes.items():
        for name, s in quantities.items():
            row = f"{system}_{name}"
            done.update({("II", row, c): getattr(s, c) for c in ("mean", "std", "min", "max")})
    for (system, d), values in betas.items():
        s = summary(values)
        done.update({("bias", f"{system}_beta_{d}", c): getattr(s, c) for c in ("mean", "std")})
    return done


def range_entries(theta: pa.Table) -> dict[Key, float]:
    """Return the range of the true actuation slopes (Table III, caption)."""
    act = pairs_of(theta).act
    return {
        ("range", f"act_gamma_{d}", side): float(f(act[:, i]))
        for i, d in enumerate("pr")
        for side, f in (("low", np.min), ("high", np.max))
    }
