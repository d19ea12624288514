"""How long each part of a reproduction takes, so that its progress moves evenly; imports nothing heavy."""

from __future__ import annotations

from collections.abc import Collection
from itertools import accumulate

#: seconds, as measured on two busy cores (idle ones take a third; "withheld" from its ten minutes there); only how they compare matters
LOADING_S = 8.0
EACH_S = {"I": 9.0, "III seed": 8.0, "III beside": 36.0, "IV": 13.0, "gap": 73.0, "R seed": 170.0, "diagnosis": 119.0, "withheld": 1500.0}
EACH_S |= {"tendons": 34.0, "calibration": 156.0, "better": 63.0, "probe": 240.0, "distal": 16.0}
#: the tables beyond the paper that begin with a calibration of the rig
CALIBRATED = frozenset({"better", "probe", "distal"})
#: the share of Table III that its training tells step by step
TRAINING = 0.5


def parts(tables: Collection[str], seeds: int, data_seeds: int, workers: int) -> dict[str, float]:
    """Return the parts of a reproduction in their order, with the seconds that each takes.

    Parameters
    ----------
    seeds, data_seeds : int
        Training seeds of Table III, data seeds of block R.
    workers : int
        Processes: block R is computed beside the parts before it where there are two.

    Examples
    --------
    >>> list(parts(("I", "R"), 5, 3, 1)), list(parts(("IV",), 5, 3, 2))
    (['I', 'R'], ['I', 'III', 'IV', 'gap'])
    """
    asked = set(tables)
    tracks = bool({"IV", "figures"} & asked)
    found: dict[str, float] = {}
    if tracks or {"I", "II"} & asked:
        found["I"] = EACH_S["I"]
    if tracks or "III" in asked:
        found["III"] = EACH_S["III beside"] + seeds * EACH_S["III seed"]
    if tracks:
        found["IV"] = EACH_S["IV"]
    if "IV" in asked:
        found["gap"] = EACH_S["gap"]
    beside, alone = min(workers - 1, data_seeds), data_seeds * EACH_S["R seed"]
    if "R" in asked and beside < 1:
        found["R"] = alone
    for name in ("diagnosis", "withheld"):
        if name in asked:
            found[name] = EACH_S[name]
    if "R" in asked and beside >= 1:
        rest = max(alone / beside - sum(found.values()), 1.0)
        # the diagnosis asks for a table of block R at its end, and waits for it
        if "diagnosis" in found:
            found["diagnosis"] += rest
        found["R"] = 1.0 if "diagnosis" in found else rest
    if "tendons" in asked:
        found["tendons"] = EACH_S["tendons"]
    if CALIBRATED & asked:
        found["calibration"] = EACH_S["calibration"]
    return found | {name: EACH_S[name] for name in ("better", "probe", "distal") if name in asked}


def curve(seconds: dict[str, float]) -> list[tuple[float, float]]:
    """Return which share of the parts is done after which share of the time, at the end of each part; loading comes first.

    Examples
    --------
    >>> curve({"I": 8.0, "gap": 16.0})
    [(0.0, 0.25), (0.3333333333333333, 0.5), (1.0, 1.0)]
    """
    whole = sum(seconds.values())
    ends = [0.0, *accumulate(seconds.values())]
    return [(end / whole, (LOADING_S + end) / (LOADING_S + whole)) for end in ends]
