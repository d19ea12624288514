"""Reliability diagram: how often the verdict is right at each stated probability."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from sstl_cli.reporting import palette
from sstl_cli.reporting.inputs import Inputs
from sstl_cli.reporting.scored import Bin, Scored

NEEDS = ("blind",)


@dataclass(frozen=True)
class Reliability:
    """The bins that hold cases, and the expected calibration error."""

    bins: list[Bin]
    ece: float


def data(document: Scored) -> Reliability:
    """Return the bins in which a share is right."""
    bins = [b for b in document.reliability if b.mean_p == b.mean_p and b.share_right == b.share_right and b.n != 0]
    return Reliability(bins, document.ece)


def default(inputs: Inputs, run: str | None) -> Reliability | None:
    """Return the data of the first blind result."""
    found = data(inputs.blind[0]) if inputs.blind and run is None else None
    return found if found is not None and found.bins else None


def figure(data: Reliability) -> tuple[tuple[float, float], tuple[int, int]]:
    """Return size in inch and grid."""
    return (4.6, 3.7), (1, 1)


def draw(axes: Any, data: Reliability) -> None:
    """Draw share right over stated probability; the size of a point follows the cases in its bin."""
    bins = data.bins
    most = max((b.n for b in bins if b.n == b.n), default=1.0)
    axes.plot([0, 1], [0, 1], color=palette.INK, linestyle="--", linewidth=1, label="calibrated")
    axes.plot([b.mean_p for b in bins], [b.share_right for b in bins], color=palette.BLUE, linewidth=1.2)
    axes.scatter(
        [b.mean_p for b in bins],
        [b.share_right for b in bins],
        color=palette.BLUE,
        zorder=3,
        s=[20 + 100 * (b.n / most if b.n == b.n else 0.2) for b in bins],
        label="bin (size: cases)",
    )
    axes.set_xlabel("stated probability / 1")
    axes.set_ylabel("share right / 1")
    axes.set_xlim(0, 1.04)
    axes.set_ylim(0, 1.08)
    if data.ece == data.ece:
        axes.set_title(f"expected calibration error {data.ece:.3f}", loc="left")
    axes.legend(loc="upper left")


def alt(data: Reliability) -> str:
    """Describe the diagram in words."""
    worst = max(data.bins, key=lambda b: abs(b.share_right - b.mean_p))
    return (
        f"Share of right verdicts over stated probability in {len(data.bins)} bins, expected calibration error "
        f"{data.ece:.3f}; largest difference at {worst.mean_p:.2f}, where {worst.share_right:.2f} are right."
    )
