"""How a text log is laid out: delimiter, decimal sign, header, units and where the data begin."""

from __future__ import annotations

import contextlib
import csv
import math
import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from sstl_cli.core.errors import SstlError
from sstl_cli.core.units import is_unit
from sstl_cli.importers.base import MAX_CHANNELS, Layout
from sstl_cli.importers.guess_words import SIGNS, STRANGE, UNIT_CELLS
from sstl_cli.importers.instruments import Measured, labview, oscilloscope, rate_said, stated_by

MAX_LINE_BYTES = 1 << 20
SAMPLE_LINES = 40
MAX_HEADER_LINES = 2_000
SPACES = "space"
# of systems in China, Japan, Taiwan and Korea; the first wins where several read a line alike
EASTERN = ("gb2312", "cp932", "big5", "euc_kr")
_NAMED = {"tab": "\t", "comma": ",", "semicolon": ";", "space": SPACES, "whitespace": SPACES, " ": SPACES, "\\t": "\t"}
_COMMENTS = ("#", "%", "//")
_NUMBER = re.compile(r"[+-]?(\d+([.,]\d*)?|[.,]\d+)([eE][+-]?\d+)?$")
_COMMA_NUMBER = re.compile(r"[+-]?\d+,\d+([eE][+-]?\d+)?$")
MISSING = ("", "NA", "N/A", "#N/A", "NaN", "nan", "NAN", "-nan", "-NaN", "null", "NULL", "None", "1.#QNAN", "-1.#IND", "nan(ind)")
_MISSING = {m.lower() for m in MISSING} | {"inf", "-inf", "+inf"}
# what a row of units holds beside units that are known
NO_FORCE = STRANGE | {"", "-", "1", "ohm", "w", "t", "date", "k"}
# how a row of units says that a column holds a time of day or a date
_TIME_OF_DAY = re.compile(r"(?:(?:hh?|HH?)[:.](?:mm|MM)|(?:dd?|DD?|yyyy|YYYY|jjjj|JJJJ|tt|TT)[./-](?:mm?|MM?)).*")
_UNIT_IN_NAME = re.compile(r"^(.*?)\s*[\[(/_ ]\s*([^\s\])(/_\[]+)\s*[\])]?\s*$")


@dataclass(frozen=True)
class TextLayout:
    """Delimiter (one character, or ``space``), names, units and first data line of a text log, and the sampling period that its header states."""

    delimiter: str
    decimal: str
    names: tuple[str, ...]
    units: tuple[str, ...]
    first_byte: int
    first_line: int
    comment: str
    named: bool
    line_end: bytes
    text: tuple[bool, ...]
    step_s: float = math.nan


def layout_of(path: Path, wanted: Layout) -> TextLayout:
    """Return the layout of a text log from its first lines; ``wanted`` overrides what is found.

    Raises
    ------
    SstlError
        If the file is binary or UTF-16, a line is longer than 1 MiB, or no line holds a number.
    """
    lines, line_end, start = _first_lines(path, wanted.skip_rows)
    at = header = _end_of_labview(lines, wanted.skip_rows)
    rest = lines[at:]
    sample = [_decode(x) for x in rest]
    data = [x for x in sample if x.strip() and not x.lstrip().startswith(wanted.comment or _COMMENTS)][-SAMPLE_LINES:]
    data = data[:-1] if len(data) > 2 and len(rest) > 1 and rest[-1] else data
    if not data:
        raise SstlError("holds no line of data", where=str(path), fix="check skip_rows and the file", code="E323")
    delimiter = _NAMED.get(wanted.delimiter or "", wanted.delimiter or "") or _delimiter(data)
    stated = stated_by(sample, lambda line: cut(line, delimiter)) if wanted.header is None else None
    if stated is not None:
        at, sample = at + stated.lines, sample[stated.lines :]
    elif wanted.header is None and at == wanted.skip_rows:
        cut_off = _preamble(sample, data, delimiter)
        at, sample = at + cut_off, sample[cut_off:]
    decimal = wanted.decimal or ("," if _decimal_comma(data, delimiter) else ".")
    head = _head(sample, wanted, delimiter, path, at)
    at += head.lines
    width = len(head.first)
    if width > MAX_CHANNELS:
        raise SstlError(f"has {width} columns", where=str(path), fix=f"at most {MAX_CHANNELS} are read", code="E324")
    names, units, named = _names(head.texts, width, delimiter, path)
    if stated is not None and len(stated.names) == width:
        names, units, named = _numbered(stated.names), stated.units, True
    above = [_decode(x) for x in lines[wanted.skip_rows : at]]
    if header > wanted.skip_rows:
        measured = labview([_decode(x) for x in lines[:header]], lambda line: cut(line, delimiter))
    else:
        measured = Measured(oscilloscope(above, lambda line: cut(line, delimiter)))
    units = tuple(stated or own for stated, own in zip(_known(measured.units, width), units, strict=True))
    step = measured.step_s if math.isfinite(measured.step_s) else rate_said(above)
    text = tuple(not _is_number(c) and c.strip().lower() not in _MISSING for c in head.first)
    position = start + sum(len(line) + len(line_end) for line in lines[:at])
    return TextLayout(delimiter, decimal, names, units, position, at + 1, head.comment, named, line_end, text, step)


def _known(units: tuple[str, ...], width: int) -> list[str]:
    """Return units that are known for as many columns, '' for others."""
    return [_stated(u) or "" for u in (*units, *[""] * width)[:width]]


def _end_of_labview(lines: list[bytes], start: int) -> int:
    """Return the line behind LabVIEW's header, or ``start`` where there is none."""
    ends = [i for i, line in enumerate(lines[start:][:MAX_HEADER_LINES]) if line.startswith(b"***End_of_Header***")]
    return start + ends[-1] + 1 if ends else start


@dataclass(frozen=True)
class _Head:
    """What stands before the data: how many lines, their texts, the sign of a comment, and the cells of the first line of data."""

    lines: int
    texts: list[str]
    comment: str
    first: list[str]


def _head(sample: list[str], wanted: Layout, delimiter: str, path: Path, before: int) -> _Head:
    """Return the header of a text log, whose first line here is line ``before`` + 1 of the file."""
    comment, texts = wanted.comment or "", []
    for i, line in enumerate(sample):
        stripped = line.strip()
        marked = next((c for c in ((comment,) if comment else _COMMENTS) if stripped.startswith(c)), "")
        if marked:
            comment = marked
            texts.append(stripped.lstrip("#%/ \t"))
        elif stripped:
            cells = cut(line, delimiter)
            if wanted.header is not True and any(_is_number(c) for c in cells):
                return _Head(i, texts, comment, cells)
            if wanted.header is False:
                raise SstlError(
                    f"line {before + i + 1} holds no number", where=str(path), fix="raise skip_rows, or leave header out", code="E323"
                )
            texts.append(line)
            if wanted.header is True:
                following = [x for x in sample[i + 1 :] if x.strip()]
                if not following:
                    raise SstlError("holds a header and no data", where=str(path), fix="check the file", code="E323")
                return _Head(i + 1, texts, comment, cut(following[0], delimiter))
    raise _no_number(path, [x for x in sample if x.strip()])


def _preamble(sample: list[str], data: list[str], delimiter: str) -> int:
    """Return how many lines stand before the header where some of them hold numbers (an instrument's settings).

    Such lines have another width than the data, and a line of names as wide as the data follows them.
    """
    rows = [cut(line, delimiter) for line in data]
    widths = [len(row) for row in rows]
    width = max(set(widths), key=lambda w: (widths.count(w), w))
    # a line of settings as wide as the data holds fewer numbers
    usual = sorted(sum(map(_is_number, row)) for row in rows if len(row) == width)[widths.count(width) // 2]
    settings = False
    for i, line in enumerate(sample):
        cells = cut(line, delimiter)
        count = sum(map(_is_number, cells))
        numbers = count > 0
        if 2 * count >= max(usual, 1) and len(cells) == width:
            return 0
        settings = settings or numbers
        cells = _named(cells, width)
        if settings and not numbers and len(cells) == width and all(cells):
            following = [_named(cut(x, delimiter), width) for x in sample[i + 1 :] if x.strip()][:2]
            if following and all(_stated(c) is not None for c in following[0]):
                # a row of units stands between names and data
                following = following[1:]
            if following and len(following[0]) == width and any(_is_number(c) for c in following[0]):
                return i
    return 0


def cut(line: str, delimiter: str) -> list[str]:
    """Return the cells of a line, without the blanks and quotes around them."""
    cells = line.split() if delimiter == SPACES else line.split(delimiter)
    if '"' in line and delimiter != SPACES:
        with contextlib.suppress(csv.Error):
            # a delimiter between quotes is text
            return [c.strip() for c in next(csv.reader([line], delimiter=delimiter, skipinitialspace=True), [""])]
    return [c.strip().strip('"').strip() for c in cells]


def unit_in(name: str) -> str:
    """Return the unit written in a column name, as in ``Force [N]`` or ``time_ms`` (empty if none)."""
    found = _UNIT_IN_NAME.match(name)
    if not found:
        return ""
    unit = found.group(2)
    if is_unit(unit):
        return unit
    # canonical column names end in lower-case units
    return {"n": "N", "v": "V", "pa": "Pa", "mn": "mN", "kn": "kN"}.get(unit, "") if "_" in name else ""


def _no_number(path: Path, data: list[str]) -> SstlError:
    """Return why no number was found; serial plotters want a name in front of each."""
    labelled = re.search(r"[A-Za-z]\w*\s*[:=]\s*[-+]?\d", data[-1])
    if labelled:
        what, fix = f"has a name in front of every number ('{labelled[0][:24]}...')", "keep the numbers, and the names once as a header"
    else:
        what, fix = "holds no number in its first lines", "raise skip_rows"
    return SstlError(what, where=str(path), fix=fix, code="E323")


def _first_lines(path: Path, skip: int) -> tuple[list[bytes], bytes, int]:
    """Return the first lines in bounded memory, the line end, and the length of a byte-order mark."""
    limit = 2 * MAX_LINE_BYTES
    with open(path, "rb") as file:
        head = file.read(limit)
        if head[:2] in (b"\xff\xfe", b"\xfe\xff"):
            raise SstlError("is UTF-16 text", where=str(path), fix="save it as UTF-8", code="E321")
        if b"\0" in head[:65536]:
            raise SstlError("holds binary data, not text", where=str(path), fix="name its --format", code="E322")
        start = 3 if head.startswith(b"\xef\xbb\xbf") else 0
        line_end = b"\r\n" if b"\r\n" in head else b"\n" if b"\n" in head else b"\r" if b"\r" in head else b"\n"
        while head.count(line_end) < skip + SAMPLE_LINES and len(head) < 16 * limit:
            more = file.read(limit)
            if not more:
                break
            head += more
    lines = head[start:].split(line_end)
    if max(map(len, lines)) > MAX_LINE_BYTES:
        longest = max(range(len(lines)), key=lambda i: len(lines[i]))
        raise SstlError(
            f"line {longest + 1} is longer than {MAX_LINE_BYTES >> 20} MiB",
            where=str(path),
            fix="this is not a text log with one sample a line",
            code="E320",
        )
    if skip and skip >= len([x for x in lines if x.strip()]):
        raise SstlError(f"has only {len(lines)} lines, {skip} are skipped", where=str(path), fix="lower skip_rows", code="E323")
    return lines[: skip + MAX_HEADER_LINES + SAMPLE_LINES], line_end, start


def _decode(line: bytes) -> str:
    try:
        return line.decode("utf-8")
    except UnicodeDecodeError:
        # of the two-byte encodings of the East, the one in which words of a log's header stand there
        read = {e: _read_as(line, e) for e in EASTERN}
        best = max(EASTERN, key=lambda e: sum(len(sign) for sign in SIGNS if sign in read[e]))
        if any(sign in read[best] for sign in SIGNS):
            return read[best]
        # Chinese systems write two bytes a character, both of them high; accents of the West hardly stand side by side
        high = re.findall(rb"[\x80-\xff]+", line)
        if all(len(run) % 2 == 0 for run in high) and any(len(run) > 2 for run in high) and read["gb2312"]:
            return read["gb2312"]
        return line.decode("latin-1")


def _read_as(line: bytes, encoding: str) -> str:
    """Return a line in an encoding, '' where it cannot be in that one."""
    try:
        return line.decode(encoding)
    except UnicodeDecodeError:
        return ""


def _is_number(cell: str) -> bool:
    return bool(_NUMBER.match(cell.strip()))


def _delimiter(lines: list[str]) -> str:
    """Return the delimiter that cuts the sample into the most columns of equal number."""
    best, best_score = ",", -1.0
    for candidate in ("\t", ";", ",", SPACES):
        widths = [len(cut(line, candidate)) for line in lines]
        common = max(set(widths), key=lambda w: (widths.count(w), w))
        if common < 2 and candidate != ",":
            continue
        cells = [c for line in lines for c in cut(line, candidate)]
        numeric = sum(_is_number(c) or c.lower() in _MISSING for c in cells) / max(len(cells), 1)
        score = widths.count(common) / len(widths) * (0.2 + numeric) + (0.01 if common > 1 else 0)
        if score > best_score + 1e-9:
            best, best_score = candidate, score
    return best


def _decimal_comma(lines: list[str], delimiter: str) -> bool:
    cells = [c for line in lines for c in cut(line, delimiter)]
    return any(_COMMA_NUMBER.match(c) for c in cells) and not any("." in c and _is_number(c) for c in cells)


def _row_of_units(names: list[str], units: list[str]) -> bool:
    """Return whether the second row states the units of a log's own columns."""
    pairs = dict(zip(names, units, strict=False))
    return len(names) == len(units) and pairs.get("time_s") == "s" and not pairs.get("run_id", "-") and "tension_out_n" in pairs


def _stated(cell: str) -> str | None:
    """Return the unit that a cell of a row of units states, '' for one of something else or none, None where it is a name."""
    unit = cell.strip().strip("[]()").strip()
    if is_unit(unit):
        return unit
    known = UNIT_CELLS.get(unit.lower(), "")
    if _TIME_OF_DAY.fullmatch(unit):
        return ""
    return known if known else "" if unit.replace("°", "deg").lower() in NO_FORCE else None


def _names(head: list[str], width: int, delimiter: str, path: Path) -> tuple[tuple[str, ...], tuple[str, ...], bool]:
    """Return column names and units from the lines above the data; names that stand there twice are numbered."""
    plain = tuple(f"col{i + 1}" for i in range(width))
    cells = (_spoken(x, width) if delimiter == SPACES else cut(x, delimiter) for x in head)
    rows = [_named(r, width) for r in cells]
    fitting = [r for r in rows if len(r) == width or (len(r) == width - 1 and width > 2)]
    if not fitting:
        if rows and delimiter != SPACES and len(rows[-1]) > 1:
            raise SstlError(
                f"header names {len(rows[-1])} columns, the data have {width}",
                where=str(path),
                fix="correct the header, or skip it with skip_rows",
                code="E325",
            )
        return plain, ("",) * width, False
    units = [""] * width
    names = fitting[-1]
    if len(fitting) > 1 and _row_of_units(fitting[-2], names):
        # a log as export writes it, whose output may be in any unit
        return tuple(fitting[-2]), tuple(names), True
    stated = [_stated(c) for c in names]
    if len(fitting) > 1 and any(stated) and all(u is not None for u in stated):
        units = [u or "" for u in stated] + [""] * (width - len(names))
        names = fitting[-2]
    full = [name or plain[i] for i, name in enumerate([*names, *[""] * (width - len(names))])]
    return _numbered(full), tuple(u or unit_in(n) for u, n in zip(units, full, strict=True)), True


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


def _numbered(names: Sequence[str]) -> tuple[str, ...]:
    """Return names of which those that stand there twice are numbered."""
    counts = Counter(names)
    out: list[str] = []
    for name in names:
        k = 1
        while counts[name] > 1 and (f"{name}.{k}" in out or f"{name}.{k}" in counts):
            k += 1
        out.append(name if counts[name] == 1 else f"{name}.{k}")
    return tuple(out)
