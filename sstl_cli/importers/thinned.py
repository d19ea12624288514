"""A series of any length kept at no more than a million samples."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
MOST = 1 << 20


def advancing(time: Array, top: float) -> tuple[NDArray[np.bool_], float]:
    """Return which times (s), shape (n,), go beyond all before them and beyond ``top``, and the new top."""
    finite = np.isfinite(time)
    before = np.maximum.accumulate(np.concatenate(([top], np.where(finite, time, -np.inf))))
    return finite & (time > before[:-1]), float(before[-1])


class Thinned:
    """Samples whose time goes forward; from ``MOST`` on the means of two, four, ... consecutive ones take their place."""

    def __init__(self) -> None:
        self._each, self._top, self._count = 1, -np.inf, 0
        self._kept: list[NDArray[np.float64]] = []
        self._rest: Array = np.empty((2, 0))

    def add(self, time: Array, values: Array) -> None:
        """Take in times (s) and values, shape (n,); those that are no numbers or go back are left out."""
        good = np.isfinite(time) & np.isfinite(values)
        keep, self._top = advancing(np.where(good, time, np.nan), self._top)
        rows = np.concatenate((self._rest, np.stack((time[keep], values[keep]))), axis=1)
        whole = rows.shape[1] // self._each * self._each
        self._rest = rows[:, whole:]
        self._keep(rows[:, :whole].reshape(2, -1, self._each).mean(axis=2) if self._each > 1 else rows[:, :whole])

    def _keep(self, rows: Array) -> None:
        self._kept.append(rows)
        self._count += rows.shape[1]
        while self._count > MOST:
            held = np.concatenate(self._kept, axis=1)
            even = held.shape[1] // 2 * 2
            # a mean without its partner waits as that many samples of its own value
            self._rest = np.concatenate((np.repeat(held[:, even:], self._each, axis=1), self._rest), axis=1)
            self._kept = [held[:, :even].reshape(2, -1, 2).mean(axis=2)]
            self._count, self._each = even // 2, 2 * self._each

    def arrays(self) -> tuple[Array, Array]:
        """Return times (s) and values, each of shape (m,)."""
        held = np.concatenate(self._kept, axis=1) if self._kept else np.empty((2, 0))
        return held[0], held[1]
