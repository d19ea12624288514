"""Channels that a proposal leaves out although they look like the position or the reference: named, with the line to write."""

from __future__ import annotations

import json
from collections.abc import Sequence

from sstl_cli.core.units import is_unit, unit_of
from sstl_cli.importers.guess_look import Look, moves
from sstl_cli.importers.guess_names import Said
from sstl_cli.importers.guess_words import DIMENSIONS, words
from sstl_cli.importers.text_header import unit_in

# of a joint, and what turns with it, in names without a quantity
TURNED = words("q spool drum pulley capstan winch phi theta alpha trommel rolle angle angulo winkel")
# of the sheath or the rig, not of what pulls
NO_DRIVE = DIMENSIONS | words("bend bending biegung sheath gaine guaina funda")
SHOWN = 4


def not_mapped(looks: Sequence[Look], toml: str) -> list[str]:
    """Return a reason for each of position and reference that has no line in a proposal and a channel that looks like it.

    Parameters
    ----------
    looks : sequence of Look
        The file that the proposal is for, or the two of a pair.
    toml : str
        The proposal.
    """
    lines = [line for line in toml.split("\n") if not line.startswith("#")]
    out = []
    for target, fits in (("position_in_mm", _place), ("tension_ref_n", _reference)):
        if any(line.startswith(f"{target} = ") for line in lines):
            continue
        found = [s for x in looks for s in x.names if fits(s) and s.name in x.data and moves(x.data[s.name])]
        found = [s for s in found if not any(json.dumps(s.name, ensure_ascii=False) in line for line in lines)]
        if found:
            shown = ", ".join(repr(s.name) for s in found[:SHOWN]) + (", ..." if found[SHOWN:] else "")
            out.append(f"not mapped: {shown}; if it is wanted, write {_line(target, found[0])}")
    return out


def _unit(one: Said) -> str:
    """Return the unit of a channel, or that at the end of a name without a quantity (``spool_deg``)."""
    return one.unit or unit_in(one.name)


def _dimension(one: Said) -> str:
    unit = _unit(one)
    return unit_of(unit)[0] if is_unit(unit) else ""


def _place(one: Said) -> bool:
    """Return whether a channel looks like the position or the angle of the drive."""
    if one.reference or one.unmeasured or one.side == "out" or one.strange.lower() in ("rpm", "%") or NO_DRIVE.intersection(one.words):
        return False
    dimension = _dimension(one)
    if one.quantity in ("position", "angle"):
        return dimension in ("", "length", "angle", "count")
    return one.quantity == "" and (dimension in ("length", "angle") or (not dimension and bool(TURNED.intersection(one.words))))


def _reference(one: Said) -> bool:
    """Return whether a channel looks like the tension that was asked for."""
    return one.reference and not one.strange and one.quantity in ("", "force") and _dimension(one) in ("", "force")


def _line(target: str, one: Said) -> str:
    extra = ", radius_mm = ..." if target == "position_in_mm" and (_dimension(one) == "angle" or one.quantity == "angle") else ""
    return f'{target} = {{ column = {json.dumps(one.name, ensure_ascii=False)}, unit = "{_unit(one) or "..."}"{extra} }}'
