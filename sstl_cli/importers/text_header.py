"""The rows above a table of numbers: where they begin, and which of them holds the names and which the units."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

from sstl_cli.core.errors import SstlError
from sstl_cli.core.units import is_unit
from sstl_cli.importers.guess_words import STRANGE, UNIT_CELLS, as_volts, unaccented, words
from sstl_cli.importers.text_cells import SPACES, cut, is_missing, is_number

COMMENTS = ("#", "%", "//")
# what a row of units holds beside units that are known
NO_FORCE = STRANGE | {"", "-", "1", "ohm", "w", "t", "date", "k", "ampere", "amperes", "amps"}
# how a row of units says that a column holds a time of day or a date
_TIME_OF_DAY = re.compile(r"(?:(?:hh?|HH?)[:.](?:mm|MM)|(?:dd?|DD?|yyyy|YYYY|jjjj|JJJJ|tt|TT)[./-](?:mm?|MM?)).*")
_UNIT_IN_NAME = re.compile(r"^(.*?)\s*[\[(/_ ]\s*([^\s\])(/_\[]+)\s*[\])]?\s*$")
# m/s2, rpm
_UNIT_LIKE = re.compile(r"\S{1,3}|\S*[/*·^]\S*")
# what a row of data types holds: DT_DOUBLE, float64, REAL64, [double], DBL, f8, datetime64[ns]
_TYPE = re.compile(
    r"[\[(<]?(?:dt_)?(?:u?int(?:eger)?|u?long|u?short|l?real|float|double|single|dbl|sgl|ext|numeric|number|decimal|u?s?byte|bool(?:ean)?|d?word|"
    r"string|str|text|char|varchar|object|date|time|datetime|timestamp|f[48]|[iu][1248])_?\d*(?:\[\w+\])?[\])>]?",
    re.IGNORECASE,
)
# Unit: N, Type: double, Interp: linear, as Simulink's inspector writes below the names
_SPOKEN = re.compile(r"([^\W\d_]+)\s*[:=]\s*(.*)")
# how the first cell of a row says what the row tells of each column (ControlDesk, DIAdem, catman)
UNIT_ROWS = words("unit units einheit einheiten unite unites unidad unidades unita dimension")
NAME_ROWS = words("name names signal signals signalname channel channels kanal kanalname variable variables trace_name nom nombre nome")
# in front of a row that a program computed of the samples
STATISTICS = words(
    "mean average avg peak max maximum min minimum std stdev stddev sd median sum total count rms range var variance "
    "mittelwert mittel durchschnitt standardabweichung stabw moyenne ecart media promedio desviacion deviazione massimo minimo maximo"
)
# how a row of units says that a column numbers the samples
COUNTED = words("sequence no nr n # sample samples point points")
# of the readings of a column, how many are numbers, and how many rows of numbers in a row are a table of their own
NUMERIC, RUN_ROWS = 0.8, 3
# of a letter for a name, with its index
MOST_LETTERS = 3
# larger numbers in a first row are readings beside a damaged one
MOST_CHANNELS = 64


def table_in(sample: Sequence[str], data: Sequence[str], delimiter: str, comment: str) -> tuple[int, int] | None:
    """Return the first row of the header and the first of the table, where lines before them hold numbers too (an instrument's settings).

    The table is what has the width of the data and numbers in the same columns; the header is what stands directly above it.

    Parameters
    ----------
    sample : sequence of str
        The first lines of the file.
    data : sequence of str
        The last of them, which are of the table.
    comment : str
        The sign of a comment, empty where it is not known.
    """
    rows = [cut(line, delimiter) for line in data]
    width = Counter(map(len, rows)).most_common(1)[0][0]
    rows = [row for row in rows if len(row) == width]
    numeric = [i for i in range(width) if sum(is_number(r[i]) or is_missing(r[i]) for r in rows) >= NUMERIC * len(rows)]
    numeric = [i for i in numeric if any(is_number(r[i]) for r in rows)]
    plain = [
        (i, cut(line, delimiter)) for i, line in enumerate(sample) if line.strip() and not line.lstrip().startswith(comment or COMMENTS)
    ]

    empty = [i for i in range(width) if all(is_missing(r[i]) for r in rows)]

    def fits(row: list[str]) -> bool:
        same = (
            len(row) == width and all(is_number(row[k]) or is_missing(row[k]) for k in numeric) and all(is_missing(row[k]) for k in empty)
        )
        return same and any(map(is_number, row))

    first = next((i for i, row in plain if any(map(is_number, row))), len(sample))
    begin = (
        next((i for k, (i, row) in enumerate(plain) if fits(row) and not _header_follows(plain[k + 1 :][:1], width)), 0) if numeric else 0
    )
    if begin <= first:
        return None
    if any(_folded(row[0]) in UNIT_ROWS for i, row in plain if i < begin) and 0 in (*numeric, *empty):
        # rows of a header that say in their first cells what they tell, of which some tell numbers (a rate, a scale)
        return next(i for i, row in plain if _folded(row[0]) in UNIT_ROWS | NAME_ROWS), begin
    start = _above(sample, begin, width, delimiter, empty)
    skipped = [row for i, row in plain if i < start]
    # another table of numbers, such as one of a logger that began anew, is not left out without a word
    return None if start == begin or _is_table(skipped) else (start, begin)


def _header_follows(following: Sequence[tuple[int, list[str]]], width: int) -> bool:
    """Return whether a row of names stands below another, which is no reading then (LabVIEW's ``delta t``)."""
    return any(
        len(row) == width and all(row) and not any(c[0].isdigit() or is_number(c) or is_missing(c) for c in row) for _, row in following
    )


def statistic(cells: Sequence[str]) -> str:
    """Return the word for a statistic that stands in front of a row of numbers (``Std. Dev.``), an empty text where none does.

    Examples
    --------
    >>> statistic(["Max:", "3.1", "2.9"]), statistic(["Max", "Min"]), statistic(["0.01", "3.1"])
    ('Max', '', '')
    """
    name = cells[0].strip(" :.") if cells else ""
    first = re.match(r"[^\W\d_]+", unaccented(name.lower()))
    return name if first and first[0] in STATISTICS and any(map(is_number, cells[1:])) else ""


def _above(sample: Sequence[str], begin: int, width: int, delimiter: str, empty: Sequence[int]) -> int:
    """Return the first of the rows of names and units that stand directly above a table, ``begin`` where none does; ``empty`` are the columns without readings."""
    start, named = begin, False
    for i in range(begin - 1, -1, -1):
        if not sample[i].strip():
            if named:
                break
            continue
        row = _padded(_cells(sample[i], width, delimiter), width, empty)
        if len(row) == width and statistic(row):
            # computed of the samples, and written before them
            continue
        if len(row) != width or not any(row):
            break
        # where no reading stands a number is a setting (an oscilloscope's increment)
        if any(is_number(c) for k, c in enumerate(row) if k not in empty):
            # an oscilloscope numbers its channels; below a row of names it would be a damaged reading
            above = _cells(sample[i - 1], width, delimiter) if i else []
            return i if not named and _counted(row) and len(above) != width else start
        start, named = i, named or not _states_units(row)
    return start


def _counted(row: list[str]) -> bool:
    """Return whether a row is a word and then numbers that go up by whole steps, as channels are numbered."""
    numbers = [int(c) for c in row[1:] if c.isdigit()]
    if not row[0] or is_number(row[0]) or len(numbers) < len(row) - 1:
        return False
    return sorted(set(numbers)) == numbers and numbers[-1:] <= [MOST_CHANNELS]


def _is_table(rows: list[list[str]]) -> bool:
    """Return whether some rows that follow one another hold readings alone (numbers, times of day), as many each."""
    run, last = 0, 0
    for row in rows:
        count = len(row) if len(row) > 1 and all(is_number(c) or c[:1].isdigit() for c in row) else 0
        run = run + 1 if count and count == last else int(bool(count))
        last = count
        if run >= RUN_ROWS:
            return True
    return False


def unit_in(name: str) -> str:
    """Return the unit written in a column name, as in ``Force [N]`` or ``time_ms`` (empty if none)."""
    found = _UNIT_IN_NAME.match(as_volts(name))
    if not found:
        return ""
    unit = found.group(2)
    if is_unit(unit):
        return unit
    # canonical column names end in lower-case units
    return {"n": "N", "v": "V", "pa": "Pa", "mn": "mN", "kn": "kN"}.get(unit, "") if "_" in name else ""


def _row_of_units(names: list[str], units: list[str]) -> bool:
    """Return whether the second row states the units of a log's own columns."""
    pairs = dict(zip(names, units, strict=False))
    return len(names) == len(units) and pairs.get("time_s") == "s" and not pairs.get("run_id", "-") and "tension_out_n" in pairs


def stated_unit(cell: str) -> str | None:
    """Return the unit that a cell of a row of units states, '' for one of something else or none, None where it is a name."""
    unit = as_volts(cell.strip().strip("[]()").strip())
    if (spoken := _SPOKEN.fullmatch(unit)) and _folded(spoken[1]) in UNIT_ROWS:
        unit = spoken[2].strip()
    # "in N", as one says it in German and French
    unit = re.sub(r"^(?:in|en)\s+(?=\S)", "", unit)
    if is_unit(unit):
        return unit
    known = UNIT_CELLS.get(unit.lower(), "")
    if _TIME_OF_DAY.fullmatch(unit):
        return ""
    return known if known else "" if unit.replace("°", "deg").lower() in NO_FORCE else None


def names_and_units(head: list[str], first: list[str], delimiter: str, path: Path) -> tuple[tuple[str, ...], tuple[str, ...], bool]:
    """Return column names and units from the lines above the data, whose first row is given; names that stand there twice are numbered."""
    width = len(first)
    plain = tuple(f"col{i + 1}" for i in range(width))
    empty = [i for i, c in enumerate(first) if is_missing(c)]
    rows = [_padded(_cells(x, width, delimiter), width, empty) for x in head]
    fitting = [r for r in rows if (len(r) == width or (len(r) == width - 1 and width > 2)) and not statistic(r)]
    # above a row of names as wide as the table a narrower one is no header (the model of a gauge, its unit)
    whole = next((k for k, r in enumerate(fitting) if len(r) == width and not _states_units(r)), 0)
    fitting = [r for k, r in enumerate(fitting) if k >= whole or len(r) == width]
    # settings stand where no reading does
    fitting = [["" if is_number(c) and is_missing(f) else c for c, f in zip(r, first, strict=False)] for r in fitting]
    if not fitting:
        if rows and delimiter != SPACES and len(rows[-1]) > 1:
            raise SstlError(
                f"header names {len(rows[-1])} columns, the data have {width}",
                where=str(path),
                fix="correct the header, or skip it with skip_rows",
                code="E325",
            )
        return plain, ("",) * width, False
    if len(fitting) > 1 and _row_of_units(fitting[-2], fitting[-1]):
        # a log as export writes it, whose output may be in any unit
        return tuple(fitting[-2]), tuple(fitting[-1]), True
    names, below = _chosen(fitting, [i for i, c in enumerate(first) if is_number(c)])
    # a ratio is no volt, and never newtons
    units = [stated_unit(c) or (c.strip("[]() ") if "/" in c and stated_unit(c) == "" else "") for c in below] + [""] * (width - len(below))
    full = [name or plain[i] for i, name in enumerate([*names, *[""] * (width - len(names))])]
    return numbered(full), tuple(u or unit_in(n) for u, n in zip(units, full, strict=True)), True


def _chosen(rows: list[list[str]], numeric: list[int]) -> tuple[list[str], list[str]]:
    """Return which of the rows above the data holds the names, and which the units (empty: none).

    Names stand directly above their units, whatever stands below (the type or the hardware of each column).
    """
    # a row of types alone is better than no names
    rows = [r for r in rows if not (all(_TYPE.fullmatch(c) for c in r if c) or _says(r) not in ("", *UNIT_ROWS))] or rows
    if labelled := _labelled(rows):
        return labelled
    at = next((i for i in range(len(rows) - 1, 0, -1) if _states_units(rows[i]) or _units_of_numbers(rows[i], numeric)), 0)
    if at:
        # names stand above the places of the signals in a model
        named = at > 1 and _are_places(rows[at - 1]) and len(set(rows[at - 2])) == len(rows[at - 2]) and not _are_places(rows[at - 2])
        named = named or (at > 1 and _are_short(rows[at - 1], rows[at - 2]))
        return rows[at - 2 if named else at - 1], rows[at]
    last = rows[-1]
    if 2 * len(set(last)) > len(last):
        return last, []
    return max(reversed(rows), key=lambda r: len(set(filter(None, r)))), []


def _says(row: list[str]) -> str:
    """Return the word in front of each cell of a row (``Type: double``), an empty text where they have none in common."""
    found = [_SPOKEN.fullmatch(c) for c in row if c]
    words = {_folded(m[1]) if m else "" for m in found}
    return words.pop() if len(words) == 1 and len(found) > 1 else ""


def _labelled(rows: list[list[str]]) -> tuple[list[str], list[str]] | None:
    """Return the rows of names and units that say so in their first cells, None where none says that it holds units."""
    first = [_folded(r[0]) for r in rows]
    units = next((r for r, word in zip(rows, first, strict=True) if word in UNIT_ROWS and any(map(stated_unit, r[1:]))), None)
    if units is None:
        return None
    named = next((r for r, word in zip(rows, first, strict=True) if word in NAME_ROWS), None)
    above = [r for r in rows[: rows.index(units)] if not _are_places(r)]
    names = named or (above[-1] if above else None)
    return (names, ["", *units[1:]]) if names is not None else None


def _are_places(row: list[str]) -> bool:
    """Return whether most cells of a row are paths of a block diagram."""
    filled = [c for c in row if c]
    return 2 * sum("/" in c and not stated_unit(c) for c in filled) > len(filled)


def _are_short(row: list[str], above: list[str]) -> bool:
    """Return whether the cells of a row are the letters of formulas for the names above them (Logger Pro: ``Time``, ``t``, ``s``)."""
    whole = len(row) == len(above) == len(set(above)) and all(row) and not any(map(is_number, above))
    return whole and all(len(c) <= MOST_LETTERS and len(c) < len(a) and c[0].lower() in a.lower() for c, a in zip(row, above, strict=True))


def _folded(word: str) -> str:
    """Return a word in small letters without accents and a colon behind it."""
    return unaccented(word.strip(" :").lower())


def _states_units(row: list[str]) -> bool:
    """Return whether a row holds units: known ones, or of whatever, and of some columns others that are written like one."""
    cells = [stated_unit(c) for c in row]
    known = sum(bool(c) for c in cells)
    odd = all(c is not None or _UNIT_LIKE.fullmatch(r) for c, r in zip(cells, row, strict=True))
    return known > 0 and (None not in cells or (odd and 2 * known > len(cells)))


def _units_of_numbers(row: list[str], numeric: list[int]) -> bool:
    """Return whether a row holds units above every column of numbers (or that it counts), whatever stands above the others."""
    cells = [row[i] for i in numeric if i < len(row)]
    stated = [stated_unit(c) for c in cells]
    return sum(map(bool, stated)) > 1 and all(u is not None or _folded(c).strip(".") in COUNTED for u, c in zip(stated, cells, strict=True))


def _cells(line: str, width: int, delimiter: str) -> list[str]:
    """Return the cells of a row of the header, which may stand in a comment."""
    return _named(_spoken(line, width) if delimiter == SPACES else cut(line, delimiter), width)


def _padded(row: list[str], width: int, empty: Sequence[int]) -> list[str]:
    """Return a row of the header with cells for the columns at its end that no reading has, and without those behind the last such column.

    Readings that end in a delimiter with nothing behind it were cut short there (an oscilloscope's columns of settings).
    """
    if len(row) > width and width - 1 in empty:
        return row[:width]
    return [*row, *[""] * (width - len(row))] if len(row) > 1 and set(range(len(row), width)) <= set(empty) else row


def _named(cells: list[str], width: int) -> list[str]:
    """Return the cells of a line of names without those that no column of data has: empty ones at its end, and LabVIEW's for comments."""
    while len(cells) > width and cells[-1] in ("", "Comment"):
        cells = cells[:-1]
    return cells


def _spoken(line: str, width: int) -> list[str]:
    """Return the names of a header cut at blanks: where these stand within names, at two of them, or with each bracket beside its name."""
    for cells in (re.split(r"\s{2,}|\t", line.strip()), re.findall(r"\S+(?:\s+[\[(][^\s\])]*[\])])?", line)):
        if len(cells) == width:
            return cells
    return cut(line, SPACES)


def numbered(names: Sequence[str]) -> tuple[str, ...]:
    """Return names of which those that stand there twice are numbered."""
    counts = Counter(names)
    out: list[str] = []
    for name in names:
        k = 1
        while counts[name] > 1 and (f"{name}.{k}" in out or f"{name}.{k}" in counts):
            k += 1
        out.append(name if counts[name] == 1 else f"{name}.{k}")
    return tuple(out)
