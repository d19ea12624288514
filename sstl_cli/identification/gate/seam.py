"""Where one recording ends and another goes on: both channels jump at one sample, and stay there."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
# smallest jump looked at (share of the span), and samples on either side that it is compared with
LEAST_JUMP, AROUND = 0.05, 40


def seam_of(time_s: Array, channels: tuple[Array, Array], spans: tuple[float, float], stride: int = 1) -> tuple[tuple[float, float], float]:
    """Return the largest jump that both channels make at one sample for good (shares of their spans), and when (s).

    A jump is the change of the median of five samples beyond what five of the largest steps around it would make. Of
    channels held for some samples every ``stride``-th is looked at, and one may jump a renewal later than the other.
    """
    jumps = []
    time_s = time_s[::stride]
    for v, span in zip((c[::stride] for c in channels), spans, strict=True):
        step = np.abs(np.diff(v))
        lasting = np.zeros(len(step))
        at = np.argsort(step)[-256:]
        for k in at[(at >= 4) & (at < len(v) - 5) & (step[at] > LEAST_JUMP * span)]:
            if np.all(v[k - 3 : k] == v[k]):
                # a recorder that stood still catches up
                continue
            usual = max(float(s.max(initial=0.0)) for s in (step[max(0, k - AROUND) : k - 1], step[k + 2 : k + AROUND]))
            lasting[k] = abs(float(np.median(v[k + 1 : k + 6])) - float(np.median(v[k - 4 : k + 1]))) - 5.0 * usual
        if stride > 1:
            lasting = np.maximum(lasting, np.maximum(np.append(lasting[1:], 0.0), np.insert(lasting[:-1], 0, 0.0)))
        jumps.append(lasting / max(span, 1e-300))
    both = np.minimum(*jumps)
    k = int(np.argmax(both))
    return (float(jumps[0][k]), float(jumps[1][k])), float(time_s[k + 1])
