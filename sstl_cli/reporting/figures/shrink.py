"""Predicted against realised shrinkage of the gap in the blind check."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from sstl_cli.reporting import palette
from sstl_cli.reporting.inputs import Inputs
from sstl_cli.reporting.scored import Scored

NEEDS = ("blind",)


@dataclass(frozen=True)
class Shrinkage:
    """Predicted and realised shrinkage in %, and their mean absolute difference in percentage points."""

    predicted_pct: list[float]
    realised_pct: list[float]
    off_pct: float


def data(document: Scored) -> Shrinkage:
    """Return the cases that have both."""
    pairs = [(s.predicted_pct, s.realised_pct) for s in document.shrink]
    pairs = [(a, b) for a, b in pairs if a == a and b == b]
    off = float(np.mean([abs(a - b) for a, b in pairs])) if pairs else float("nan")
    return Shrinkage([a for a, _ in pairs], [b for _, b in pairs], off)


def default(inputs: Inputs, run: str | None) -> Shrinkage | None:
    """Return the data of the first blind result."""
    found = data(inputs.blind[0]) if inputs.blind and run is None else None
    return found if found is not None and found.predicted_pct else None


def figure(data: Shrinkage) -> tuple[tuple[float, float], tuple[int, int]]:
    """Return size in inch and grid."""
    return (4.6, 3.7), (1, 1)


def draw(axes: Any, data: Shrinkage) -> None:
    """Draw a point a case with the line of equality."""
    both = data.predicted_pct + data.realised_pct
    low, high = min([0.0, *both]), max([100.0, *both])
    axes.plot([low, high], [low, high], color=palette.INK, linestyle="--", linewidth=1, label="equal")
    axes.plot(data.predicted_pct, data.realised_pct, "o", color=palette.BLUE, markersize=4.5, label="case")
    axes.set_xlabel("predicted shrinkage of the gap / %")
    axes.set_ylabel("realised shrinkage / %")
    axes.set_title(f"mean difference {data.off_pct:.1f} percentage points", loc="left")
    axes.legend(loc="upper left")


def alt(data: Shrinkage) -> str:
    """Describe the picture in words."""
    return (
        f"Predicted against realised shrinkage of {len(data.predicted_pct)} cases; mean absolute difference "
        f"{data.off_pct:.1f} percentage points."
    )
