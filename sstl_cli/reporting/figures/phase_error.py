"""Tracking error by phase and method."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from sstl_cli.reporting import palette
from sstl_cli.reporting.drawing import label
from sstl_cli.reporting.figures.tracking import ORDER
from sstl_cli.reporting.inputs import PHASE_CODES, CommandView, Inputs

NEEDS = ("command",)


@dataclass(frozen=True)
class Errors:
    """RMSE in N by method and phase."""

    rmse_n: dict[str, dict[str, float]]


def data(views: list[CommandView]) -> Errors:
    """Return the root mean square over the runs that have the phase."""
    methods = sorted({v.method for v in views}, key=lambda m: (ORDER.index(m) if m in ORDER else 99, m))
    found = {}
    for method in methods:
        values = {
            p: [v.rmse_by_phase_n[p] for v in views if v.method == method and v.rmse_by_phase_n[p] == v.rmse_by_phase_n[p]]
            for p in PHASE_CODES
        }
        found[method] = {p: float(np.sqrt(np.mean(np.square(v)))) if v else float("nan") for p, v in values.items()}
    return Errors(found)


def default(inputs: Inputs, run: str | None) -> Errors | None:
    """Return the data of the named run, or of all."""
    views = [v for v in inputs.command if run is None or run in (v.subject, v.run_id)]
    return data(views) if views else None


def figure(data: Errors) -> tuple[tuple[float, float], tuple[int, int]]:
    """Return size in inch and grid."""
    return (4.7, 3.4), (1, 1)


def draw(axes: Any, data: Errors) -> None:
    """Draw one bar a method in each phase."""
    names = list(data.rmse_n)
    width = 0.8 / len(names)
    for k, (name, by_phase) in enumerate(data.rmse_n.items()):
        axes.bar(
            np.arange(4) + (k - (len(names) - 1) / 2) * width,
            [by_phase[p] for p in PHASE_CODES],
            width=0.92 * width,
            color=palette.of(name, palette.METHODS, names),
            label=label(name),
            zorder=2,
        )
    axes.set_xticks(range(4), PHASE_CODES)
    axes.set_ylabel("RMSE of output / N")
    axes.set_xlabel("phase")
    axes.grid(False, axis="x")
    axes.legend(loc="upper left", bbox_to_anchor=(0, -0.17), ncols=4)


def alt(data: Errors) -> str:
    """Describe the picture in words."""
    parts = [f"{m}: " + ", ".join(f"{p} {v:.3g}" for p, v in by.items()) for m, by in data.rmse_n.items()]
    return "Tracking RMSE in N by phase; " + "; ".join(parts) + "."
