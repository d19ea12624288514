"""Residuals of the mapping over the true value."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from sstl_cli.reporting import palette
from sstl_cli.reporting.drawing import label
from sstl_cli.reporting.figures import predicted
from sstl_cli.reporting.inputs import Inputs
from sstl_cli.reporting.marks import points
from sstl_cli.reporting.rows import Predicted

NEEDS = ("predictions",)


@dataclass(frozen=True)
class Points:
    """True values and residuals (predicted minus true) of one location or variant."""

    true: list[float]
    residual: list[float]


@dataclass(frozen=True)
class Quantity:
    """One parameter of the loop: its points by location (or variant), and their mean residual."""

    groups: dict[str, Points]
    mean: float


@dataclass(frozen=True)
class Quantities:
    """What was predicted, by name."""

    quantities: dict[str, Quantity]


def data(rows: list[Predicted]) -> Quantities:
    """Return the residuals of every quantity."""
    made = {}
    for quantity, found in predicted.data(rows).quantities.items():
        groups = {n: Points(g.true, [b - a for a, b in zip(g.true, g.predicted, strict=True)]) for n, g in found.groups.items()}
        made[quantity] = Quantity(groups, float(np.mean([v for g in groups.values() for v in g.residual])))
    return Quantities(made)


def default(inputs: Inputs, run: str | None) -> Quantities | None:
    """Return the data of all predictions."""
    found = data(inputs.predictions) if run is None else None
    return found if found is not None and found.quantities else None


def figure(data: Quantities) -> tuple[tuple[float, float], tuple[int, int]]:
    """Return size in inch and grid, those of the picture beside it."""
    return predicted.size(len(data.quantities))


def draw(axes: Any, data: Quantities) -> None:
    """Draw one quantity a panel with the line at zero."""
    for panel, (quantity, found) in zip(np.atleast_1d(axes).flat, data.quantities.items(), strict=False):
        for name, group in found.groups.items():
            points(panel, group.true, group.residual, name, list(found.groups))
        panel.axhline(0.0, color=palette.INK, linestyle="--", linewidth=1)
        unit = predicted.unit_of(quantity)
        panel.set_xlabel(label(f"true {quantity} / {unit}"))
        panel.set_ylabel(f"predicted − true / {unit}")
        panel.set_title(f"mean {found.mean:+.3g}".replace("-", "−"), loc="left")
        panel.legend(loc="best")


def alt(data: Quantities) -> str:
    """Describe the picture in words."""
    return "Residuals of the mapping: " + ", ".join(f"{q} mean {f.mean:+.3g}" for q, f in data.quantities.items()) + "."
