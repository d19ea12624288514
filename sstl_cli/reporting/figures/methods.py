"""Scores of the methods: RMSE over all runs of a score table."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from sstl_cli.core.documents.control import ScoreRow
from sstl_cli.reporting import palette
from sstl_cli.reporting.documents import number
from sstl_cli.reporting.drawing import label
from sstl_cli.reporting.figures.tracking import ORDER
from sstl_cli.reporting.inputs import Inputs

NEEDS = ("score",)


@dataclass(frozen=True)
class Method:
    """RMSE in N of every run under one method, and their mean."""

    rmse_n: list[float]
    mean_n: float


@dataclass(frozen=True)
class Windows:
    """The methods by window, in the order in which they are known."""

    windows: dict[str, dict[str, Method]]


def data(rows: list[ScoreRow]) -> Windows:
    """Return the errors by window and method."""
    groups: dict[str, dict[str, list[float]]] = {}
    for row in rows:
        value = number(row.rmse_n)
        if value == value:
            groups.setdefault(row.window, {}).setdefault(row.method, []).append(value)
    return Windows(
        {
            w: {
                m: Method(found[m], float(np.mean(found[m])))
                for m in sorted(found, key=lambda m: (ORDER.index(m) if m in ORDER else 99, m))
            }
            for w, found in sorted(groups.items())
        }
    )


def default(inputs: Inputs, run: str | None) -> Windows | None:
    """Return the data of the named run, or of all."""
    found = data([r for r in inputs.score if run is None or r.run_id == run])
    return found if found.windows else None


def figure(data: Windows) -> tuple[tuple[float, float], tuple[int, int]]:
    """Return size in inch and grid."""
    return (4.7, 3.4), (1, 1)


def draw(axes: Any, data: Windows) -> None:
    """Draw the mean as a bar and every run as a point, windows beside each other."""
    ticks: list[tuple[float, str]] = []
    seen: set[str] = set()
    names = [m for found in data.windows.values() for m in found]
    place = 0.0
    for window, found in data.windows.items():
        start = place
        for name, values in found.items():
            axes.bar(
                place,
                values.mean_n,
                width=0.85,
                color=palette.of(name, palette.METHODS, names),
                zorder=2,
                label=None if name in seen else label(name),
            )
            if len(values.rmse_n) > 1:
                axes.plot(
                    [place] * len(values.rmse_n),
                    values.rmse_n,
                    "o",
                    color=palette.PAPER,
                    markeredgecolor=palette.INK,
                    markersize=3,
                    markeredgewidth=0.7,
                    zorder=3,
                )
            seen.add(name)
            place += 1
        ticks.append(((start + place - 1) / 2, label(window, 24)))
        place += 0.6
    axes.set_xticks([t for t, _ in ticks], [w for _, w in ticks])
    axes.set_xlabel("scoring window")
    axes.set_ylabel("RMSE of output / N")
    axes.grid(False, axis="x")
    axes.legend(loc="upper left", bbox_to_anchor=(0, -0.17), ncols=4)


def alt(data: Windows) -> str:
    """Describe the picture in words."""
    parts = [f"{w}: " + ", ".join(f"{m} {v.mean_n:.3g}" for m, v in found.items()) for w, found in data.windows.items()]
    return "Mean tracking RMSE in N by method; " + "; ".join(parts) + "."
