"""The measured loop with the simulated loops before and after the effect."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from sstl_cli.reporting import palette
from sstl_cli.reporting.diagnosed import Loop
from sstl_cli.reporting.drawing import label
from sstl_cli.reporting.inputs import Array, Inputs
from sstl_cli.reporting.reduce import keep
from sstl_cli.reporting.words import unit_of

NEEDS = ("diagnosis",)
LOOKS = {"measured": (palette.INK, "-", 1.1), "base": (palette.BEFORE, "--", 1.6), "with effect": (palette.AFTER, "-", 1.6)}
STRETCHES = 120


@dataclass(frozen=True)
class Simulated:
    """Input tension and curves of equal length in ``unit``, thinned together, and each simulation's RMSE."""

    run: str
    system: str
    unit: str
    input_n: Array
    curves: dict[str, Array]
    rmse_n: dict[str, float]


def data(loop: Loop, unit: str = "N") -> Simulated:
    """Return the measured and the simulated loops of one run."""
    x = np.array(loop.tension_in_n)
    every = {"measured": np.array(loop.measured_n), "base": np.array(loop.base_n), "with effect": np.array(loop.with_effect_n)}
    curves = {name: y for name, y in every.items() if len(y) == len(x) and len(x)}
    rmse = {}
    if "measured" in curves:
        for name in ("base", "with effect"):
            error = curves[name] - curves["measured"] if name in curves else np.empty(0)
            error = error[~np.isnan(error)]
            if len(error):
                rmse[name] = float(np.sqrt(np.mean(error**2)))
    index = keep([x, *curves.values()], STRETCHES) if curves else np.arange(0)
    return Simulated(loop.run_id, loop.system, unit, x[index], {name: y[index] for name, y in curves.items()}, rmse)


def default(inputs: Inputs, run: str | None) -> Simulated | None:
    """Return the data of the named run of the first diagnosis, or of its first loop."""
    loops = inputs.diagnosis[0].loops if inputs.diagnosis else ()
    found = next((loop for loop in loops if run is None or loop.run_id == run), None)
    made = data(found, unit_of(inputs.diagnosis[0])) if found else None
    return made if made is not None and made.curves else None


def figure(data: Simulated) -> tuple[tuple[float, float], tuple[int, int]]:
    """Return size in inch and grid."""
    return (4.6, 3.6), (1, 1)


def draw(axes: Any, data: Simulated) -> None:
    """Draw the loops over one another, measured on top and thin."""
    for name in ("base", "with effect", "measured"):
        if name in data.curves:
            colour, style, width = LOOKS[name]
            text = f"{name} (RMSE {data.rmse_n[name]:.3g} {data.unit})" if name in data.rmse_n else name
            axes.plot(data.input_n, data.curves[name], color=colour, linestyle=style, linewidth=width, label=text)
    axes.set_xlabel(f"input tension / {data.unit}")
    axes.set_ylabel(f"output tension / {data.unit}")
    axes.set_title(label(f"{data.run} ({data.system})", 52), loc="left")
    axes.legend(loc="upper left", bbox_to_anchor=(0, -0.17), ncols=2, columnspacing=1.2, handlelength=2, fontsize=8)


def alt(data: Simulated) -> str:
    """Describe the picture in words."""
    errors = ", ".join(f"{name} RMSE {value:.3g} {data.unit}" for name, value in data.rmse_n.items())
    return f"Measured and simulated loops of run {data.run} ({data.system}); {errors}."
