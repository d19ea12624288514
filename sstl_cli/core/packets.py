"""Rows that were stamped when they arrived: packets of them share one moment, and the clock tells nothing of when they were measured."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from sstl_cli.core.sound import GAP_PERIODS

Array = NDArray[np.float64]
# fewest packets, and rows in each, that show how a channel goes on within them
FEW: Final = 8
LEAST_ROWS: Final = 3
# by how much (logarithm of the likelihood) rows that are evenly apart must be likelier than their stamps: a chance of one in a million
RARE_NATS: Final = 14.0


@dataclass(frozen=True)
class Packets:
    """How rows arrived: ``rows`` in a packet, ``step_s`` apart there by their stamps, and ``pause_s`` from a packet to the next; ``rate_hz`` is that of the rows."""

    rows: int
    step_s: float
    pause_s: float
    rate_hz: float

    @property
    def said(self) -> str:
        return (
            f"packets of {self.rows} rows, {self.step_s:.3g} s apart with {self.pause_s:.3g} s between them, through which the tensions go on evenly from "
            "row to row: they were probably stamped when they arrived"
        )

    @property
    def mend(self) -> str:
        return f"state the rate: time_s = {{ rate_hz = {self.rate_hz:.6g} }}"


def packets_of(time_s: Array, channels: tuple[Array, ...]) -> Packets | None:
    """Return how the rows of one run arrived in packets, None where their stamps are as likely.

    A recorder that pauses finds the tension elsewhere after each pause: within a burst it moves by as much a second as from burst to burst.
    Rows that were only stamped together move by as much a row. Both are lines through the slopes within the packets, told by their likelihood.

    Parameters
    ----------
    time_s : ndarray, shape (n,)
        Stamps in s.
    channels : tuple of ndarray, shape (n,)
        What was recorded, in any unit.
    """
    step = np.diff(time_s)
    if len(step) < FEW * LEAST_ROWS or not float(step.min()) >= 0.0:
        return None
    inner = float(np.median(step))
    last = np.flatnonzero(step > GAP_PERIODS * inner)
    if len(last) < FEW:
        return None
    # the first and the last packet may have been cut
    first = last[:-1] + 1
    rows = np.diff(last)
    full = rows >= LEAST_ROWS
    if np.count_nonzero(full) < FEW or 2 * np.count_nonzero(full) < len(rows):
        return None
    seconds = float(time_s[first[-1]] - time_s[first[0]])
    each = float(np.mean(rows[:-1]))
    apart = inner * each * (len(first) - 1) / seconds
    nats = sum(_nats(v, first, rows, full, apart) for v in channels)
    if apart >= 1.0 or not nats > RARE_NATS:
        return None
    return Packets(round(each), inner, float(np.median(step[last])), each * (len(first) - 1) / seconds)


def _nats(v: Array, first: NDArray[np.int64], rows: NDArray[np.int64], full: NDArray[np.bool_], apart: float) -> float:
    """Return by how much (logarithm) slopes within packets are likelier to be those from packet to packet than ``apart`` times these."""
    starts = first.tolist()
    middle = first + 0.5 * (rows - 1)
    means = np.array([float(np.mean(v[a : a + n])) for a, n in zip(starts, rows.tolist(), strict=True)])
    use = np.flatnonzero(full[1:-1]) + 1
    beside = (means[use + 1] - means[use - 1]) / (middle[use + 1] - middle[use - 1])
    weight = np.empty(len(use))
    within = np.empty(len(use))
    for i, k in enumerate(use.tolist()):
        at = np.arange(rows[k]) - 0.5 * (rows[k] - 1)
        weight[i] = float(at @ at)
        within[i] = float(at @ v[starts[k] : starts[k] + rows[k]]) / weight[i]
    power = float(np.sum(weight * beside**2))
    if not (np.isfinite(power) and power > 0.0) or len(use) < 2:
        return 0.0
    best = float(np.sum(weight * within * beside)) / power
    left = float(np.sum(weight * (within - best * beside) ** 2)) / (len(use) - 1)
    return ((best - apart) ** 2 - (best - 1.0) ** 2) * power / (2.0 * max(left, 1e-12 * power / len(use)))
