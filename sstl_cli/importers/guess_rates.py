"""A sampling rate, or its period, that stands beside the readings as a single number (``fs``, ``sampleRate``, ``dt_ms``)."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from sstl_cli.core.units import unit_of
from sstl_cli.importers.guess_names import said
from sstl_cli.importers.guess_stamps import Stated

Array = NDArray[np.float64]
_SAMPLED = r"(?:sampl\w*|abtast\w*|acq\w*|daq|mess|logg?\w*|record\w*|echantillonnage|muestreo|campionamento)"
# a frequency alone may be that of the motion
_RATE = re.compile(
    rf"(?:f ?s|s ?r|rate|(?:f|freq\w*|frequenz|rate|tasa|taux)(?: d[ei]| di)? {_SAMPLED}|{_SAMPLED} ?(?:rate|freq\w*|frequenz)|messrate|abtastrate)(?: (k ?)?hz)?"
)
_PERIOD = re.compile(rf"(?:d ?t|t ?s|delta t|time ?step|{_SAMPLED} ?(?:time|period\w*|interval\w*|zeit))(?: (s|sec|ms|us))?")


def named_rate(name: str) -> bool:
    """Return whether a channel's name says that it is a sampling rate or its period.

    Examples
    --------
    >>> [named_rate(n) for n in ("data.Fs", "sampleRate", "dt_ms", "frequency", "fs_out")]
    [True, True, True, False, False]
    """
    return _step(name, 1.0) > 0.0


def rate_held(held: Mapping[str, Array]) -> Stated | None:
    """Return the sampling period of the rate that a file holds as one number, None where it holds none, or several that differ.

    Parameters
    ----------
    held : dict
        Readings of the channels that are named as a rate, shape (n,).
    """
    numbers = {n: float(v[0]) for n, v in held.items() if len(v) and (v == v[0]).all() and math.isfinite(v[0]) and v[0] > 0.0}
    steps = {n: _step(n, value) for n, value in numbers.items()}
    if not steps or max(steps.values()) > 1.001 * min(steps.values()):
        return None
    name = next(iter(steps))
    return Stated(steps[name], f"'{name}' is {numbers[name]:g}")


def _step(name: str, value: float) -> float:
    """Return the sampling period (s) that a number under a name tells, 0 where the name says no such thing."""
    spoken = " ".join(said(re.split(r"[./]", name)[-1]).words)
    if rate := _RATE.fullmatch(spoken):
        return 1.0 / (value * (1e3 if rate[1] else 1.0))
    period = _PERIOD.fullmatch(spoken)
    unit = {"sec": "s"}.get(period[1], period[1]) if period and period[1] else "s"
    return value * unit_of(unit)[1] if period else 0.0
