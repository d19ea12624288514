"""The candidates: how probable each is, and how far it shrinks the held-out gap."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from sstl_cli.core.groups import error_of
from sstl_cli.reporting import palette
from sstl_cli.reporting.diagnosed import Diagnosed
from sstl_cli.reporting.documents import NAN
from sstl_cli.reporting.drawing import label
from sstl_cli.reporting.inputs import Inputs
from sstl_cli.reporting.table import probability
from sstl_cli.reporting.words import unit_of

NEEDS = ("diagnosis",)
MOST = 12


@dataclass(frozen=True)
class Ranked:
    """One candidate; ``named`` where it has an effect of the verdict."""

    id: str
    probability: float
    interval: tuple[float, float]
    rmse_n: float
    named: bool


@dataclass(frozen=True)
class Ranking:
    """The candidates, most probable first, beside the error of the re-tuned base and the noise, in ``unit``; all of the same samples."""

    candidates: list[Ranked]
    floor_n: float
    retuned_n: float
    unit: str


def data(document: Diagnosed) -> Ranking:
    """Return the most probable candidates with their held-out errors."""
    named = set(document.verdict.effects)
    found = [
        Ranked(
            c.id,
            c.probability,
            c.probability_ci95 or (NAN, NAN),
            NAN if error_of(c.samples) else c.rmse_held_out_n,
            bool(set(c.id.replace("+", " ").replace(",", " ").split()) & named),
        )
        for c in document.candidates
    ]
    found.sort(key=lambda c: (-c.probability if c.probability == c.probability else 1.0, c.id))
    gap = document.gap
    # errors of other samples stand in the tables, with their name: on one axis they would be compared
    base, floor = (NAN, NAN) if error_of(gap.samples) else (gap.rmse_retuned_n, gap.noise_floor_n)
    return Ranking(found[:MOST], floor, base, unit_of(document))


def default(inputs: Inputs, run: str | None) -> Ranking | None:
    """Return the data of the first diagnosis."""
    found = data(inputs.diagnosis[0]) if inputs.diagnosis and run is None else None
    return found if found is not None and found.candidates else None


def figure(data: Ranking) -> tuple[tuple[float, float], tuple[int, int]]:
    """Return size in inch and grid."""
    return (8.2, max(1.9, 1.1 + 0.32 * len(data.candidates))), (1, 2)


def draw(axes: Any, data: Ranking) -> None:
    """Draw probability left and held-out RMSE right, the same order of candidates."""
    left, right = axes[0]
    names = [label(c.id) for c in data.candidates]
    colours = [palette.AFTER if c.named else palette.GREY for c in data.candidates]
    places = range(len(names))
    left.barh(
        places, [0.0 if c.probability != c.probability else c.probability for c in data.candidates], color=colours, height=0.62, zorder=2
    )
    for i, c in enumerate(data.candidates):
        low, high = c.interval
        if low == low and high == high:
            left.plot([low, high], [i, i], color=palette.INK, linewidth=1.2, zorder=3)
        text = probability(c.probability).text if c.probability < 0.001 else f"{c.probability:.2g}"
        left.text(
            max(0.0 if c.probability != c.probability else c.probability, high if high == high else 0.0) + 0.02,
            i,
            text,
            va="center",
            fontsize=8.5,
        )
    left.set_xlim(0, 1.12)
    left.set_xlabel("probability / 1")
    right.plot([c.rmse_n for c in data.candidates], places, "o", color=palette.INK, markersize=5, zorder=3, label="with effect")
    for value, name, colour, style in (
        (data.retuned_n, "re-tuned base", palette.BEFORE, "--"),
        (data.floor_n, "noise floor", palette.SKY, "-"),
    ):
        if value == value:
            right.axvline(value, color=colour, linestyle=style, linewidth=1.6, label=name)
    right.set_xlim(left=0)
    right.set_xlabel(f"held-out RMSE / {data.unit}")
    right.legend(loc="center left", bbox_to_anchor=(1.01, 0.5))
    for panel, texts_ in ((left, names), (right, [""] * len(names))):
        panel.set_yticks(list(places), texts_)
        panel.set_ylim(len(names) - 0.4, -0.6)
        panel.grid(False, axis="y")


def alt(data: Ranking) -> str:
    """Describe the picture in words."""
    parts = [f"{c.id} {c.probability:.2g}" for c in data.candidates[:5]]
    return "Probability of the candidates, most probable first: " + ", ".join(parts) + "."
