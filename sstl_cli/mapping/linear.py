"""Linear regression, the baseline of Table III, in closed form."""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class Part(Protocol):
    """Scaled inputs, shape (seeds, n, d), physical outputs, shape (seeds, n, 2), and weights, shape (seeds, n)."""

    @property
    def x(self) -> Array: ...
    @property
    def y(self) -> Array: ...
    @property
    def weight(self) -> Array: ...


def fit_linear(fitting: Part, validating: Part, whole: Part, scaling: dict[str, NDArray[Any]]) -> tuple[dict[str, NDArray[Any]], Array]:
    """Return the weights fitted on the whole training part, and the validation RMSE (total) of a fit without it."""
    mean, scale = scaling["y_mean"], scaling["y_scale"]
    trial = _solve(fitting, mean, scale)
    out = mean[:, None] + scale[:, None] * (_with_one(validating.x) @ trial)
    mse = (((out - validating.y) ** 2).sum(axis=2) * validating.weight).sum(axis=1)
    solution = _solve(whole, mean, scale)
    return {"a": solution[:, :-1].transpose(0, 2, 1), "c": solution[:, -1]}, np.sqrt(mse / 2)


def _solve(part: Part, mean: Array, scale: Array) -> Array:
    """Return coefficients, shape (seeds, d + 1, 2); the shortest ones where the inputs do not fix them."""
    target = (part.y - mean[:, None]) / scale[:, None]
    root = np.sqrt(part.weight)[..., None]
    pairs = zip(root * _with_one(part.x), root * target, strict=True)
    return np.array([np.linalg.lstsq(a, b, rcond=1e-10)[0] for a, b in pairs])


def _with_one(x: Array) -> Array:
    return np.concatenate([x, np.ones((*x.shape[:-1], 1))], axis=-1)
