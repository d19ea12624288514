"""Likelihoods of several roughnesses of a latent input side by side (see ``smoother`` for the model)."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from sstl_cli.diagnosis.smoother import DIFFUSE, PART, Mask, Reading
from sstl_cli.physics.transmission.lanes import WIDTH, log, put, row, select, wide

Array = NDArray[np.float64]
# samples whose variances are multiplied before a logarithm is taken
TOGETHER = 8


def costs_of(y: Array, use: Mask, noise: Reading, corners: list[Array], bends: list[Array]) -> Array:
    """Return minus the log likelihood (nats, up to a constant) of all readings by each pair of variances, at most ``WIDTH`` of them.

    Parameters
    ----------
    corners, bends : list of ndarray, shape (n,)
        Variances of the steps of increment and of its change; one list holds a single array, which goes with each of the other.
    """
    many, one = (corners, bends[0]) if len(bends) == 1 else (bends, corners[0])
    side = np.empty((len(y), WIDTH))
    for lane in range(WIDTH):
        # lanes that nobody asked for repeat the first
        side[:, lane] = many[lane if lane < len(many) else 0]
    out = np.zeros((1, WIDTH))
    _march(y, use, noise, side, one, len(bends) == 1, out)
    return np.asarray(out[0, : len(many)])


@njit(cache=True, nogil=True, error_model="numpy")
def _march(y: Array, use: Mask, noise: Reading, side: Array, one: Array, of_corners: bool, out: Any) -> None:
    """Write minus the log likelihood by each column of ``side``: the Kalman filter of ``smoother.costs``, a roughness to a lane."""
    r, f, fresh = noise.white, noise.memory, noise.slow * (1.0 - noise.memory**2)
    lots, none, per_reading = wide(DIFFUSE * r), wide(0.0), 1.0 / r
    x0, x1, x2, xc = none, none, none, none
    s00, s11, s22, scc = lots, lots, lots, wide(noise.slow)
    s01, s02, s12, s0c, s1c, s2c = none, none, none, none, none, none
    total, product, pending, used = none, wide(1.0), 0, 0
    first = wide(1.0 if of_corners else 0.0) > 0.0
    for k in range(y.size):
        if k:
            tried, other = row(side, k), wide(one[k])
            w, b = select(first, tried, other), select(first, other, tried)
            x0 = x0 + (x1 + 0.5 * x2)
            x1 = x1 + x2
            xc = xc * f
            a00, a01, a02 = s00 + s01 + 0.5 * s02, s01 + s11 + 0.5 * s12, s02 + s12 + 0.5 * s22
            a11, a12 = s11 + s12, s12 + s22
            s0c, s1c, s2c, scc = f * (s0c + s1c + 0.5 * s2c), f * (s1c + s2c), f * s2c, f * f * scc + fresh
            s00, s01, s02 = a00 + a01 + 0.5 * a02 + PART * w, a01 + a02 + 0.5 * w, a02
            s11, s12, s22 = a11 + a12 + w, a12, s22 + b
        if use[k]:
            z0, z1, z2, zc = s00 + s0c, s01 + s1c, s02 + s2c, s0c + scc
            s, e = z0 + zc + r, y[k] - x0 - xc
            over = 1.0 / s
            total, product, pending, used = total + e * e * over, product * (per_reading * s), pending + 1, used + 1
            g0, g1, g2, gc = z0 * over, z1 * over, z2 * over, zc * over
            x0, x1, x2, xc = x0 + g0 * e, x1 + g1 * e, x2 + g2 * e, xc + gc * e
            s00, s01, s02, s0c = s00 - g0 * z0, s01 - g0 * z1, s02 - g0 * z2, s0c - g0 * zc
            s11, s12, s1c = s11 - g1 * z1, s12 - g1 * z2, s1c - g1 * zc
            s22, s2c, scc = s22 - g2 * z2, s2c - g2 * zc, scc - gc * zc
            if pending == TOGETHER:
                total, product, pending = total + log(product), wide(1.0), 0
    put(out, 0, 0.5 * (total + log(product) + used * np.log(r)))
