"""Product of pull and release slope: one for any friction law that is linear and equal in both directions."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from sstl_cli.core.documents.mapping import ThetaRow
from sstl_cli.reporting import palette
from sstl_cli.reporting.documents import number
from sstl_cli.reporting.inputs import Inputs
from sstl_cli.reporting.marks import with_errors

NEEDS = ("theta",)


@dataclass(frozen=True)
class Product:
    """Lead in mm (place in the file where null), slope product and its standard error."""

    x: list[float]
    product: list[float]
    se: list[float]


@dataclass(frozen=True)
class Products:
    """The products by system and location; ``by_lead`` where any lead is known."""

    series: dict[tuple[str, str], Product]
    by_lead: bool


def data(rows: list[ThetaRow]) -> Products:
    """Return the products with their errors by propagation."""
    leads = [number(r.lead_mm) for r in rows]
    by_lead = any(v == v for v in leads)
    series: dict[tuple[str, str], Product] = {}
    for place, row in enumerate(rows):
        p, r, se_p, se_r = (number(v) for v in (row.gamma_p, row.gamma_r, row.gamma_p_se, row.gamma_r_se))
        x = leads[place] if by_lead else float(place)
        if p * r != p * r or x != x:
            continue
        group = series.setdefault((row.system, row.location or "–"), Product([], [], []))
        group.x.append(x)
        group.product.append(p * r)
        group.se.append(float(np.hypot(r * se_p, p * se_r)))
    return Products(dict(sorted(series.items())), by_lead)


def default(inputs: Inputs, run: str | None) -> Products | None:
    """Return the data of all rows."""
    found = data(inputs.theta) if run is None else None
    return found if found is not None and found.series else None


def figure(data: Products) -> tuple[tuple[float, float], tuple[int, int]]:
    """Return size in inch and grid."""
    return (8.2, 3.3), (1, 1)


def draw(axes: Any, data: Products) -> None:
    """Draw the product over lead with the line at one."""
    locations = sorted({location for _, location in data.series})
    for place, group in data.series.items():
        with_errors(axes, group.x, group.product, group.se, place, locations)
    axes.axhline(1.0, color=palette.INK, linewidth=1, linestyle="--")
    axes.set_xlabel("lead-screw displacement / mm" if data.by_lead else "row in file / 1")
    axes.set_ylabel("Γ pull · Γ release / 1")
    axes.legend(loc="center left", bbox_to_anchor=(1.01, 0.5))


def alt(data: Products) -> str:
    """Describe the picture in words, with the mean product a system."""
    systems = sorted({s for s, _ in data.series})
    means = [np.mean([v for (s, _), g in data.series.items() if s == system for v in g.product]) for system in systems]
    return "Slope product over lead; mean " + ", ".join(f"{s} {m:.3f}" for s, m in zip(systems, means, strict=True)) + "."
