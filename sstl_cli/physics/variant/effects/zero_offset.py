"""Sensors whose zero is off, with the bend or once they were loaded."""

import numpy as np

from sstl_cli.physics.variant.effect import Effect, Reading, Values, wide
from sstl_cli.physics.variant.laws import Chosen, Law
from sstl_cli.physics.variant.line import Array

NOMINAL_THETA = 0.53
SENSORS = tuple(f"{side}_{system}" for system in ("act", "sstl") for side in ("in", "out"))
LAWS = (
    Law("preload", "z theta / 0.53", "Catalogue: preload that grows with the bend"),
    Law("zero_return", "z (1 - exp(-max T / s))", "zero return after load, OIML R 60", 4.0, 12.0),
)


def _zero(z: float, tension: Array, theta: float, law: Chosen) -> Array:
    if z == 0.0:
        return np.zeros(tension.size)
    if law.id == "preload":
        return np.full(tension.size, z * theta / NOMINAL_THETA)
    return np.asarray(-z * np.expm1(-np.maximum.accumulate(np.maximum(tension, 0.0)) / law.shape))


def _sense(seen: Reading, v: Values, law: Chosen) -> None:
    seen.t_in = seen.t_in + _zero(v[f"z_in_{seen.system}_n"], seen.true_in, seen.theta, law)
    seen.t_out = seen.t_out + _zero(v[f"z_out_{seen.system}_n"], seen.true_out, seen.theta, law)


EFFECT = Effect({f"z_{sensor}_n": wide(0.0, -2.0, 2.0) for sensor in SENSORS}, LAWS, order=60, sense=_sense)
