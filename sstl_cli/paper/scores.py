"""From tracking scores to the entries of Table IV, of Section V-C and of the abstract."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from sstl_cli.control.scoring import Score, reduction_pct
from sstl_cli.paper.settings import LOCATIONS, METHODS, TRAJECTORIES

Key = tuple[str, str, str]
#: trajectory, method, location
Cell = tuple[str, str, str]


def tracking_entries(scores: Mapping[Cell, Score]) -> dict[Key, float]:
    """Return every entry that scores by trajectory, method and location give (N and %)."""
    found: dict[Key, float] = {}
    for (trajectory, method, place), s in scores.items():
        row = f"{trajectory} {method}"
        found["IV", row, f"rmse_{place}"], found["IV", row, f"std_{place}"] = s.rmse_n, s.std_n
        if s.mape_pct is not None:
            found["IV", row, f"mape_{place}"] = s.mape_pct
        baseline = scores.get((trajectory, "none", place))
        reduction = reduction_pct(s.rmse_n, baseline.rmse_n) if baseline is not None and method != "none" else None
        if reduction is not None:
            found["IV", row, f"red_{place}"] = reduction
    found.update(_means(found))
    found.update(_headline(found))
    return found


def _means(found: Mapping[Key, float]) -> dict[Key, float]:
    """Return the means over the locations, and the share of direct identification's reduction (Section V-C)."""
    means: dict[Key, float] = {}
    for trajectory in TRAJECTORIES:
        for method in METHODS:
            row = f"{trajectory} {method}"
            for measure in ("rmse", "red"):
                values = [found[k] for k in (("IV", row, f"{measure}_{p}") for p in LOCATIONS) if k in found]
                if len(values) == len(LOCATIONS):
                    means["summary", row, measure] = float(np.mean(values))
        whole, ideal = (means.get(("summary", f"{trajectory} {m}", "red")) for m in ("proposed", "DI"))
        if whole is not None and ideal:
            means["summary", f"{trajectory} proposed", "recovery"] = 100.0 * whole / ideal
    return means


def _headline(found: Mapping[Key, float]) -> dict[Key, float]:
    """Return the abstract's two numbers: means over both trajectories."""
    done: dict[Key, float] = {}
    for measure in ("red", "recovery"):
        values = [found.get(("summary", f"{t} proposed", measure)) for t in TRAJECTORIES]
        if all(v is not None for v in values):
            done["headline", "proposed", measure] = float(np.mean([v for v in values if v is not None]))
    return done


def distance(ours: Mapping[Key, float], other: Mapping[Key, float]) -> float:
    """Return how far one Table IV lies from another: root mean square difference (N) over every RMSE and STD."""
    off = [ours[k] - v for k, v in other.items() if k in ours and k[0] == "IV" and k[2].startswith(("rmse", "std"))]
    return float(np.sqrt(np.mean(np.square(off))))
