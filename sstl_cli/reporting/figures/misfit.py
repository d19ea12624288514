"""What is left: measured minus simulated, before and after the effect, over time and over input tension."""

from __future__ import annotations

from typing import Any

import numpy as np

from sstl_cli.reporting import palette
from sstl_cli.reporting.documents import numbers, rows
from sstl_cli.reporting.drawing import label
from sstl_cli.reporting.inputs import Inputs
from sstl_cli.reporting.reduce import keep
from sstl_cli.reporting.words import unit_of

NEEDS = ("diagnosis",)
CURVES = (("base", "base_n", palette.BEFORE, 1.3), ("with effect", "effect_n", palette.AFTER, 1.0))
STRETCHES = 150


def records(document: dict[str, Any]) -> list[dict[str, Any]]:
    """Return the residuals of a diagnosis: its ``residuals``, or the differences of its ``loops`` where it has none."""
    found = rows(document, "residuals")
    return found or [_from_loop(loop) for loop in rows(document, "loops")]


def data(record: dict[str, Any], unit: str = "N") -> dict[str, Any]:
    """Return time in s (None without one), input tension and residuals of equal length in the unit, and their RMSE."""
    x = np.array(numbers(record, "tension_in_n"))
    time = np.array(numbers(record, "time_s"))
    curves = {name: np.array(numbers(record, key)) for name, key, *_ in CURVES}
    curves = {name: y for name, y in curves.items() if len(y) == len(x) and len(x)}
    index = keep(list(curves.values()), STRETCHES) if curves else np.arange(0)
    return {
        "run": str(record.get("run_id", "?")),
        "system": str(record.get("system", "")),
        "unit": unit,
        "time_s": time[index] if len(time) == len(x) else None,
        "input_n": x[index],
        "curves": {name: y[index] for name, y in curves.items()},
        "rmse_n": {name: _rms(y) for name, y in curves.items()},
    }


def default(inputs: Inputs, run: str | None) -> dict[str, Any] | None:
    """Return the data of the named run of the first diagnosis, or of its first."""
    found = records(inputs.diagnosis[0]) if inputs.diagnosis else []
    record = next((r for r in found if run is None or r.get("run_id") == run), None)
    made = data(record, unit_of(inputs.diagnosis[0])) if record else {"curves": {}}
    return made if made["curves"] else None


def figure(data: dict[str, Any]) -> tuple[tuple[float, float], tuple[int, int]]:
    """Return size in inch and grid."""
    return (8.2, 2.9), (1, 1 if data["time_s"] is None else 2)


def draw(axes: Any, data: dict[str, Any]) -> None:
    """Draw the residuals over time as lines and over tension as points, on the same scale."""
    by_tension = axes if data["time_s"] is None else axes[0, 1]
    panels = [(by_tension, data["input_n"], f"input tension / {data['unit']}")]
    if data["time_s"] is not None:
        panels.insert(0, (axes[0, 0], data["time_s"], "time / s"))
    for panel, x, text in panels:
        panel.axhline(0.0, color=palette.INK, linewidth=0.8)
        for name, _, colour, width in CURVES:
            if name in data["curves"]:
                shown = f"measured − {name} (RMSE {data['rmse_n'][name]:.2g} {data['unit']})"
                style = {"marker": ".", "markersize": 3, "linestyle": ""} if panel is by_tension else {"linewidth": width}
                panel.plot(x, data["curves"][name], color=colour, label=shown, **style)
        panel.set_xlabel(text)
        panel.set_ylabel(f"residual / {data['unit']}" if panel is panels[0][0] else "")
    if len(panels) == 2:
        by_tension.sharey(panels[0][0])
        by_tension.set_ylabel(f"residual / {data['unit']}")
    first = panels[0][0]
    first.set_title(label(f"{data['run']} ({data['system']})" if data["system"] else data["run"], 52), loc="left")
    first.legend(loc="upper left", bbox_to_anchor=(0, -0.2), ncols=2, columnspacing=1.2, handlelength=1.6, fontsize=8)


def alt(data: dict[str, Any]) -> str:
    """Describe the picture in words."""
    errors = ", ".join(f"{name} {value:.2g} {data['unit']}" for name, value in data["rmse_n"].items())
    return f"Measured minus simulated output of run {data['run']} over time and input tension; RMSE {errors}."


def _from_loop(loop: dict[str, Any]) -> dict[str, Any]:
    measured = np.array(numbers(loop, "measured_n"))
    record = {k: loop.get(k) for k in ("run_id", "system", "tension_in_n", "time_s")}
    for key, simulated in (("base_n", "base_n"), ("effect_n", "with_effect_n")):
        y = np.array(numbers(loop, simulated))
        record[key] = list(measured - y) if len(y) == len(measured) else None
    return record


def _rms(values: Any) -> float:
    good = values[~np.isnan(values)]
    return float(np.sqrt(np.mean(good**2))) if len(good) else float("nan")
