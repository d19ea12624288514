"""Predict with a trained mapping: numpy alone, so that the controller's host needs no torch."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sstl_cli.core.errors import SstlError, nearest
from sstl_cli.mapping.header import Header

Array = NDArray[np.float64]
Weights = dict[str, NDArray[Any]]
SCALING = ("x_mean", "x_scale", "y_mean", "y_scale")
# where an input lies in the trained range
INSIDE, EDGE, OUTSIDE = "inside", "edge", "outside"


@dataclass(frozen=True)
class Group:
    """Weights of the same tendons: scaling, shape (seeds, 2), and per variant the weights stacked over seeds."""

    scaling: Weights
    variants: dict[str, Weights]


@dataclass(frozen=True)
class MappingModel:
    """A trained mapping: every variant and seed, and which variant predicts by default.

    Attributes
    ----------
    header : Header
        What it was trained on and how.
    groups : tuple of Group
        One for all tendons, or one a tendon (``header.strategy``).
    """

    header: Header
    groups: tuple[Group, ...]

    def predict(self, gamma_sstl: Array, tendon: str | None = None, variant: str | None = None) -> Array:
        """Return the actuation slopes Gamma_p, Gamma_r: the mean over seeds of the default variant.

        Parameters
        ----------
        gamma_sstl : array, shape (n, 2)
            Slopes Gamma_p, Gamma_r of the sensing loop; a row with NaN gives NaN.
        tendon : str, optional
            Actuation tendon; needed where the model knows several.
        variant : str, optional
            Another variant of the model.

        Raises
        ------
        SstlError
            E505 for an unknown tendon or variant, or an input of another shape.
        """
        mean: Array = self.members(gamma_sstl, tendon, variant).mean(axis=0)
        return mean

    def members(self, gamma_sstl: Array, tendon: str | None = None, variant: str | None = None) -> Array:
        """Return the prediction of every seed, shape (seeds, n, 2); parameters as in ``predict``."""
        name = self.header.default if variant is None else variant
        if name not in self.groups[0].variants:
            raise SstlError(f"model has no variant '{name}' ({nearest(name, self.groups[0].variants)})", code="E505")
        group = self.groups[self.group_of(tendon)]
        x = features(_inputs(gamma_sstl), self.header.one_hot(tendon))
        return forward(x, group.scaling, group.variants[name], self.header.alpha(name))

    def outside_range(self, gamma_sstl: Array) -> NDArray[np.bool_]:
        """Return, shape (n,), which inputs lie outside the trained range.

        Outside is beyond the smallest or largest trained slope, or farther from the trained cloud (Mahalanobis)
        than any trained input: the two slopes vary together, so a box alone would accept pairs never seen.
        """
        x = _inputs(gamma_sstl)
        low, high = np.array(self.header.input_low), np.array(self.header.input_high)
        inside = ((x >= low) & (x <= high)).all(axis=1)
        # the comparison is false for NaN, which is outside too
        away = distance(x, np.array(self.header.centre), np.array(self.header.precision))
        return ~(inside & (away <= self.header.reach))

    def place(self, gamma_sstl: Array, se: Array) -> str:
        """Return where one input lies, shape (1, 2): at the edge where two standard errors may bring it back inside."""
        if not self.outside_range(gamma_sstl)[0]:
            return INSIDE
        # two standard errors nearer to the middle of the training data
        nearer = gamma_sstl + np.clip(np.array([self.header.centre]) - gamma_sstl, -2.0 * se, 2.0 * se)
        return OUTSIDE if self.outside_range(nearer)[0] else EDGE

    # the controller's host asks by this name
    outside = outside_range

    @property
    def beta_act(self) -> tuple[float, float]:
        """Pre-calibrated biases beta_p, beta_r of the actuation tendon in N: means over the training runs.

        Raises
        ------
        SstlError
            E507 if the training runs had none.
        """
        return self.beta_act_of(None)

    def beta_act_of(self, tendon: str | None) -> tuple[float, float]:
        """Return the pre-calibrated biases of one tendon in N, of all tendons for None."""
        known = self.header.beta_act if tendon is None else self.header.beta_by_tendon.get(tendon, self.header.beta_act)
        if known is None:
            raise SstlError("the model was trained without biases", fix="give --beta-p and --beta-r", code="E507")
        return known

    def group_of(self, tendon: str | None) -> int:
        """Return the position of the group that serves a tendon."""
        names = self.header.tendons
        if names and tendon not in names:
            what = "is needed" if tendon is None else f"'{tendon}' is unknown"
            raise SstlError(f"tendon {what}; the model knows {', '.join(names)}", code="E505")
        return names.index(tendon) if tendon is not None and self.header.strategy == "separate" else 0


def features(x: Array, one_hot: Sequence[float]) -> Array:
    """Return the slopes with the tendon's indicator columns behind them, shape (n, 2 + tendons)."""
    return np.hstack([x, np.tile(np.asarray(one_hot, np.float64), (len(x), 1))]) if len(one_hot) else x


def forward(x: Array, scaling: Weights, weights: Weights, alpha: float | None) -> Array:
    """Return the predictions of all members, shape (seeds, n, 2), for features of shape (n, d); computed in float64."""
    w = {k: v.astype(np.float64) for k, v in weights.items()}
    s = {k: v.astype(np.float64)[:, None, :] for k, v in scaling.items()}
    scaled = np.tile(x, (len(s["x_mean"]), 1, 1))
    scaled[:, :, :2] = (scaled[:, :, :2] - s["x_mean"]) / s["x_scale"]
    if alpha is None:
        out = scaled @ w["a"].transpose(0, 2, 1) + w["c"][:, None]
    else:
        h = scaled @ w["e_w"].transpose(0, 2, 1) + w["e_b"][:, None]
        for k in range(w["w1"].shape[1]):
            inner = np.tanh(h @ w["w1"][:, k].transpose(0, 2, 1) + w["b1"][:, k, None])
            h = np.tanh(inner @ w["w2"][:, k].transpose(0, 2, 1) + w["b2"][:, k, None] + alpha * h)
        out = h @ w["h_w"].transpose(0, 2, 1) + w["h_b"][:, None]
    return s["y_mean"] + s["y_scale"] * out


def distance(x: Array, centre: Array, precision: Array) -> Array:
    """Return the Mahalanobis distance of each row to the centre."""
    d = x - centre
    far: Array = np.sqrt(np.maximum(np.einsum("ni,ij,nj->n", d, precision, d), 0.0))
    return far


def _inputs(gamma_sstl: Array) -> Array:
    x = np.asarray(gamma_sstl, dtype=np.float64)
    if x.ndim != 2 or x.shape[1] != 2:
        raise SstlError(f"mapping takes slopes of shape (n, 2), not {x.shape}", code="E505")
    return x
