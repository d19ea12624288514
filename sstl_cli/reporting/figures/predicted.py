"""Predicted against true slopes of the mapping."""

from __future__ import annotations

from typing import Any

import numpy as np

from sstl_cli.reporting import palette
from sstl_cli.reporting.documents import number
from sstl_cli.reporting.drawing import label
from sstl_cli.reporting.inputs import Inputs

NEEDS = ("predictions",)
_PREDICTED, _TRUE = ("pred", "predicted", "hat"), ("true", "target", "measured")


def columns(rows: list[dict[str, Any]]) -> dict[str, tuple[str, str]]:
    """Return quantity -> (true column, predicted column) by their names.

    Both ``gamma_p_true``/``gamma_p_pred`` and ``true_gamma_p``/``pred_gamma_p`` are understood; where there is
    no such true column, ``gamma_p`` itself is the truth of ``gamma_p_pred``.
    """
    names = list(rows[0]) if rows else []
    found = {}
    for name in names:
        for word in _PREDICTED:
            for base, form in ((name.removesuffix("_" + word), "{0}_{1}"), (name.removeprefix(word + "_"), "{1}_{0}")):
                if base == name:
                    continue
                truth = next((t for t in [form.format(base, w) for w in _TRUE] if t in names), base if base in names else None)
                if truth is not None:
                    found[base] = (truth, name)
    return dict(sorted(found.items()))


def data(rows: list[dict[str, Any]]) -> dict[str, Any]:
    """Return true and predicted values by quantity and location (or variant), and the RMSE of each quantity."""
    made: dict[str, Any] = {}
    for quantity, (truth, guess) in columns(rows).items():
        groups: dict[str, dict[str, list[float]]] = {}
        for row in rows:
            x, y = number(row.get(truth)), number(row.get(guess))
            if x == x and y == y:
                group = groups.setdefault(str(row.get("location") or row.get("variant") or "all"), {"true": [], "predicted": []})
                group["true"].append(x)
                group["predicted"].append(y)
        error = [b - a for g in groups.values() for a, b in zip(g["true"], g["predicted"], strict=True)]
        if error:
            made[quantity] = {"groups": dict(sorted(groups.items())), "rmse": float(np.sqrt(np.mean(np.square(error)))), "n": len(error)}
    return {"quantities": made}


def default(inputs: Inputs, run: str | None) -> dict[str, Any] | None:
    """Return the data of all predictions."""
    found = data(inputs.predictions) if run is None else {"quantities": {}}
    return found if found["quantities"] else None


def figure(data: dict[str, Any]) -> tuple[tuple[float, float], tuple[int, int]]:
    """Return size in inch and grid."""
    n = len(data["quantities"])
    return (4.8 * min(n, 2), 3.5 * ((n + 1) // 2)), ((n + 1) // 2, min(n, 2))


def draw(axes: Any, data: dict[str, Any]) -> None:
    """Draw one quantity a panel with the line of equality."""
    for panel, (quantity, found) in zip(np.atleast_1d(axes).flat, data["quantities"].items(), strict=False):
        for name, group in found["groups"].items():
            panel.plot(
                group["true"],
                group["predicted"],
                "o",
                markersize=4,
                label=label(name),
                color=palette.of(name, palette.LOCATIONS, list(found["groups"])),
            )
        both = [v for g in found["groups"].values() for v in (*g["true"], *g["predicted"])]
        panel.plot([min(both), max(both)], [min(both), max(both)], color=palette.INK, linestyle="--", linewidth=1, label="equal")
        unit = unit_of(quantity)
        panel.set_xlabel(label(f"true {quantity} / {unit}"))
        panel.set_ylabel(label(f"predicted {quantity} / {unit}"))
        panel.set_title(f"RMSE {found['rmse']:.3g}, n = {found['n']}", loc="left")
        panel.legend(loc="best")


def alt(data: dict[str, Any]) -> str:
    """Describe the picture in words."""
    parts = [f"{q} RMSE {f['rmse']:.3g} over {f['n']}" for q, f in data["quantities"].items()]
    return "Predicted against true: " + ", ".join(parts) + "."


def unit_of(quantity: str) -> str:
    """Return the unit of a loop parameter: N for biases, 1 for slopes."""
    return "N" if "beta" in quantity else "1"
