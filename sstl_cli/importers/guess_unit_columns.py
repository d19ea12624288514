"""Units of readings that stand neither in their names nor in a row: columns beside them (``Force,Unit``, ``UnitIn``), and a line above (``Units: lb``)."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace

from sstl_cli.core.units import is_unit, unit_of
from sstl_cli.importers.base import Channel
from sstl_cli.importers.guess_names import Said, said
from sstl_cli.importers.text_header import UNIT_ROWS, stated_unit, unit_in

_LINE = re.compile(r"[\W_]*(?:(?:force|load|tension)\s+)?(?:units?|einheit|unite|unidad|unita)\s*[:=;,]\s*(\S+?)[\s;,]*", re.IGNORECASE)


def with_unit_said(found: Sequence[Channel], remarks: Iterable[str]) -> tuple[list[Channel], dict[str, str]]:
    """Return the columns with the one unit of force that a line above the table tells for what may be a force of no other unit, which is asked."""
    held = {u for line in remarks if (m := _LINE.fullmatch(line)) and (u := stated_unit(m[1])) and unit_of(u)[0] == "force"}
    if len(held) != 1:
        return list(found), {}
    unit = held.pop()
    forces = [c.name for c in found if not c.text and _may_be_force(s := _said(c)) and not (s.unit or s.strange)]
    asked = dict.fromkeys(forces, f"a line above the table says that units are {unit}: this one's too?")
    return [replace(c, unit=unit) if c.name in asked else c for c in found], asked


def with_unit_columns(found: Sequence[Channel], cells: Callable[[str], Sequence[str]]) -> tuple[list[Channel], dict[str, str]]:
    """Return the channels with the units that columns beside them hold, and a question for each that states another one, or whose unit changes.

    Parameters
    ----------
    found : sequence of Channel
        The columns of a table, in its order.
    cells : callable
        What a column of text holds, row by row.
    """
    units = {c.name: held for c in found if c.text and UNIT_ROWS.intersection(said(c.name).words) and (held := _units(cells(c.name)))}
    stated: dict[str, str] = {}
    asked: dict[str, str] = {}
    for column, held in units.items():
        for one in _readings(found, column, alone=len(units) == 1):
            stated[one.name] = held[0]
            if len(held) > 1:
                asked[one.name] = f"'{column}' says {' and '.join(held)}: the unit changes from row to row, write all of it in one"
            elif is_unit(one.unit) and one.unit != unit_in(one.name) and unit_of(one.unit) != unit_of(held[0]):
                asked[one.name] = f"'{column}' says {held[0]}, the header {one.unit}: which is it?"
    return [replace(c, unit=stated.get(c.name, c.unit)) for c in found], asked


def _may_be_force(s: Said) -> bool:
    """Return whether a name says a tension, or one side and nothing of what is measured there (``proximal``)."""
    return s.tension or (bool(s.side) and s.quantity in ("force", "") and s.dimension in ("force", ""))


def _said(channel: Channel) -> Said:
    """Return what a column's name says with the unit that stands apart from it: that of ``f_in`` is no inch."""
    return said(channel.name, "" if channel.unit == unit_in(channel.name) else channel.unit)


def _units(cells: Sequence[str]) -> list[str]:
    """Return the units of force that a column holds, an empty list where it holds anything else."""
    held = [stated_unit(c) for c in dict.fromkeys(cells) if c.strip()]
    forces = [u for u in held if u and unit_of(u)[0] == "force"]
    return list(dict.fromkeys(forces)) if len(forces) == len(held) else []


def _readings(found: Sequence[Channel], column: str, alone: bool) -> list[Channel]:
    """Return the readings that a column of units is of: those of its side, the one in front of it, and of the only such column all forces of no stated unit."""
    at = next(i for i, c in enumerate(found) if c.name == column)
    heard = [(c, _said(c)) for c in found if not c.text]
    if side := said(column).side:
        return [c for c, s in heard if s.side == side and _may_be_force(s)]
    front = found[at - 1] if at and not found[at - 1].text and said(found[at - 1].name).quantity not in ("time", "index") else None
    forces = [c for c, s in heard if s.tension and not s.unit] if alone else []
    return [*([front] if front is not None else []), *(c for c in forces if c is not front)]
