"""Sensors whose zero moves over the run, by warming, in steps or at random."""

import numpy as np

from sstl_cli.physics.variant.effect import Effect, Reading, Values, wide
from sstl_cli.physics.variant.laws import Chosen, Law
from sstl_cli.physics.variant.line import Array

SENSORS = tuple(f"{side}_{system}" for system in ("act", "sstl") for side in ("in", "out"))
LAWS = (
    Law("warm_up", "r (1 - exp(-t/tau)) / (1 - exp(-D/tau)), tau = s D", "self-heating of a bridge, textbook", 0.1, 0.4),
    Law("steps", "r in steps at random times", "zero jumps of connectors and amplifiers, textbook", 2.0, 6.0),
    Law("random_walk", "bridge of a random walk that ends at r", "flicker drift, IEEE Std 952", 0.3, 0.6),
)


def _drifted(r: float, elapsed: Array, law: Chosen, rng: np.random.Generator) -> Array:
    """Return a zero that has moved by r (N) at the end of the run."""
    if r == 0.0:
        return np.zeros(elapsed.size)
    if law.id == "warm_up":
        return np.asarray(r * np.expm1(-elapsed / law.shape) / np.expm1(-1.0 / law.shape))
    if law.id == "steps":
        count = round(law.shape)
        places, sizes = np.sort(rng.random(count)), rng.dirichlet(np.ones(count))
        return np.asarray(r * np.concatenate(([0.0], np.cumsum(sizes)))[np.searchsorted(places, elapsed, "right")])
    walk = np.concatenate(([0.0], np.cumsum(rng.standard_normal(64)))) / 8.0
    bridge = walk - np.linspace(0.0, walk[-1], walk.size)
    return np.asarray(r * (elapsed + law.shape * np.interp(elapsed, np.linspace(0.0, 1.0, walk.size), bridge)))


def _sense(seen: Reading, v: Values, law: Chosen) -> None:
    elapsed = (seen.time - seen.time[0]) / (seen.time[-1] - seen.time[0])
    seen.t_in = seen.t_in + _drifted(v[f"r_in_{seen.system}_n"], elapsed, law, seen.drift)
    seen.t_out = seen.t_out + _drifted(v[f"r_out_{seen.system}_n"], elapsed, law, seen.drift)


EFFECT = Effect({f"r_{sensor}_n": wide(0.0, -1.0, 1.0) for sensor in SENSORS}, LAWS, order=65, sense=_sense)
