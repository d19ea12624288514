"""Units of readings that stand neither in their names nor in a row: columns beside them (``Force,Unit``, ``UnitIn``), and a line above (``Units: lb``)."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Sequence
from dataclasses import replace

from sstl_cli.core.units import is_unit, unit_of
from sstl_cli.importers.base import Channel
from sstl_cli.importers.guess_names import Said, said
from sstl_cli.importers.text_header import UNIT_ROWS, stated_unit, unit_in
from sstl_cli.importers.units_said import shown, sides_said, unit_line


def with_unit_said(found: Sequence[Channel], remarks: Iterable[str]) -> tuple[list[Channel], dict[str, str]]:
    """Return the columns with the one unit of force that lines above the table tell for what may be a force of no other unit, and what is to be asked.

    Asked are those that take it, and forces for which a line that speaks of them states another unit than they have.
    """
    stated = [(line, units) for line in remarks if (units := unit_line(line))]
    if not stated:
        return list(found), {}
    forces = [(c, s) for c in found if not c.text and may_be_force(s := said_of(c))]
    held = {u for _, units in stated for u in units}
    unit = held.pop() if len(held) == 1 else ""
    asked: dict[str, str] = {}
    if unit and unit_of(unit)[0] == "force":
        bare = [c.name for c, s in forces if not (s.unit or s.strange)]
        asked = dict.fromkeys(bare, f"a line above the table says that units are {unit}: this one's too?")
    others = {s.dimension for c in found if not c.text and not may_be_force(s := said_of(c))}
    against = {c.name: ask for c, s in forces if s.unit and (ask := _against(s, stated, others))}
    return [replace(c, unit=unit) if c.name in asked else c for c in found], asked | against


def _against(one: Said, stated: Sequence[tuple[str, tuple[str, ...]]], others: Collection[str]) -> str:
    """Return the question of a force with a unit whose line above the table states another one, an empty text where none does.

    Parameters
    ----------
    one : Said
        The force.
    stated : sequence
        Lines with the units that they state.
    others : collection of str
        Dimensions of the columns that are no forces: a line may be of these.
    """
    for line, units in stated:
        of_other = all(unit_of(u)[0] in others for u in units) or one.side not in ("", *sides_said(line))
        if not of_other and all(unit_of(u) != unit_of(one.unit) for u in units):
            return f"its column says {one.unit}, a line above the table {units[0]} ({shown(line)}): which is it?"
    return ""


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


def may_be_force(s: Said) -> bool:
    """Return whether a name says a tension, or one side and nothing of what is measured there (``proximal``)."""
    return s.tension or (bool(s.side) and s.quantity in ("force", "") and s.dimension in ("force", ""))


def said_of(channel: Channel) -> Said:
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
    heard = [(c, said_of(c)) for c in found if not c.text]
    if side := said(column).side:
        return [c for c, s in heard if s.side == side and may_be_force(s)]
    front = found[at - 1] if at and not found[at - 1].text and said(found[at - 1].name).quantity not in ("time", "index") else None
    forces = [c for c, s in heard if s.tension and not s.unit] if alone else []
    return [*([front] if front is not None else []), *(c for c in forces if c is not front)]
