"""Time limits that hold on a loaded machine: of the processor, not by the clock, which other work drives too."""

from __future__ import annotations

import os


def spent_s() -> float:
    """Return the processor time (s) of this process and of the children it has waited for."""
    return sum(os.times()[:4])
