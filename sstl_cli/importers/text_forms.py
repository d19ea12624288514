"""Lines that hold more than cells: a serial monitor's clock in front, a label in front of each number, a unit behind it."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from itertools import takewhile

from sstl_cli.core.units import is_unit, unit_of
from sstl_cli.importers.guess_words import STRANGE, UNIT_CELLS
from sstl_cli.importers.text_cells import SPACES, cut, is_missing

# of the last lines of a sample, how many are written in one form
MOST = 0.8
NAME_OF_STAMP = "stamp"
WITHOUT_UNITS = "write numbers without the unit behind them, and the unit once in the column's name"
_NUMBER = r"[+-]?(?:\d+(?:[.,]\d+)*|[.,]\d+)(?:[eE][+-]?\d+)?"
_VALUE = rf"{_NUMBER}|[Nn][Aa][Nn]|-?[Ii]nf|[Oo][Vv][Ff]"
# stamps in front of a line, two groups each, and how they are written as a cell
_TIME, _DATE = r"\d\d?:\d\d:\d\d(?:[.,:]\d+)?", r"\d{2,4}[-/.]\d\d[-/.]\d{2,4}"
_DATED, _TIMED = r"\g<1>T\g<2>", r"\g<1>\g<2>"
# of Arduino's serial monitor (14:03:21.050 -> ), and of a terminal in brackets
_MARKED = {
    rf"[ \t]*\[({_DATE})[ T]({_TIME})\][ \t]*(?:->)?[ \t]?": _DATED,
    rf"[ \t]*(?:\[({_TIME})\][ \t]*(?:->)?|({_TIME})[ \t]*->)[ \t]?": _TIMED,
}
# behind a blank alone a date and a time may be two columns of a table cut at blanks
_BLANK = rf"[ \t]*({_DATE})[ T]({_TIME})[ ]+(?=[-+.\d])"
# in front of labels they need no mark of their own
_PLAIN = {rf"[ \t]*({_DATE})[ T]({_TIME})(?:[ \t]*[,;\t][ \t]*|[ ]+)": _DATED, rf"[ \t]*()({_TIME})(?:[ \t]*[,;\t][ \t]*|[ ]+)": _TIMED}
_WRITTEN = {**_MARKED, **_PLAIN, _BLANK: _DATED}
_BETWEEN = r"(?:[ \t]*[,;|\t][ \t]*|[ ]+)"
# Fin:2.03, Force in = 2.03 N; a time of day has no letter in front of its colon
_CELL = rf"\s*(?:([^\W\d][^:=,;|\t]*?)\s*[:=]\s*)?({_VALUE})"
_END = r"(?:\s*[,;|\t]\s*|\s+|$)"
_UNIT_BEHIND = r"\s*([^\W\d_]{1,6}|%|°C)(?![\w:=])(?!\s*[:=])"
_LABELLED, _WITH_UNIT = re.compile(_CELL + "()" + _END), re.compile(_CELL + _UNIT_BEHIND + _END)
_UNITED = re.compile(rf"({_NUMBER})\s*([^\W\d_][^\d,;]*|%|°\w*)")
# + 2.03, as Graphtec's loggers write it
_SIGNED = re.compile(r"[+-][ ]+[\d.,]+")
# in these a label is written as well (30deg, 0.8mm): only what varies is a reading
_LABEL_DIMENSIONS = ("length", "angle")
_VARIES = 3


@dataclass(frozen=True)
class Forms:
    """How the lines of a table are written beside plain cells; a line that is written otherwise is left as it is.

    ``names`` is empty where no label stands in front of the numbers, ``units`` holds what stands behind those of each column.
    """

    pattern: re.Pattern[bytes]
    cells: bytes
    delimiter: str
    names: tuple[str, ...] = ()
    units: tuple[str, ...] = ()
    stamped: bool = False

    def undone(self, body: bytes) -> bytes:
        """Return lines (UTF-8) as a table of plain cells."""
        return self.pattern.sub(self.cells, body)

    def line(self, text: str) -> str:
        """Return one line as plain cells."""
        return self.undone(text.encode()).decode()


def forms_of(lines: Sequence[str], delimiter: Callable[[list[str]], str], header: Callable[[str], int]) -> Forms | None:
    """Return how the last lines of a sample are written beside plain cells, None where they hold nothing else.

    Parameters
    ----------
    lines : sequence of str
        Lines of the table.
    delimiter : callable
        What cuts lines into columns.
    header : callable
        How many cells the nearest line above the table has that holds no number, cut by a delimiter.
    """
    front = _front(lines, _MARKED)
    for stamp in (front,) if front else ("", _front(lines, _PLAIN)):
        if found := _with_labels(lines, stamp):
            return found
    rest = _behind(lines, front)
    by = delimiter(rest)
    if not front and _front(lines, (_BLANK,)) and delimiter(_behind(lines, _BLANK)) != SPACES:
        front, rest = _BLANK, _behind(lines, _BLANK)
        by = delimiter(rest)
    behind = _units_of([cut(line, by) for line in rest], by, header)
    if any(behind):
        quoted = any('"' in line for line in rest)
        own = tuple(u for u in behind if u is not None)
        return _forms(rf"(?m)^{front}{_cells(behind, by)}$", by, len(own), front, (), own, quoted)
    if front:
        return _forms(rf"(?m)^{front}(?=\S)", by, 0, front)
    if by != SPACES and any(is_signed(c) for line in rest[:1] for c in cut(line, by)):
        return Forms(re.compile(rf"(?m)(^|{re.escape(by)})[ ]*([+-])[ ]+(?=[\d.])".encode()), rb"\g<1>\g<2>", by)
    return None


def _front(lines: Sequence[str], patterns: Iterable[str]) -> str:
    """Return the first of the patterns that most lines begin with, an empty text where they begin with none."""
    return next((p for p in patterns if sum(re.match(p, line) is not None for line in lines) >= MOST * len(lines)), "")


def _behind(lines: Sequence[str], front: str) -> list[str]:
    """Return what stands behind the stamps of lines."""
    return [line[m.end() :] for line in lines if (m := re.match(front, line))]


def _with_labels(lines: Sequence[str], front: str) -> Forms | None:
    """Return the form of lines with labels in front of their numbers, behind a stamp or the same words in each (``INFO rig: Fin=2.03``)."""
    rest = _behind(lines, front)
    shared = "".join(c[0] for c in takewhile(lambda c: len(set(c)) == 1, zip(*rest, strict=False)))
    words = shared[: shared.rfind(" ") + 1]
    for skipped in dict.fromkeys(("", words if not re.search(r"\d", words) else "")):
        if labels := _labels_of([line[len(skipped) :] for line in rest]):
            names, units = zip(*labels, strict=True)
            body = _BETWEEN.join(_labelled(name, unit) for name, unit in labels)
            pattern = rf"(?m)^{front}[ \t]*{re.escape(skipped.lstrip())}{body}[ \t,;|]*$"
            return _forms(pattern, "\t", len(labels), front, tuple(n or f"col{i + 1 + bool(front)}" for i, n in enumerate(names)), units)
    return None


def _forms(
    pattern: str, by: str, many: int, front: str, names: tuple[str, ...] = (), units: tuple[str, ...] = (), quoted: bool = False
) -> Forms:
    sep = " " if by == SPACES else by
    first = 3 if front else 1
    one = '"\\g<{}>"' if quoted else "\\g<{}>"
    # a column whose cells are not united keeps its own quotes
    cells = [one.format(first + i) if not units or units[i] else f"\\g<{first + i}>" for i in range(many)]
    out = (_WRITTEN[front] + sep if front else "") + sep.join(cells)
    if front:
        names, units = ((NAME_OF_STAMP, *names) if names else ()), (("", *units) if units else ())
    return Forms(re.compile(pattern.encode()), out.replace("\t", "\\t").encode(), by, names, units, bool(front))


def behind_stamp(line: str) -> str:
    """Return a line without the serial monitor's clock in front of it.

    Examples
    --------
    >>> behind_stamp("10:22:33.123 -> t,Fin"), behind_stamp("t,Fin")
    ('t,Fin', 't,Fin')
    """
    return next((line[m.end() :].strip() for front in _WRITTEN if front and (m := re.match(front, line))), line)


def is_united(cell: str) -> bool:
    """Return whether a cell is a number with a unit behind it.

    Examples
    --------
    >>> is_united("2.03 lbf"), is_united("2.03"), is_united("3rd")
    (True, False, False)
    """
    found = _UNITED.fullmatch(cell)
    return found is not None and _known(found[2])


def is_signed(cell: str) -> bool:
    """Return whether a cell is a number apart from its sign (``+ 2.03``)."""
    return _SIGNED.fullmatch(cell) is not None


def _labels_of(lines: Sequence[str]) -> list[tuple[str, str]]:
    """Return label and unit of each number of a line, where most lines have the same; an empty list where they have no labels."""
    found: Counter[tuple[tuple[str, str], ...]] = Counter()
    for line in lines:
        parts, at = [], 0
        while at < len(line) and (m := _cell_at(line, at)) and m.end() > at:
            parts.append(((m[1] or "").strip(), m[3] or ""))
            at = m.end()
        if at == len(line) and any(name for name, _ in parts):
            found[tuple(parts)] += 1
    if not found:
        return []
    labels, count = found.most_common(1)[0]
    names = [n for n, _ in labels if n]
    known = all(not u or _known(u) for _, u in labels)
    return list(labels) if count >= MOST * len(lines) and len(set(names)) == len(names) and known else []


def _cell_at(line: str, at: int) -> re.Match[str] | None:
    """Return the number at a place with its label, and with the unit behind it if it is one and no word of the next label."""
    found = _WITH_UNIT.match(line, at)
    return found if found and _known(found[3]) else _LABELLED.match(line, at)


def _labelled(name: str, unit: str) -> str:
    label = rf"{re.escape(name)}[ \t]*[:=][ \t]*" if name else ""
    return rf"{label}((?:{_VALUE})?)" + (rf"[ \t]*{re.escape(unit)}" if unit else "")


def _known(unit: str) -> bool:
    """Return whether a text behind a number is a unit, of a force or of something else."""
    text = unit.strip().strip(".")
    return is_unit(text) or text.lower() in UNIT_CELLS or text.lower().replace("°", "deg") in STRANGE


def _units_of(rows: list[list[str]], by: str, header: Callable[[str], int]) -> list[str | None]:
    """Return the unit behind the numbers of each column, an empty text where there is none; None is a column of units alone, as blanks cut them off."""
    width = Counter(map(len, rows)).most_common(1)[0][0] if rows else 0
    rows = [r for r in rows if len(r) == width]
    if by == SPACES and header(by) == width:
        # the units have a column of their own
        return [""] * width
    units: list[str | None] = []
    for i in range(width):
        cells = [r[i] for r in rows if not is_missing(r[i])]
        if by == SPACES and i and cells and len(set(cells)) == 1 and _known(cells[0]) and not cells[0][0].isdigit():
            units[-1] = cells[0]
            units.append(None)
            continue
        units.append(_unit_of(cells))
    return units


def _unit_of(cells: list[str]) -> str:
    """Return the one unit behind the numbers of a column, an empty text where it holds something else."""
    found = [_UNITED.fullmatch(c) for c in cells]
    units = {m[2].strip() for m in found if m}
    # where the unit changes the cells stay text: a reading in another one is not taken for this
    if len(units) != 1 or not all(found) or not all(map(_known, units)):
        return ""
    unit = units.pop()
    plain = UNIT_CELLS.get(unit.lower(), unit)
    label = is_unit(plain) and unit_of(plain)[0] in _LABEL_DIMENSIONS
    return "" if label and len(set(cells)) < _VARIES else unit


def _cells(units: Sequence[str | None], by: str) -> str:
    """Return a pattern for a line whose columns have units behind their numbers."""
    if by == SPACES:
        parts = [
            r"(\S+)" + (rf"[ \t]+{re.escape(u)}" if i + 1 < len(units) and units[i + 1] is None else "")
            for i, u in enumerate(units)
            if u is not None
        ]
        return r"[ \t]*" + r"[ \t]+".join(parts) + r"[ \t]*"
    plain = rf'("[^"\n]*"|[^{re.escape(by)}"\n]*)'
    # a cell may be empty, but a number has its unit
    parts = [rf'[ ]*"?((?:(?:{_NUMBER})(?=[ ]*{re.escape(u)}))?)[ ]*(?:{re.escape(u)})?"?[ ]*' if u else plain for u in units]
    return re.escape(by).join(parts)
