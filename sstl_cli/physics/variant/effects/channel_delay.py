"""An output channel that is read late, by a jittering time or until a bus refreshes it."""

import numpy as np
from scipy.signal import lfilter

from sstl_cli.physics.variant.effect import Effect, Reading, Values, wide
from sstl_cli.physics.variant.laws import Chosen, Law
from sstl_cli.physics.variant.line import Array

JITTER_CORRELATION_S = 0.1
LAWS = (
    Law("jitter", "tau (1 + s n(t)), n correlated over 0.1 s", "Cervin et al., IEEE Control Syst. Mag. 23 (2003) 16", 0.15, 0.4),
    Law("bus", "held between refreshes 2 tau apart", "sample and hold of a slow bus, textbook"),
)


def late_clock(time: Array, tau_s: float, law: Chosen, rng: np.random.Generator) -> Array:
    """Return the instants (s) whose tension the output channel shows."""
    if law.id == "bus":
        phase = rng.random()
        return np.asarray((np.floor((time - time[0]) / (2.0 * tau_s) + phase) - phase) * 2.0 * tau_s + time[0])
    decay = float(np.exp(-np.median(np.diff(time)) / JITTER_CORRELATION_S))
    wander = lfilter([np.sqrt(1.0 - decay**2)], [1.0, -decay], rng.standard_normal(time.size))
    return np.asarray(time - tau_s * np.clip(1.0 + law.shape * wander, 0.0, 3.0))


def _sample(seen: Reading, v: Values, law: Chosen) -> None:
    if v[f"tau_{seen.system}_s"] > 0.0:
        seen.read_at = late_clock(seen.stamps, v[f"tau_{seen.system}_s"], law, seen.late)


EFFECT = Effect({f"tau_{system}_s": wide(0.0, 0.0, 0.2) for system in ("act", "sstl")}, LAWS, order=95, sample=_sample)
