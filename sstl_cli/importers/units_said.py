"""Units of forces as lines above a table state them (``Force unit: lbf``, ``all forces converted to newtons``), and whose they are."""

from __future__ import annotations

import re

from sstl_cli.core.errors import printable
from sstl_cli.core.units import unit_of
from sstl_cli.importers.guess_names import said
from sstl_cli.importers.rates_said import LONGEST
from sstl_cli.importers.text_header import stated_unit

# Units: lb; Force unit = lbf; Einheit;mN
_LINE = re.compile(
    r"[\W_]*(?:[^\W\d_]+[ _]+){0,2}(?:units?|einheit(?:en)?|unites?|unidad(?:es)?|unita|单位|單位|単位|단위|единиц\w*)\s*[:=;,\t]\s*\"?([^\s;,\"()]+)\"?[\s;,]*(?:\((.*)\))?",
    re.IGNORECASE,
)
# all forces in mN; values are in lbf; all loads converted to newtons
_SPOKEN = re.compile(
    r"(?:^|[\W_])(?:forces?|loads?|tensions?|kr(?:ä|ae?)fte?|last(?:en)?|efforts?|fuerzas?|forze|forza|values?|readings?|werte?|messwerte|valeurs?|valor(?:es|i)?|data|channels?|columns?|signals?|outputs?|units?)"
    r"(?=\W)[^.;:=]{0,40}?(?:\W|\b)(?:in|are|is|to|into|as|en|sind|als|nach|=|:)\s+([^\s;,.()\"]{1,12})(?![^\s;,.()\"])",
    re.IGNORECASE,
)
# of a line in a question
_SHOWN = 60
# words of lines that say a side
_WORD = re.compile(r"[^\W\d_][\w-]{2,}")


def unit_line(line: str) -> tuple[str, ...]:
    """Return the units of force or of an electrical signal that a line states for readings, none where it states none or one of another quantity.

    Examples
    --------
    >>> [unit_line(x) for x in ("# Units: lb", "Force unit: lbf (converted to N)", "# all forces converted to newtons", "# time in ms")]
    [('lb',), ('lbf', 'N'), ('newtons',), ()]
    """
    line = line[:LONGEST]
    whole = _LINE.fullmatch(line)
    told = [whole[1], *re.findall(r"[^\s,;.()]+", whole[2] or "")] if whole else [m[1] for m in _SPOKEN.finditer(line)]
    units = [u for cell in told if (u := stated_unit(cell))]
    return tuple(u for u in units if unit_of(u)[0] in ("force", "voltage", "count"))


def sides_said(line: str) -> frozenset[str]:
    """Return the sides of a transmission that words of a line say, both where it says none.

    Examples
    --------
    >>> sorted(sides_said("# Zero offset Fin: 0.35 N")), sorted(sides_said("# all forces in mN"))
    (['in'], ['in', 'out'])
    """
    told = {said(word).side for word in _WORD.findall(line)} - {""}
    return frozenset(told or {"in", "out"})


def shown(line: str) -> str:
    """Return a line as a question quotes it.

    Examples
    --------
    >>> shown("# Tare: 0.35 N")
    "'Tare: 0.35 N'"
    """
    return repr(printable(line.strip(" \t#%;,'\"")[:_SHOWN]))
