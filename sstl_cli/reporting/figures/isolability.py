"""Which effects this excitation can tell apart: cosine between their responses."""

from __future__ import annotations

from typing import Any

from sstl_cli.reporting.documents import mapping, matrix, texts
from sstl_cli.reporting.drawing import heat
from sstl_cli.reporting.inputs import Inputs

NEEDS = ("diagnosis",)


def data(document: dict[str, Any]) -> dict[str, Any]:
    """Return effect ids and the matrix of cosines, and the pairs above 0.95 (nearly the same response)."""
    found = mapping(document, "isolability")
    ids = texts(found, "ids")
    cosine = matrix(found, "cosine", len(ids), len(ids))
    twins = [(ids[i], ids[j], cosine[i][j]) for i in range(len(ids)) for j in range(i) if abs(cosine[i][j]) > 0.95]
    return {"ids": ids, "cosine": cosine, "twins": sorted(twins, key=lambda t: -abs(t[2]))}


def default(inputs: Inputs, run: str | None) -> dict[str, Any] | None:
    """Return the data of the first diagnosis."""
    found = data(inputs.diagnosis[0]) if inputs.diagnosis and run is None else {"ids": []}
    return found if found["ids"] else None


def figure(data: dict[str, Any]) -> tuple[tuple[float, float], tuple[int, int]]:
    """Return size in inch and grid."""
    n = len(data["ids"])
    return (max(4.6, 1.9 + 0.33 * n), max(3.6, 1.7 + 0.27 * n)), (1, 1)


def draw(axes: Any, data: dict[str, Any]) -> None:
    """Draw the matrix as cells with their numbers."""
    heat(axes, data["cosine"], data["ids"], data["ids"], "{:.2f}", 1.0)
    axes.set_title("cosine between responses / 1", loc="left")


def alt(data: dict[str, Any]) -> str:
    """Describe the matrix by the pairs that cannot be told apart."""
    twins = ", ".join(f"{a} and {b} ({c:.2f})" for a, b, c in data["twins"][:6])
    return f"Isolability of {len(data['ids'])} effects; hard to tell apart: {twins or 'none'}."
