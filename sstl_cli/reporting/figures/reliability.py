"""Reliability diagram: how often the verdict is right at each stated probability."""

from __future__ import annotations

from typing import Any

from sstl_cli.reporting import palette
from sstl_cli.reporting.documents import number, rows
from sstl_cli.reporting.inputs import Inputs

NEEDS = ("blind",)


def data(document: dict[str, Any]) -> dict[str, Any]:
    """Return the bins that hold cases (range, mean stated probability, share right, cases) and the stated ECE."""
    bins = [
        {
            "low": number(b.get("p_low")),
            "high": number(b.get("p_high")),
            "stated": number(b.get("mean_p")),
            "right": number(b.get("share_right")),
            "n": number(b.get("n")),
        }
        for b in rows(document, "reliability")
    ]
    return {
        "bins": [b for b in bins if b["stated"] == b["stated"] and b["right"] == b["right"] and b["n"] != 0],
        "ece": number(document.get("ece")),
    }


def default(inputs: Inputs, run: str | None) -> dict[str, Any] | None:
    """Return the data of the first blind result."""
    found = data(inputs.blind[0]) if inputs.blind and run is None else {"bins": []}
    return found if found["bins"] else None


def figure(data: dict[str, Any]) -> tuple[tuple[float, float], tuple[int, int]]:
    """Return size in inch and grid."""
    return (4.6, 3.7), (1, 1)


def draw(axes: Any, data: dict[str, Any]) -> None:
    """Draw share right over stated probability; the size of a point follows the cases in its bin."""
    bins = data["bins"]
    most = max((b["n"] for b in bins if b["n"] == b["n"]), default=1.0)
    axes.plot([0, 1], [0, 1], color=palette.INK, linestyle="--", linewidth=1, label="calibrated")
    axes.plot([b["stated"] for b in bins], [b["right"] for b in bins], color=palette.BLUE, linewidth=1.2)
    axes.scatter(
        [b["stated"] for b in bins],
        [b["right"] for b in bins],
        color=palette.BLUE,
        zorder=3,
        s=[20 + 100 * (b["n"] / most if b["n"] == b["n"] else 0.2) for b in bins],
        label="bin (size: cases)",
    )
    axes.set_xlabel("stated probability / 1")
    axes.set_ylabel("share right / 1")
    axes.set_xlim(0, 1.04)
    axes.set_ylim(0, 1.08)
    if data["ece"] == data["ece"]:
        axes.set_title(f"expected calibration error {data['ece']:.3f}", loc="left")
    axes.legend(loc="upper left")


def alt(data: dict[str, Any]) -> str:
    """Describe the diagram in words."""
    worst = max(data["bins"], key=lambda b: abs(b["right"] - b["stated"]))
    return (
        f"Share of right verdicts over stated probability in {len(data['bins'])} bins, expected calibration error "
        f"{data['ece']:.3f}; largest difference at {worst['stated']:.2f}, where {worst['right']:.2f} are right."
    )
