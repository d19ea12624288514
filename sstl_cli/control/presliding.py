"""How far a loop is rounded: relative widths of the plays that add up to it, fitted to a record."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from sstl_cli.control.controller import PLAYS, Theta, normalised
from sstl_cli.core.errors import SstlError

Array = NDArray[np.float64]
MAX_SAMPLES = 4_000


def fit_widths(theta: Theta, tension_in: Array, tension_out: Array, plays: int = PLAYS) -> tuple[float, ...]:
    """Return the relative widths (mean 1, rising) of the plays that give a recorded or simulated loop.

    The loop may come from a model of the tendon with its diagnosed effects, so no distal sensor is needed.

    Parameters
    ----------
    theta : Theta
        Propagation lines of the loop.
    tension_in, tension_out : ndarray, shape (n,)
        Input and output tension in N, pulled at the first sample.

    Raises
    ------
    SstlError
        If there are fewer than ten samples or values are not finite.
    """
    from scipy.optimize import least_squares

    step = max(1, -(-len(tension_in) // MAX_SAMPLES))
    t_in = np.ascontiguousarray(tension_in[::step], dtype=np.float64)
    t_out = np.asarray(tension_out[::step], dtype=np.float64)
    if len(t_in) < 10 or not (np.isfinite(t_in).all() and np.isfinite(t_out).all()):
        raise SstlError("a loop to fit needs at least ten finite samples", fix="record a longer loop", code="E415")
    widest = 0.98 / (1.0 - theta.gamma_p) if theta.gamma_p < 1.0 else 10.0
    lines = (theta.gamma_p, theta.beta_p, theta.gamma_r, theta.beta_r)

    def widths_of(x: Array) -> Array:
        return normalised(np.cumsum(np.exp(x)))

    def residual(x: Array) -> Array:
        widths = widths_of(x)
        # beyond the widest the pull line of a play would fall with the input
        penalty = 100.0 * np.maximum(widths - widest, 0.0)
        return np.append(play_sum(t_in, np.minimum(widths, widest), *lines) - t_out, penalty)

    quantiles = 2.0 * (np.arange(plays) + 0.5) / plays - 1.0
    starts = (np.log(np.diff(1.0 + s * quantiles, prepend=0.0)) for s in (0.1, 0.5, 0.85))
    fits = [least_squares(residual, start, bounds=(-12.0, 3.0), x_scale=1.0, max_nfev=60) for start in starts]
    best = min(fits, key=lambda fit: float(fit.cost))
    return tuple(float(w) for w in np.minimum(widths_of(best.x), widest))


@njit(cache=True)
def play_sum(tension_in: Array, widths: Array, gp: float, bp: float, gr: float, br: float) -> Array:
    """Return the mean of plays of relative ``widths`` about the input (N, shape (n,)), each pulled at first."""
    out = np.empty_like(tension_in)
    held = np.full(widths.size, -np.inf)
    for k in range(tension_in.size):
        # all plays at once: each waits for its own last sample only
        t, total = tension_in[k], 0.0
        pull, release = (gp - 1.0) * t + bp, (gr - 1.0) * t + br
        for j in range(widths.size):
            held[j] = max(t + widths[j] * pull, min(held[j], t + widths[j] * release))
            total += held[j]
        out[k] = total
    return out / widths.size
