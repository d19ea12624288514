"""Predicted against true slopes of the mapping."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from sstl_cli.reporting import palette
from sstl_cli.reporting.drawing import label
from sstl_cli.reporting.inputs import Inputs
from sstl_cli.reporting.marks import points
from sstl_cli.reporting.rows import Predicted

NEEDS = ("predictions",)


@dataclass(frozen=True)
class Points:
    """True and predicted values of one location or variant."""

    true: list[float]
    predicted: list[float]


@dataclass(frozen=True)
class Quantity:
    """One parameter of the loop: its points by location (or variant), their RMSE and number."""

    groups: dict[str, Points]
    rmse: float
    n: int


@dataclass(frozen=True)
class Quantities:
    """What was predicted, by name."""

    quantities: dict[str, Quantity]


def data(rows: list[Predicted]) -> Quantities:
    """Return the points of every quantity."""
    found: dict[str, dict[str, Points]] = {}
    for row in rows:
        group = found.setdefault(row.quantity, {}).setdefault(row.group, Points([], []))
        group.true.append(row.true)
        group.predicted.append(row.predicted)
    made = {}
    for quantity, groups in sorted(found.items()):
        error = [b - a for g in groups.values() for a, b in zip(g.true, g.predicted, strict=True)]
        made[quantity] = Quantity(dict(sorted(groups.items())), float(np.sqrt(np.mean(np.square(error)))), len(error))
    return Quantities(made)


def default(inputs: Inputs, run: str | None) -> Quantities | None:
    """Return the data of all predictions."""
    found = data(inputs.predictions) if run is None else None
    return found if found is not None and found.quantities else None


def figure(data: Quantities) -> tuple[tuple[float, float], tuple[int, int]]:
    """Return size in inch and grid."""
    return size(len(data.quantities))


def size(n: int) -> tuple[tuple[float, float], tuple[int, int]]:
    """Return size in inch and grid of ``n`` panels."""
    return (4.8 * min(n, 2), 3.5 * ((n + 1) // 2)), ((n + 1) // 2, min(n, 2))


def draw(axes: Any, data: Quantities) -> None:
    """Draw one quantity a panel with the line of equality."""
    for panel, (quantity, found) in zip(np.atleast_1d(axes).flat, data.quantities.items(), strict=False):
        for name, group in found.groups.items():
            points(panel, group.true, group.predicted, name, list(found.groups))
        both = [v for g in found.groups.values() for v in (*g.true, *g.predicted)]
        panel.plot([min(both), max(both)], [min(both), max(both)], color=palette.INK, linestyle="--", linewidth=1, label="equal")
        unit = unit_of(quantity)
        panel.set_xlabel(label(f"true {quantity} / {unit}"))
        panel.set_ylabel(label(f"predicted {quantity} / {unit}"))
        panel.set_title(f"RMSE {found.rmse:.3g}, n = {found.n}", loc="left")
        panel.legend(loc="best")


def alt(data: Quantities) -> str:
    """Describe the picture in words."""
    parts = [f"{q} RMSE {f.rmse:.3g} over {f.n}" for q, f in data.quantities.items()]
    return "Predicted against true: " + ", ".join(parts) + "."


def unit_of(quantity: str) -> str:
    """Return the unit of a loop parameter: N for biases, 1 for slopes."""
    return "N" if "beta" in quantity else "1"
