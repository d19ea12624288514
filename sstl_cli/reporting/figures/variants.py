"""Variants of the mapping with the spread over seeds."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from sstl_cli.reporting import palette
from sstl_cli.reporting.documents import number
from sstl_cli.reporting.drawing import label
from sstl_cli.reporting.inputs import Inputs
from sstl_cli.reporting.rows import Evaluated, apart

NEEDS = ("evaluation",)
MEASURES = {
    "rmse_gamma_p": ("Γ pull", palette.BLUE),
    "rmse_gamma_r": ("Γ release", palette.VERMILLION),
    "rmse_total": ("total", palette.GREY),
}


@dataclass(frozen=True)
class Spread:
    """Every seed's value, their mean and standard deviation (None for a single seed)."""

    values: list[float]
    mean: float
    sd: float | None


@dataclass(frozen=True)
class Spreads:
    """The spread by variant (in the order of the table) and measure."""

    variants: dict[str, dict[str, Spread]]


def data(rows: list[Evaluated]) -> Spreads:
    """Return the errors of every variant over its seeds."""
    groups: dict[str, dict[str, list[float]]] = {}
    for row in rows:
        # the row of the mean prediction over all seeds is no seed
        if row.seed is None:
            continue
        group = groups.setdefault(row.variant, {m: [] for m in MEASURES})
        for measure in MEASURES:
            value = number(getattr(row, measure))
            if value == value:
                group[measure].append(value)
    return Spreads({name: {m: _spread(v) for m, v in group.items() if v} for name, group in groups.items()})


def _spread(values: list[float]) -> Spread:
    return Spread(values, float(np.mean(values)), float(np.std(values, ddof=1)) if len(values) > 1 else None)


def default(inputs: Inputs, run: str | None) -> Spreads | None:
    """Return the data of the evaluation table."""
    return data(apart(inputs.evaluation)) if inputs.evaluation and run is None else None


def figure(data: Spreads) -> tuple[tuple[float, float], tuple[int, int]]:
    """Return size in inch and grid."""
    return (8.2, max(2.2, 1.2 + 0.55 * len(data.variants))), (1, 1)


def draw(axes: Any, data: Spreads) -> None:
    """Draw mean and standard deviation a variant, every seed as a small point."""
    for k, (measure, (name, colour)) in enumerate(MEASURES.items()):
        shown = False
        for i, group in enumerate(data.variants.values()):
            if measure not in group:
                continue
            found, place = group[measure], i + 0.24 * (k - 1)
            axes.barh(place, found.mean, height=0.22, color=colour, zorder=2, label=None if shown else name)
            if found.sd is not None:
                axes.plot([found.mean - found.sd, found.mean + found.sd], [place, place], color=palette.INK, linewidth=1.4, zorder=3)
            axes.plot(
                found.values,
                [place] * len(found.values),
                "o",
                color=palette.PAPER,
                markeredgecolor=palette.INK,
                markersize=3,
                markeredgewidth=0.7,
                zorder=4,
            )
            shown = True
    axes.set_yticks(range(len(data.variants)), [label(v) for v in data.variants])
    axes.invert_yaxis()
    axes.set_xlim(left=0)
    axes.set_xlabel("RMSE of slopes / 1 (bar: mean, line: ± one standard deviation over seeds)")
    axes.grid(False, axis="y")
    axes.legend(loc="center left", bbox_to_anchor=(1.01, 0.5))


def alt(data: Spreads) -> str:
    """Describe the picture in words."""
    totals = {v: g["rmse_total"] for v, g in data.variants.items() if "rmse_total" in g}
    parts = [f"{v} {t.mean:.3g}" + ("" if t.sd is None else f" ± {t.sd:.2g}") for v, t in totals.items()]
    return "Total slope RMSE by variant, mean and standard deviation over seeds: " + ", ".join(parts) + "."
