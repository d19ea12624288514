"""Training curves: loss over epochs, the range over seeds as a band."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from sstl_cli.reporting import palette
from sstl_cli.reporting.drawing import label
from sstl_cli.reporting.inputs import Inputs
from sstl_cli.reporting.reduce import keep
from sstl_cli.reporting.rows import Epoch, apart

NEEDS = ("history",)
LOSSES = {"train_loss": "-", "val_loss": "--"}
STRETCHES, MOST = 80, 6


@dataclass(frozen=True)
class Curve:
    """Median, lowest and highest value over the seeds by epoch, thinned."""

    epoch: list[int]
    median: list[float]
    low: list[float]
    high: list[float]


@dataclass(frozen=True)
class Histories:
    """The curves by variant and loss."""

    variants: dict[str, dict[str, Curve]]


def data(rows: list[Epoch]) -> Histories:
    """Return the losses of every variant over its seeds."""
    values: dict[str, dict[str, dict[int, list[float]]]] = {}
    for row in rows:
        for loss in LOSSES:
            value: float = getattr(row, loss)
            if value == value:
                values.setdefault(row.variant, {}).setdefault(loss, {}).setdefault(row.epoch, []).append(value)
    made: dict[str, dict[str, Curve]] = {}
    for variant, losses in values.items():
        for loss, found in losses.items():
            epochs = np.array(sorted(found))
            spread = [np.array([f(found[e]) for e in epochs]) for f in (np.median, np.min, np.max)]
            index = keep(spread, STRETCHES)
            made.setdefault(variant, {})[loss] = Curve(epochs[index].tolist(), *(s[index].tolist() for s in spread))
    return Histories(made)


def default(inputs: Inputs, run: str | None) -> Histories | None:
    """Return the data of the history tables."""
    found = data(apart(inputs.history)) if run is None else None
    return found if found is not None and found.variants else None


def figure(data: Histories) -> tuple[tuple[float, float], tuple[int, int]]:
    """Return size in inch and grid."""
    return (8.2, 3.6), (1, 1)


def draw(axes: Any, data: Histories) -> None:
    """Draw median and band of both losses, training solid and validation dashed."""
    names = list(data.variants)[:MOST]
    lowest = []
    for variant in names:
        colour = palette.of(variant, {}, names)
        for loss, curve in data.variants[variant].items():
            axes.plot(curve.epoch, curve.median, LOSSES[loss], color=colour, label=label(f"{variant}, {loss.split('_')[0]}"))
            axes.fill_between(curve.epoch, curve.low, curve.high, color=colour, alpha=0.18, linewidth=0)
            lowest.append(min(curve.low))
    if lowest and min(lowest) > 0:
        axes.set_yscale("log")
        # plain numbers: powers would need formula text, which is off because run names are data
        axes.yaxis.set_major_formatter(lambda value, _: f"{value:g}")
        axes.yaxis.set_minor_formatter(lambda value, _: "")
    axes.set_xlabel("epoch / 1")
    axes.set_ylabel("loss / 1")
    axes.legend(loc="center left", bbox_to_anchor=(1.01, 0.5))


def alt(data: Histories) -> str:
    """Describe the picture in words."""
    parts = [f"{v} {g['val_loss'].median[-1]:.3g}" for v, g in data.variants.items() if "val_loss" in g]
    return "Training curves; last validation loss (median over seeds): " + ", ".join(parts) + "."
