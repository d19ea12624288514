"""Where the axes of a figure lie, so that the page can turn a place under the pointer into values."""

from __future__ import annotations

import json
from typing import Any

from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, NullLocator

POINTS_PER_INCH = 72.0


def scales(figure: Figure) -> str:
    """Return the numeric axes of a figure that was drawn, as JSON; '' where none has numbers on an axis.

    Each entry has ``box``: left, top, right, bottom in points from the top left corner, and for ``x`` and ``y`` the
    label, the values at both ends, and whether the scale is logarithmic (null for names and other scales).
    """
    width, height = (float(s) * POINTS_PER_INCH for s in figure.get_size_inches())
    found = []
    for axes in figure.axes:
        x = _scale(axes.xaxis, axes.get_xlim(), figure.get_supxlabel())
        y = _scale(axes.yaxis, axes.get_ylim(), figure.get_supylabel())
        if not axes.axison or (x is None and y is None):
            continue
        at = axes.get_position()
        box = [at.x0 * width, (1 - at.y1) * height, at.x1 * width, (1 - at.y0) * height]
        found.append({"box": [round(b, 1) for b in box], "x": x, "y": y})
    return json.dumps(found, separators=(",", ":"), ensure_ascii=False) if found else ""


def _scale(axis: Any, limits: tuple[float, float], shared: str) -> dict[str, object] | None:
    named = isinstance(axis.get_major_locator(), (FixedLocator, NullLocator))
    if named or axis.get_scale() not in ("linear", "log"):
        return None
    label = axis.get_label().get_text() or shared
    low, high = (float(f"{v:.6g}") for v in limits)
    return {"label": label, "from": low, "to": high, "log": axis.get_scale() == "log"}
