"""What is left: measured minus simulated, before and after the effect, over time and over input tension."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from sstl_cli.reporting import palette
from sstl_cli.reporting.diagnosed import Diagnosed, Loop, Residuals
from sstl_cli.reporting.drawing import label
from sstl_cli.reporting.inputs import Array, Inputs, rms
from sstl_cli.reporting.reduce import keep
from sstl_cli.reporting.words import unit_of

NEEDS = ("diagnosis",)
CURVES = (("base", palette.BEFORE, 1.3), ("with effect", palette.AFTER, 1.0))
STRETCHES = 150


def records(document: Diagnosed) -> list[Residuals]:
    """Return the residuals of a diagnosis: its ``residuals``, or the differences of its ``loops`` where it has none."""
    return list(document.residuals) or [_from_loop(loop) for loop in document.loops]


@dataclass(frozen=True)
class Left:
    """Time in s (None without one), input tension and residuals of equal length in ``unit``, and the residuals' RMSE."""

    run: str
    system: str
    unit: str
    time_s: Array | None
    input_n: Array
    curves: dict[str, Array]
    rmse_n: dict[str, float]


def data(record: Residuals, unit: str = "N") -> Left:
    """Return the residuals of one run, thinned together."""
    x, time = np.array(record.tension_in_n), np.array(record.time_s)
    every = {"base": np.array(record.base_n), "with effect": np.array(record.effect_n)}
    curves = {name: y for name, y in every.items() if len(y) == len(x) and len(x)}
    index = keep(list(curves.values()), STRETCHES) if curves else np.arange(0)
    return Left(
        record.run_id,
        record.system,
        unit,
        time[index] if len(time) == len(x) else None,
        x[index],
        {name: y[index] for name, y in curves.items()},
        {name: rms(y) for name, y in curves.items()},
    )


def default(inputs: Inputs, run: str | None) -> Left | None:
    """Return the data of the named run of the first diagnosis, or of its first."""
    found = records(inputs.diagnosis[0]) if inputs.diagnosis else []
    record = next((r for r in found if run is None or r.run_id == run), None)
    made = data(record, unit_of(inputs.diagnosis[0])) if record else None
    return made if made is not None and made.curves else None


def figure(data: Left) -> tuple[tuple[float, float], tuple[int, int]]:
    """Return size in inch and grid."""
    return (8.2, 2.9), (1, 1 if data.time_s is None else 2)


def draw(axes: Any, data: Left) -> None:
    """Draw the residuals over time as lines and over tension as points, on the same scale."""
    by_tension = axes if data.time_s is None else axes[0, 1]
    panels = [(by_tension, data.input_n, f"input tension / {data.unit}")]
    if data.time_s is not None:
        panels.insert(0, (axes[0, 0], data.time_s, "time / s"))
    for panel, x, text in panels:
        panel.axhline(0.0, color=palette.INK, linewidth=0.8)
        for name, colour, width in CURVES:
            if name in data.curves:
                shown = f"measured − {name} (RMSE {data.rmse_n[name]:.2g} {data.unit})"
                style = {"marker": ".", "markersize": 3, "linestyle": ""} if panel is by_tension else {"linewidth": width}
                panel.plot(x, data.curves[name], color=colour, label=shown, **style)
        panel.set_xlabel(text)
        panel.set_ylabel(f"residual / {data.unit}" if panel is panels[0][0] else "")
    if len(panels) == 2:
        by_tension.sharey(panels[0][0])
        by_tension.set_ylabel(f"residual / {data.unit}")
    first = panels[0][0]
    first.set_title(label(f"{data.run} ({data.system})" if data.system else data.run, 52), loc="left")
    first.legend(loc="upper left", bbox_to_anchor=(0, -0.2), ncols=2, columnspacing=1.2, handlelength=1.6, fontsize=8)


def alt(data: Left) -> str:
    """Describe the picture in words."""
    errors = ", ".join(f"{name} {value:.2g} {data.unit}" for name, value in data.rmse_n.items())
    return f"Measured minus simulated output of run {data.run} over time and input tension; RMSE {errors}."


def _from_loop(loop: Loop) -> Residuals:
    measured = np.array(loop.measured_n)

    def left(simulated: tuple[float, ...]) -> tuple[float, ...]:
        return tuple((measured - np.array(simulated)).tolist()) if len(simulated) == len(measured) else ()

    return Residuals(
        run_id=loop.run_id,
        system=loop.system,
        time_s=loop.time_s,
        tension_in_n=loop.tension_in_n,
        base_n=left(loop.base_n),
        effect_n=left(loop.with_effect_n),
    )
