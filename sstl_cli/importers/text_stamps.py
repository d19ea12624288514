"""Times written as text in a column of a text log, read as seconds: they are a clock like numbers."""

from __future__ import annotations

from collections.abc import Iterable
from datetime import UTC, date, datetime

import numpy as np
from numpy.typing import NDArray

from sstl_cli.importers.guess_stamps import CLOCK, DAY_S, HOUR_S, MINUTES, date_orders, of_day
from sstl_cli.importers.stamp_words import in_numbers

Array = NDArray[np.float64]
_EPOCH = date(1970, 1, 1).toordinal()


class StampReader:
    """Reads stamps of one form in the order of a file: seconds since 1970 where they hold a date, else of the day or since the start."""

    def __init__(self) -> None:
        self._orders: list[tuple[int, int, int]] | None = None
        self._first: tuple[str, ...] = ()
        self._base = 0.0
        self._day, self._last = 0.0, -np.inf
        self._days: dict[tuple[str, ...], float] = {}

    def seconds(self, cells: Iterable[str]) -> Array:
        """Return the times (s) of cells, NaN for empty ones, shape (n,).

        Raises
        ------
        ValueError
            With the cell, if one is no time or no date that exists.
        """
        return np.array([self._one(c.strip()) for c in cells], np.float64)

    def _one(self, cell: str) -> float:
        if not cell:
            return np.nan
        # other ways to write it are looked for only where this one is not
        if m := CLOCK.fullmatch(cell) or CLOCK.fullmatch(in_numbers(cell)):
            return self._of_date((m[1], m[3], m[4]), m[2]) + of_day(m) if m[1] else self._running(of_day(m))
        if m := MINUTES.fullmatch(cell):
            return self._running(60.0 * int(m[1]) + float(m[2].replace(",", ".")), HOUR_S)
        try:
            stamp = datetime.fromisoformat(cell if "-" in cell or "T" in cell else "-")
        except ValueError:
            raise ValueError(cell) from None
        return (stamp if stamp.tzinfo else stamp.replace(tzinfo=UTC)).timestamp()

    def _running(self, seconds: float, period: float = DAY_S) -> float:
        """Return a time of day as it runs on over midnight, or minutes and seconds over the hour."""
        if seconds + self._day < self._last - period / 2:
            self._day += period
        self._last = seconds + self._day
        return self._last

    def _of_date(self, parts: tuple[str, ...], mark: str) -> float:
        """Return the seconds of a date; where the order of its numbers does not show, days are those that lie nearest together."""
        if parts in self._days:
            return self._days[parts]
        fits = [o for o in self._orders or date_orders(parts, mark) if _ordinal(parts, o) is not None]
        if not fits:
            raise ValueError("/".join(parts))
        if not self._first:
            self._first, self._base = parts, DAY_S * (_day(parts, fits[0]) - _EPOCH)
        elif len(fits) > 1:
            fits = [min(fits, key=lambda o: abs(_day(parts, o) - _day(self._first, o)))]
        self._orders = fits
        self._days[parts] = self._base + DAY_S * (_day(parts, fits[0]) - _day(self._first, fits[0]))
        return self._days[parts]


def are_stamps(cells: Iterable[str]) -> bool:
    """Return whether cells are times written as text that a reader reads.

    Examples
    --------
    >>> are_stamps(["10:22:33.123", "10:22:33.143"]), are_stamps(["2.03", "2.04"])
    (True, False)
    """
    try:
        return bool(np.isfinite(StampReader().seconds(cells)).any())
    except ValueError:
        return False


def _ordinal(parts: tuple[str, ...], order: tuple[int, int, int]) -> int | None:
    year, month, day = (int(parts[i]) for i in order)
    try:
        return date(year + 2000 if year < 100 else year, month, day).toordinal()
    except ValueError:
        return None


def _day(parts: tuple[str, ...], order: tuple[int, int, int]) -> int:
    found = _ordinal(parts, order)
    if found is None:
        raise ValueError("/".join(parts))
    return found
