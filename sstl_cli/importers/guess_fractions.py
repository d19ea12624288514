"""A clock in two columns: whole seconds, and the parts of a second (``sec`` and ``nanosec`` of a ROS stamp)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sstl_cli.core.units import unit_of
from sstl_cli.importers.guess_names import Said
from sstl_cli.importers.guess_words import words

Array = NDArray[np.float64]
# words for the column that holds the parts of a second, by their unit
PARTS = {
    "ns": words("nanosec nanosecs nanosecond nanoseconds nsec nsecs nanos ns"),
    "us": words("microsec usec usecs micros microseconds us"),
    "ms": words("millisec millisecs millisecond milliseconds msec msecs millis ms"),
}
# of the steps, how many may stand still: two samples of one moment
STILL = 0.01


@dataclass(frozen=True)
class Parts:
    """The channel that tells the parts of a second, and their unit."""

    name: str
    unit: str

    @property
    def size_s(self) -> float:
        """Length of one part (s)."""
        return unit_of(self.unit)[1]


def sums(names: Sequence[Said], data: dict[str, Array]) -> tuple[dict[str, Array], dict[str, Parts]]:
    """Return the readings with each clock of whole seconds as the sum with its parts, and these parts by the clock's name."""
    parts = {s.name: p for s in names if s.quantity == "time" and s.name in data and (p := in_parts(s, names, data)) is not None}
    return {**data, **{n: data[n] + p.size_s * data[p.name] for n, p in parts.items()}}, parts


def in_parts(best: Said, names: Sequence[Said], data: dict[str, Array], named: bool = True) -> Parts | None:
    """Return the channel with the parts of a clock of whole seconds, None where it is no such clock or none has them.

    Parameters
    ----------
    named : bool
        Whether a word of the name must say so; else nanoseconds are told by their values alone, behind the seconds.
    """
    seconds = data[best.name]
    if not len(seconds) or np.mean(np.diff(seconds) == 0) <= 0.5 or not np.all(seconds == np.round(seconds)):
        return None
    place = list(names).index(best)
    # of several stamps in one table each has its parts beside it
    nearest = sorted(names, key=lambda s: abs(list(names).index(s) - place))
    for one in nearest if named else names[place + 1 : place + 2]:
        unit = next((u for u, known in PARTS.items() if known.intersection(one.words) or (u == one.unit and not one.words)), "")
        unit = unit if named else "ns"
        values = data.get(one.name, np.empty(0))
        if not unit or one is best or len(values) != len(seconds) or not (values >= 0).all() or (unit_of(unit)[1] * values >= 1).any():
            continue
        steps = np.diff(seconds) + unit_of(unit)[1] * np.diff(values)
        # they begin anew where the seconds go on
        if (steps >= 0).all() and np.mean(steps == 0) <= STILL:
            return Parts(one.name, unit)
    return None
