"""The bar on standard error: it appears once work takes over two seconds, and moves with the time that is left."""

from __future__ import annotations

import threading
import time
from bisect import bisect_right
from collections.abc import Callable, Sequence
from typing import Any

SHOW_AFTER_S = 2.0


class Pace:
    """How far a work is in time, where its steps take unequal times.

    ``curve`` has pairs (share of the steps told, share of the time gone by then), as measured. Between two tellings time goes on as
    fast as it did so far, but not beyond what the next telling will say. With ``parts`` the work is done so many times over.

    Examples
    --------
    >>> now = [0.0]
    >>> pace = Pace([(0.0, 0.1), (0.5, 0.2), (1.0, 1.0)], clock=lambda: now[0])
    >>> now[0] = 2.0
    >>> pace.told(0.5)
    >>> pace.share()
    0.2
    >>> now[0] = 5.0
    >>> pace.share()
    0.5
    """

    def __init__(self, curve: Sequence[tuple[float, float]], parts: int = 1, clock: Callable[[], float] = time.monotonic) -> None:
        self._steps, self._times = zip(*curve, strict=True)
        self._parts, self._clock, self._began = parts, clock, clock()
        self._told = self._time = self._shown = 0.0
        self._after = 0.0

    def told(self, share: float) -> None:
        """Take note that this share of the steps (0 to 1) is done."""
        self._told = min(max(share, self._told), 1.0)
        gone = self._gone(self._told)
        if gone > self._time:
            self._time, self._after = gone, self._clock() - self._began

    def share(self) -> float:
        """Return the share of the time (0 to 1) that is gone; it never falls."""
        guess = self._time
        if self._after > 0:
            guess = max(guess, self._time * (self._clock() - self._began) / self._after)
        self._shown = max(self._shown, min(guess, self._next(self._told)))
        return self._shown

    def _gone(self, share: float) -> float:
        """Return the share of the time that is gone where so much was told."""
        part = min(int(share * self._parts), self._parts - 1)
        within = share * self._parts - part
        at = min(max(bisect_right(self._steps, within), 1), len(self._steps) - 1)
        a, b = self._steps[at - 1], self._steps[at]
        between = (within - a) / (b - a)
        return float((part + self._times[at - 1] + between * (self._times[at] - self._times[at - 1])) / self._parts)

    def _next(self, share: float) -> float:
        """Return the share of the time at the next corner of the curve."""
        part = min(int(share * self._parts), self._parts - 1)
        later = bisect_right(self._steps, share * self._parts - part)
        return float((part + (self._times[later] if later < len(self._times) else 1.0)) / self._parts)


class Bar:
    """A progress bar that nobody sees before ``SHOW_AFTER_S``; ``total`` is None where it is not known."""

    def __init__(self, label: str, total: float | None, pace: Pace | None = None) -> None:
        self._label, self._total, self._pace = label, total, pace
        self._done, self._over = 0.0, False
        self._bar: Any = None
        self._lock = threading.Lock()
        # work that tells nothing for a while is shown at the same time as other work
        self._timer = threading.Timer(SHOW_AFTER_S, self._show)
        self._timer.daemon = True
        self._timer.start()

    def advance(self, amount: float) -> None:
        """Take note of work that is done; may be called by several threads."""
        with self._lock:
            self._done += amount
            if self._pace is not None:
                self._pace.told(self._done / (self._total or 1.0))
            elif self._bar is not None:
                self._bar.update(0, completed=self._done)

    def close(self) -> None:
        """Take the bar away."""
        self._timer.cancel()
        with self._lock:
            self._over = True
            bar = self._bar
        if bar is not None:
            bar.stop()

    def _show(self) -> None:
        bar = _rich(self._label, 1.0 if self._pace else self._total, self._pace)
        with self._lock:
            if self._over:
                return
            self._bar = bar
            if self._pace is None:
                bar.update(0, completed=self._done)
            bar.start()


def _rich(label: str, total: float | None, pace: Pace | None) -> Any:
    from rich.console import Console
    from rich.progress import Progress

    class Paced(Progress):
        def get_renderables(self) -> Any:
            if pace is not None:
                # asked for once before there is a task
                for task in self.task_ids:
                    self.update(task, completed=pace.share())
            return super().get_renderables()

    bar = Paced(console=Console(stderr=True), transient=True)
    bar.add_task(label, total=total)
    return bar
