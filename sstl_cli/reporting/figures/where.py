"""Where the gap sits: share of the squared error by phase and configuration."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from sstl_cli.reporting.diagnosed import Diagnosed
from sstl_cli.reporting.drawing import heat
from sstl_cli.reporting.inputs import PHASE_CODES, Inputs

NEEDS = ("diagnosis",)
MOST = 14
OTHERS = "others"


@dataclass(frozen=True)
class Shares:
    """Shares in % by system and phase (rows) and configuration (columns), and their sum."""

    rows: list[str]
    columns: list[str]
    share_pct: list[list[float]]
    total_pct: float


def data(document: Diagnosed) -> Shares:
    """Return the map of the gap.

    Beyond MOST configurations, those with the smallest share are summed in a last column, so that all cells
    still add up to the document's total.
    """
    cells: dict[tuple[str, str], float] = {}
    for row in document.where:
        if row.share_pct == row.share_pct:
            key = (f"{row.system} {row.phase or 'all phases'}".strip(), (row.config_id or "all").strip())
            cells[key] = cells.get(key, 0.0) + row.share_pct
    lines = sorted({r for r, _ in cells}, key=_order)
    total = {c: sum(v for (_, cc), v in cells.items() if cc == c) for c in {c for _, c in cells}}
    largest = sorted(total, key=lambda c: (-total[c], c))
    shown = sorted(largest[:MOST]) if len(largest) > MOST + 1 else sorted(largest)
    rest = [c for c in largest if c not in shown]
    matrix = [[cells.get((r, c), 0.0) for c in shown] for r in lines]
    if rest:
        matrix = [[*line, sum(cells.get((r, c), 0.0) for c in rest)] for r, line in zip(lines, matrix, strict=True)]
        shown = [*shown, f"{len(rest)} {OTHERS}"]
    return Shares(lines, shown, matrix, sum(cells.values()))


def default(inputs: Inputs, run: str | None) -> Shares | None:
    """Return the data of the first diagnosis."""
    found = data(inputs.diagnosis[0]) if inputs.diagnosis and run is None else None
    return found if found is not None and found.rows else None


def figure(data: Shares) -> tuple[tuple[float, float], tuple[int, int]]:
    """Return size in inch and grid."""
    return (max(4.8, 1.6 + 0.55 * len(data.columns)), max(2.6, 1.3 + 0.34 * len(data.rows))), (1, 1)


def draw(axes: Any, data: Shares) -> None:
    """Draw the shares as cells with their numbers."""
    top = max(max(line) for line in data.share_pct)
    heat(axes, data.share_pct, data.rows, data.columns, "{:.1f}", top)
    axes.set_xlabel("configuration")
    axes.set_ylabel("system and phase")
    axes.set_title(f"share of squared error / % (sum {data.total_pct:.1f})", loc="left")


def alt(data: Shares) -> str:
    """Describe the map by its largest cell."""
    best = max((v, r, c) for r, line in zip(data.rows, data.share_pct, strict=True) for c, v in zip(data.columns, line, strict=True))
    return (
        f"Share of the squared error by phase and configuration, adding up to {data.total_pct:.1f} %; "
        f"largest {best[0]:.1f} % in {best[1]}, {best[2]}."
    )


def _order(name: str) -> tuple[str, int]:
    system, _, phase = name.partition(" ")
    return system, PHASE_CODES.index(phase) if phase in PHASE_CODES else 99
