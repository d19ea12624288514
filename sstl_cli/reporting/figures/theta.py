"""The four loop parameters over lead and location, with error bars."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from sstl_cli.core.documents.mapping import ThetaRow
from sstl_cli.core.tables import PARAMETERS
from sstl_cli.reporting.documents import number
from sstl_cli.reporting.inputs import Inputs
from sstl_cli.reporting.marks import with_errors

NEEDS = ("theta",)
SYMBOLS = {"gamma_p": "Γ pull / 1", "gamma_r": "Γ release / 1", "beta_p": "β pull / N", "beta_r": "β release / N"}


@dataclass(frozen=True)
class Parameters:
    """Lead in mm (place in the file where null), every parameter and its standard error by name."""

    x: list[float] = field(default_factory=list)
    values: dict[str, list[float]] = field(default_factory=lambda: {p: [] for p in PARAMETERS})
    errors: dict[str, list[float]] = field(default_factory=lambda: {p: [] for p in PARAMETERS})


@dataclass(frozen=True)
class Series:
    """The parameters by system and location; ``by_lead`` where any lead is known."""

    series: dict[tuple[str, str], Parameters]
    by_lead: bool


def data(rows: list[ThetaRow]) -> Series:
    """Return the parameters of every run that has a place."""
    leads = [number(r.lead_mm) for r in rows]
    by_lead = any(v == v for v in leads)
    series: dict[tuple[str, str], Parameters] = {}
    for place, row in enumerate(rows):
        x = leads[place] if by_lead else float(place)
        if x != x:
            continue
        group = series.setdefault((row.system, row.location or "–"), Parameters())
        group.x.append(x)
        for p in PARAMETERS:
            group.values[p].append(number(getattr(row, p)))
            group.errors[p].append(number(getattr(row, p + "_se")))
    return Series(dict(sorted(series.items())), by_lead)


def default(inputs: Inputs, run: str | None) -> Series | None:
    """Return the data of all rows."""
    return data(inputs.theta) if inputs.theta and run is None else None


def figure(data: Series) -> tuple[tuple[float, float], tuple[int, int]]:
    """Return size in inch and grid."""
    return (8.2, 6.0), (2, 2)


def draw(axes: Any, data: Series) -> None:
    """Draw one parameter a panel; error bars are one standard error."""
    locations = sorted({location for _, location in data.series})
    for panel, p in zip(axes.flat, ("gamma_p", "gamma_r", "beta_p", "beta_r"), strict=True):
        for place, group in data.series.items():
            with_errors(panel, group.x, group.values[p], group.errors[p], place, locations)
        panel.set_ylabel(SYMBOLS[p])
        panel.set_xlabel("lead-screw displacement / mm" if data.by_lead else "row in file / 1")
    handles, names = axes[0, 0].get_legend_handles_labels()
    axes[0, 0].figure.legend(handles, names, loc="outside lower center", ncols=min(len(names), 6))


def alt(data: Series) -> str:
    """Describe the picture in words."""
    n = sum(len(g.x) for g in data.series.values())
    names = ", ".join(f"{s} {location}" for s, location in data.series)
    return f"Slopes and biases of pull and release lines of {n} runs with standard errors, for {names}."
