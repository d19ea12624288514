"""Make a report page from the toolchain's outputs."""

from __future__ import annotations

from dataclasses import replace

from sstl_cli.core.errors import UsageError
from sstl_cli.physics.effects import catalogue
from sstl_cli.reporting.inputs import EffectNote, Inputs
from sstl_cli.reporting.page import Page, page

DEFAULT_TITLE = "Tendon-sheath hysteresis report"


def run(inputs: Inputs, title: str = DEFAULT_TITLE) -> Page:
    """Return the page of these inputs.

    Raises
    ------
    UsageError
        E608 if no input carries a section of its own (phases alone, for example).
    """
    made = page(replace(inputs, catalogue=notes()), title)
    if not made.sections:
        given = ", ".join(sorted({kind for kind, _, _ in inputs.files}))
        raise UsageError(f"nothing to show in {given or 'no input'}", where="FILE", fix="add the log or the Theta table", code="E608")
    return made


def notes() -> dict[str, EffectNote]:
    """Return what the page says of every effect of the catalogue."""
    return {
        e.id: EffectNote(e.title, e.stage, e.equation, e.source, e.excitation, {p.name: p.meaning for p in e.parameters})
        for e in catalogue().values()
    }
