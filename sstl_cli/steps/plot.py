"""Choose the one figure that shows a file."""

from __future__ import annotations

from dataclasses import dataclass
from types import ModuleType
from typing import Any

from sstl_cli.core.errors import SstlError, UsageError, nearest
from sstl_cli.reporting import figures
from sstl_cli.reporting.inputs import Inputs

# what people look at first for each kind of input
FIRST = {
    "log": "loop",
    "theta": "theta",
    "command": "tracking",
    "score": "methods",
    "diagnosis": "waterfall",
    "blind": "confusion",
    "predictions": "predicted",
    "history": "training",
    "evaluation": "variants",
    "evaluate": "variants",
}


@dataclass(frozen=True)
class Choice:
    """A figure module, its data and its description."""

    kind: str
    module: ModuleType
    data: Any
    alt: str


def run(inputs: Inputs, kind: str | None = None, subject: str | None = None) -> Choice:
    """Return the figure of ``kind`` (or the first that fits the inputs) and its data.

    Raises
    ------
    UsageError
        E606 for an unknown kind.
    SstlError
        E609 if the inputs hold nothing for this figure.
    """
    offered = {name: module for name, module in figures.find().items() if hasattr(module, "NEEDS")}
    given = sorted({k for k, _, _ in inputs.files})
    if kind is None:
        kind = next((FIRST[k] for k in FIRST if k in given), None)
        if kind is None:
            raise SstlError(f"no figure shows {', '.join(given)} alone", where="FILE", fix=nearest("", offered), code="E609")
    if kind not in offered:
        raise UsageError(f"unknown figure '{kind}' ({nearest(kind, offered)})", where="--kind", code="E606")
    module = offered[kind]
    data = module.default(inputs, subject)
    if data is None:
        about = f" about '{subject}'" if subject is not None else ""
        raise SstlError(
            f"the input has nothing{about} for the figure '{kind}'",
            where="FILE",
            fix=f"it is drawn from: {', '.join(module.NEEDS)}",
            code="E609",
        )
    return Choice(kind, module, data, module.alt(data))
