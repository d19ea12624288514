"""Theta: the loop parameters over lead and location, the two-pass rule, and the slope product."""

from __future__ import annotations

from sstl_cli.core.tables import THETA
from sstl_cli.reporting import drawing
from sstl_cli.reporting.figures import product, squared, theta
from sstl_cli.reporting.inputs import Inputs
from sstl_cli.reporting.table import table

TITLE, ORDER, NEEDS = "Theta", 30, ("theta",)


def context(inputs: Inputs) -> dict[str, object]:
    """Return the three pictures that can be drawn and the table of all parameters."""
    pictures = [
        drawing.picture(module, found, name, caption)
        for module, name, caption in (
            (theta, "theta", "Parameters of the propagation lines; bars are one standard error. Filled: act, open: sstl."),
            (squared, "squared", "Two passes against one pass twice: points on the line follow the capstan rule."),
            (product, "product", "The product is 1 for friction that is linear in tension and equal in both directions."),
        )
        if (found := module.default(inputs, None)) is not None
    ]
    header = [(c.name, c.unit) for c in THETA.columns]
    rows = ([getattr(row, c.name) for c in THETA.columns] for row in inputs.theta)
    aside = sum(row.status != "ok" for row in inputs.theta)
    return {"pictures": pictures, "table": table("Parameters", header, rows), "rows": len(inputs.theta), "aside": aside}
