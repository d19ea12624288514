"""The candidates: how probable each is, and how far it shrinks the held-out gap."""

from __future__ import annotations

from typing import Any

from sstl_cli.reporting import palette
from sstl_cli.reporting.documents import interval, mapping, number, rows, texts
from sstl_cli.reporting.drawing import label
from sstl_cli.reporting.inputs import Inputs
from sstl_cli.reporting.table import probability
from sstl_cli.reporting.words import unit_of

NEEDS = ("diagnosis",)
MOST = 12


def data(document: dict[str, Any]) -> dict[str, Any]:
    """Return id, probability, held-out RMSE in N and whether the verdict names it, most probable first."""
    named = set(texts(mapping(document, "verdict"), "effects"))
    found: list[dict[str, Any]] = [
        {
            "id": str(c.get("id", "?")),
            "probability": number(c.get("probability")),
            "interval": interval(c.get("probability_ci95")),
            "rmse_n": number(c.get("rmse_held_out_n")),
            "named": bool(set(str(c.get("id", "?")).replace("+", " ").replace(",", " ").split()) & named),
        }
        for c in rows(document, "candidates")
    ]
    found.sort(key=lambda c: (-c["probability"] if c["probability"] == c["probability"] else 1.0, c["id"]))
    gap = mapping(document, "gap")
    return {
        "candidates": found[:MOST],
        "floor_n": number(gap.get("noise_floor_n")),
        "retuned_n": number(gap.get("rmse_retuned_n")),
        "unit": unit_of(document),
    }


def default(inputs: Inputs, run: str | None) -> dict[str, Any] | None:
    """Return the data of the first diagnosis."""
    found = data(inputs.diagnosis[0]) if inputs.diagnosis and run is None else {"candidates": []}
    return found if found["candidates"] else None


def figure(data: dict[str, Any]) -> tuple[tuple[float, float], tuple[int, int]]:
    """Return size in inch and grid."""
    return (8.2, max(1.9, 1.1 + 0.32 * len(data["candidates"]))), (1, 2)


def draw(axes: Any, data: dict[str, Any]) -> None:
    """Draw probability left and held-out RMSE right, the same order of candidates."""
    left, right = axes[0]
    names = [label(c["id"]) for c in data["candidates"]]
    colours = [palette.AFTER if c["named"] else palette.GREY for c in data["candidates"]]
    places = range(len(names))
    left.barh(
        places,
        [0.0 if c["probability"] != c["probability"] else c["probability"] for c in data["candidates"]],
        color=colours,
        height=0.62,
        zorder=2,
    )
    for i, c in enumerate(data["candidates"]):
        low, high = c["interval"]
        if low == low and high == high:
            left.plot([low, high], [i, i], color=palette.INK, linewidth=1.2, zorder=3)
        text = probability(c["probability"]).text if c["probability"] < 0.001 else f"{c['probability']:.2g}"
        left.text(
            max(0.0 if c["probability"] != c["probability"] else c["probability"], high if high == high else 0.0) + 0.02,
            i,
            text,
            va="center",
            fontsize=8.5,
        )
    left.set_xlim(0, 1.12)
    left.set_xlabel("probability / 1")
    right.plot([c["rmse_n"] for c in data["candidates"]], places, "o", color=palette.INK, markersize=5, zorder=3, label="with effect")
    for value, name, colour, style in (
        (data["retuned_n"], "re-tuned base", palette.BEFORE, "--"),
        (data["floor_n"], "noise floor", palette.SKY, "-"),
    ):
        if value == value:
            right.axvline(value, color=colour, linestyle=style, linewidth=1.6, label=name)
    right.set_xlim(left=0)
    right.set_xlabel(f"held-out RMSE / {data['unit']}")
    right.legend(loc="center left", bbox_to_anchor=(1.01, 0.5))
    for panel, texts_ in ((left, names), (right, [""] * len(names))):
        panel.set_yticks(list(places), texts_)
        panel.set_ylim(len(names) - 0.4, -0.6)
        panel.grid(False, axis="y")


def alt(data: dict[str, Any]) -> str:
    """Describe the picture in words."""
    parts = [f"{c['id']} {c['probability']:.2g}" for c in data["candidates"][:5]]
    return "Probability of the candidates, most probable first: " + ", ".join(parts) + "."
