"""Predicted against realised shrinkage of the gap in the blind check."""

from __future__ import annotations

from typing import Any

import numpy as np

from sstl_cli.reporting import palette
from sstl_cli.reporting.documents import number, rows
from sstl_cli.reporting.inputs import Inputs

NEEDS = ("blind",)


def data(document: dict[str, Any]) -> dict[str, Any]:
    """Return predicted and realised shrinkage in % and the mean absolute difference in percentage points."""
    pairs = [(number(r.get("predicted_pct")), number(r.get("realised_pct"))) for r in rows(document, "shrink")]
    pairs = [(a, b) for a, b in pairs if a == a and b == b]
    off = float(np.mean([abs(a - b) for a, b in pairs])) if pairs else float("nan")
    return {"predicted_pct": [a for a, _ in pairs], "realised_pct": [b for _, b in pairs], "off_pct": off}


def default(inputs: Inputs, run: str | None) -> dict[str, Any] | None:
    """Return the data of the first blind result."""
    found = data(inputs.blind[0]) if inputs.blind and run is None else {"predicted_pct": []}
    return found if found["predicted_pct"] else None


def figure(data: dict[str, Any]) -> tuple[tuple[float, float], tuple[int, int]]:
    """Return size in inch and grid."""
    return (4.6, 3.7), (1, 1)


def draw(axes: Any, data: dict[str, Any]) -> None:
    """Draw a point a case with the line of equality."""
    both = data["predicted_pct"] + data["realised_pct"]
    low, high = min([0.0, *both]), max([100.0, *both])
    axes.plot([low, high], [low, high], color=palette.INK, linestyle="--", linewidth=1, label="equal")
    axes.plot(data["predicted_pct"], data["realised_pct"], "o", color=palette.BLUE, markersize=4.5, label="case")
    axes.set_xlabel("predicted shrinkage of the gap / %")
    axes.set_ylabel("realised shrinkage / %")
    axes.set_title(f"mean difference {data['off_pct']:.1f} percentage points", loc="left")
    axes.legend(loc="upper left")


def alt(data: dict[str, Any]) -> str:
    """Describe the picture in words."""
    return (
        f"Predicted against realised shrinkage of {len(data['predicted_pct'])} cases; mean absolute difference "
        f"{data['off_pct']:.1f} percentage points."
    )
