"""The gap step by step: as given, re-tuned, with the effect, down to the noise floor."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from sstl_cli.reporting import palette
from sstl_cli.reporting.diagnosed import Diagnosed
from sstl_cli.reporting.inputs import Inputs
from sstl_cli.reporting.words import unit_of

NEEDS = ("diagnosis",)


@dataclass(frozen=True)
class Step:
    """One step: its RMSE, and the change from the step before."""

    name: str
    rmse_n: float
    change_n: float | None
    colour: str


@dataclass(frozen=True)
class Steps:
    """Every step that the document has, in ``unit``, and what the errors are called."""

    steps: list[Step]
    unit: str
    axis: str


def data(document: Diagnosed) -> Steps:
    """Return the gap step by step."""
    gap = document.gap
    steps: list[Step] = []
    for name, value, colour in (
        ("as given", gap.rmse_base_n, palette.GREY),
        ("re-tuned", gap.rmse_retuned_n, palette.BEFORE),
        ("with effect", gap.rmse_with_effect_n, palette.AFTER),
        ("noise floor", gap.noise_floor_n, palette.SKY),
    ):
        if value == value:
            steps.append(Step(name, value, value - steps[-1].rmse_n if steps else None, colour))
    return Steps(steps, unit_of(document), "held-out RMSE" if gap.held_out else "RMSE")


def default(inputs: Inputs, run: str | None) -> Steps | None:
    """Return the data of the first diagnosis."""
    found = data(inputs.diagnosis[0]) if inputs.diagnosis and run is None else None
    return found if found is not None and found.steps else None


def figure(data: Steps) -> tuple[tuple[float, float], tuple[int, int]]:
    """Return size in inch and grid."""
    return (4.8, 3.4), (1, 1)


def draw(axes: Any, data: Steps) -> None:
    """Draw a bar a step, joined by the level it falls from."""
    steps = data.steps
    top = max(s.rmse_n for s in steps) or 1.0
    for i, step in enumerate(steps):
        axes.bar(i, step.rmse_n, width=0.62, color=step.colour, zorder=2)
        axes.text(i, step.rmse_n + 0.02 * top, f"{step.rmse_n:.3g} {data.unit}", ha="center", va="bottom", fontsize=9)
        if step.change_n is not None:
            before = steps[i - 1].rmse_n
            axes.plot([i - 1 + 0.31, i + 0.31], [before, before], color=palette.INK, linewidth=0.9, linestyle=":")
            if abs(step.change_n) > 0.2 * top:
                axes.text(
                    i,
                    (before + step.rmse_n) / 2 + 0.03 * top,
                    f"{step.change_n:+.3g} {data.unit}".replace("-", "−"),
                    ha="center",
                    va="center",
                    fontsize=8.5,
                )
    axes.set_ylim(0, 1.14 * top)
    axes.set_xticks(range(len(steps)), [s.name for s in steps])
    axes.set_ylabel(f"{data.axis} / {data.unit}")
    axes.grid(False, axis="x")


def alt(data: Steps) -> str:
    """Describe the picture in words."""
    return "Gap between simulator and log: " + ", ".join(f"{s.name} {s.rmse_n:.3g} {data.unit}" for s in data.steps) + "."
