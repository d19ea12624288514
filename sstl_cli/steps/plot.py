"""Choose the one figure that shows a file."""

from __future__ import annotations

from dataclasses import dataclass, replace
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
    """A figure module, its data, its description, and what stands above it (the tendon, where a diagnosis judges several)."""

    kind: str
    module: ModuleType
    data: Any
    alt: str
    title: str = ""


def run(inputs: Inputs, kind: str | None = None, subject: str | None = None, tendon: str | None = None) -> Choice:
    """Return the figure of ``kind`` (or the first that fits the inputs) and its data.

    Parameters
    ----------
    subject : str, optional
        The run to show, for figures of one run.
    tendon : str, optional
        The tendon to show of a diagnosis that judges several (default: the one with the largest gap).

    Raises
    ------
    UsageError
        E606 for an unknown kind, E611 for a tendon that the diagnosis does not judge.
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
    module, title = offered[kind], ""
    if "diagnosis" in module.NEEDS and inputs.diagnosis:
        inputs, title = _of_tendon(inputs, tendon)
    elif tendon is not None:
        raise UsageError(f"the figure '{kind}' is of no single tendon", where="--tendon", fix="leave it out", code="E611")
    data = module.default(inputs, subject)
    if data is None:
        about = f" about '{subject}'" if subject is not None else f" about {title[:1].lower()}{title[1:]}" if title else ""
        raise SstlError(
            f"the input has nothing{about} for the figure '{kind}'",
            where="FILE",
            fix=f"it is drawn from: {', '.join(module.NEEDS)}",
            code="E609",
        )
    alt = module.alt(data)
    return Choice(kind, module, data, f"{title}: {alt}" if title else alt, title)


def _of_tendon(inputs: Inputs, wanted: str | None) -> tuple[Inputs, str]:
    """Return the inputs with one tendon's part of the first diagnosis, and what it is called; as they are where it judges but one."""
    parts = dict(inputs.diagnosis[0].by_tendon())
    if len(parts) == 1 and wanted is None:
        return inputs, ""
    name = next(iter(parts)) if wanted is None else wanted
    if name not in parts:
        known = nearest(name, [n for n in parts if n]) if any(parts) else "it judges one tendon: leave it out"
        raise UsageError(f"the diagnosis judges no tendon '{name}'", where="--tendon", fix=known, code="E611")
    return replace(inputs, diagnosis=[parts[name]]), f"Tendon {name}"
