"""Residuals of the mapping over the true value."""

from __future__ import annotations

from typing import Any

import numpy as np

from sstl_cli.reporting import palette
from sstl_cli.reporting.drawing import label
from sstl_cli.reporting.figures import predicted
from sstl_cli.reporting.inputs import Inputs

NEEDS = ("predictions",)


def data(rows: list[dict[str, Any]]) -> dict[str, Any]:
    """Return true value and residual (predicted minus true) by quantity and location, and the mean residual."""
    made = {}
    for quantity, found in predicted.data(rows)["quantities"].items():
        groups = {
            n: {"true": g["true"], "residual": [b - a for a, b in zip(g["true"], g["predicted"], strict=True)]}
            for n, g in found["groups"].items()
        }
        made[quantity] = {"groups": groups, "mean": float(np.mean([v for g in groups.values() for v in g["residual"]]))}
    return {"quantities": made}


def default(inputs: Inputs, run: str | None) -> dict[str, Any] | None:
    """Return the data of all predictions."""
    found = data(inputs.predictions) if run is None else {"quantities": {}}
    return found if found["quantities"] else None


figure = predicted.figure


def draw(axes: Any, data: dict[str, Any]) -> None:
    """Draw one quantity a panel with the line at zero."""
    for panel, (quantity, found) in zip(np.atleast_1d(axes).flat, data["quantities"].items(), strict=False):
        for name, group in found["groups"].items():
            panel.plot(
                group["true"],
                group["residual"],
                "o",
                markersize=4,
                label=label(name),
                color=palette.of(name, palette.LOCATIONS, list(found["groups"])),
            )
        panel.axhline(0.0, color=palette.INK, linestyle="--", linewidth=1)
        unit = predicted.unit_of(quantity)
        panel.set_xlabel(label(f"true {quantity} / {unit}"))
        panel.set_ylabel(f"predicted − true / {unit}")
        panel.set_title(f"mean {found['mean']:+.3g}".replace("-", "−"), loc="left")
        panel.legend(loc="best")


def alt(data: dict[str, Any]) -> str:
    """Describe the picture in words."""
    return "Residuals of the mapping: " + ", ".join(f"{q} mean {f['mean']:+.3g}" for q, f in data["quantities"].items()) + "."
