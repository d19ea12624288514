"""How a text log is laid out: delimiter, decimal sign, header, units and where the data begin."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

from sstl_cli.core.errors import SstlError, printable
from sstl_cli.importers.base import MAX_CHANNELS, Layout
from sstl_cli.importers.guess_words import SIGNS, lowered
from sstl_cli.importers.instruments import Cut, Measured, Stated, labview, oscilloscope, stated_by, step_below
from sstl_cli.importers.rates_said import rate_said
from sstl_cli.importers.recorders import recorder, signal_names
from sstl_cli.importers.text_cells import MINUS, SPACES, WITHOUT_MARKS, cut, grouped_sign, is_missing, is_number, marks_known
from sstl_cli.importers.text_file import opened
from sstl_cli.importers.text_forms import NAME_OF_STAMP, Forms, forms_of, is_signed, is_united
from sstl_cli.importers.text_grouped import grouped_forms
from sstl_cli.importers.text_header import COMMENTS, names_and_units, numbered, stated_unit, table_in, unit_in
from sstl_cli.importers.text_json import AS_TABLE, is_one_value, json_forms
from sstl_cli.importers.text_stamps import are_stamps
from sstl_cli.importers.waveforms import OWN, Waveform, waveform, waveform_names

MAX_LINE_BYTES = 1 << 20
SAMPLE_LINES = 40
MAX_HEADER_LINES = 2_000
_BEGINS_NUMBER = tuple(bytes([c]) for c in b"0123456789+-.")
# of systems in China, Japan, Taiwan and Korea; the first wins where several read a line alike
EASTERN = ("gb2312", "cp932", "big5", "euc_kr")
CYRILLIC = "cp1251"
# of Cyrillic letters in it but ё
_FIRST_LETTER = 0xC0
# in a date, which alone may stand in a line of readings
_YEARS = ("年", "년")
_NAMED = {"tab": "\t", "comma": ",", "semicolon": ";", "space": SPACES, "whitespace": SPACES, " ": SPACES, "\\t": "\t"}
_COMMA_NUMBER = re.compile(r"[+-]?\d+,\d+([eE][+-]?\d+)?$")


@dataclass(frozen=True)
class TextLayout:
    """Delimiter (one character, or ``space``), names, units and first data line of a text log, and the sampling period that its header states.

    ``text`` says which columns hold no numbers, ``stamps`` which of numbers are times written as text, ``forms`` what is written beside plain cells,
    ``labels`` what a table of channels above the data calls their signals, ``waveform`` what lines of ``t0`` and ``dt`` tell of the clock,
    ``starts`` that LabVIEW's channels begin at different times, from which their columns of time count.
    """

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
    stamps: tuple[bool, ...] = ()
    forms: Forms | None = None
    labels: Mapping[str, str] = field(default_factory=dict)
    waveform: Waveform | None = None
    starts: str = ""


def _readings(rest: Sequence[bytes], wanted: Layout, path: Path) -> tuple[list[str], list[str], Forms | None]:
    """Return the first lines, the last of those that hold data, and the forms of records or labelled numbers that both were written anew from."""
    sample = [as_text(x) for x in rest]
    data = [x for x in sample if x.strip() and not x.lstrip().startswith(wanted.comment or COMMENTS)][-SAMPLE_LINES:]
    data = data[:-1] if len(data) > 2 and len(rest) > 1 and rest[-1] else data
    if not data:
        raise SstlError("holds no line of data", where=str(path), fix="check skip_rows and the file", code="E323")
    records = all(x.strip().startswith("{") and x.rstrip(" ,\t").endswith("}") for x in data)
    forms = None if wanted.delimiter is not None else json_forms(data) if records else _forms(sample, data)
    if records and forms is None:
        what = "holds JSON, one record a line, whose keys are not the same throughout"
        raise SstlError(what, where=str(path), fix=AS_TABLE, code="E323")
    if forms is not None:
        sample, data = [forms.line(x) for x in sample], [forms.line(x) for x in data]
    return sample, data, forms


def _stated(sample: list[str], by_delimiter: Cut) -> Stated | None:
    """Return the header of a recorder that tells names and units in lines of their own."""
    return stated_by(sample, by_delimiter) or recorder(sample, by_delimiter) or waveform_names(sample, by_delimiter)


def _measured(above: list[str], labview_lines: list[str], by_delimiter: Cut) -> Measured:
    """Return what the header of LabVIEW or of an oscilloscope says of the columns."""
    return labview(labview_lines, by_delimiter) if labview_lines else Measured(oscilloscope(above, by_delimiter))


def layout_of(path: Path, wanted: Layout) -> TextLayout:
    """Return the layout of a text log from its first lines; ``wanted`` overrides what is found.

    Raises
    ------
    SstlError
        If the file is binary, a line is longer than 1 MiB, or no line holds a number.
    """
    lines, line_end, start = _first_lines(path, wanted.skip_rows)
    at = header = _end_of_labview(lines, wanted.skip_rows)
    rest = lines[at:]
    if wanted.skip_rows == 0 and wanted.delimiter is None and (json := is_one_value([as_text(x) for x in lines[:SAMPLE_LINES]])):
        raise SstlError(f"holds JSON as {json}, not as one record a line", where=str(path), fix=AS_TABLE, code="E323")
    sample, data, forms = _readings(rest, wanted, path)
    delimiter = forms.delimiter if forms is not None else _NAMED.get(wanted.delimiter or "", wanted.delimiter or "") or _delimiter(data)
    by_delimiter: Cut = partial(cut, delimiter=delimiter)
    stated = _stated(sample, by_delimiter) if wanted.header is None else None
    begin = None
    if stated is not None:
        at, sample = at + stated.lines, sample[stated.lines :]
    elif wanted.header is None and at == wanted.skip_rows:
        found = table_in(sample, data, delimiter, wanted.comment or "")
        if found is not None:
            at, sample, begin = at + found[0], sample[found[0] :], found[1] - found[0]
    decimal = wanted.decimal or ("," if _decimal_comma(data, delimiter) else ".")
    head = _head(sample, wanted, delimiter, path, at, begin)
    at += head.lines
    width = len(head.first)
    if width > MAX_CHANNELS:
        raise SstlError(f"has {width} columns", where=str(path), fix=f"at most {MAX_CHANNELS} are read", code="E324")
    if stated is not None and (whole := _filled(stated, head.first)) is not None:
        (names, units), named = whole, True
    else:
        names, units, named = _named(head, forms, delimiter, path)
    above = [as_text(x) for x in lines[wanted.skip_rows : at]]
    measured = _measured(above, [as_text(x) for x in lines[:header]] if header > wanted.skip_rows else [], by_delimiter)
    units = tuple(stated or own for stated, own in zip(_known(measured.units, width), units, strict=True))
    steps = (
        measured.step_s,
        stated.step_s if stated is not None else math.nan,
        rate_said(above),
        step_below([by_delimiter(x) for x in above]),
    )
    step = next(filter(math.isfinite, steps), math.nan)
    labels = signal_names(above, names, by_delimiter)
    stamps = _stamps(head.first, [cut(line, delimiter) for line in data])
    text = tuple(not is_number(c) and not is_missing(c) and not stamp for c, stamp in zip(head.first, stamps, strict=True))
    wave = waveform(above, by_delimiter) or _wave(measured)
    position = start + sum(len(line) + len(line_end) for line in lines[:at])
    return TextLayout(
        delimiter,
        decimal,
        names,
        units,
        position,
        at + 1,
        head.comment,
        named,
        line_end,
        text,
        step,
        stamps,
        forms,
        labels,
        wave,
        measured.starts,
    )


def _wave(measured: Measured) -> Waveform | None:
    """Return the clock by LabVIEW's step, which is that by definition, as of its waveforms; None where it states none."""
    if not math.isfinite(measured.step_s):
        return None
    return Waveform(math.nan, f"{measured.starts}: {OWN}") if measured.starts else Waveform(measured.step_s)


def _forms(sample: list[str], data: list[str]) -> Forms | None:
    """Return what is written beside plain cells in the lines of a table, None where nothing is."""

    def header(delimiter: str) -> int:
        above = (cut(line, delimiter) for line in reversed(sample) if line.strip())
        return next((len(row) for row in above if not any(map(is_number, row))), 0)

    return forms_of(data, _delimiter, header) or grouped_forms(sample, _delimiter(data))


def _filled(stated: Stated, first: list[str]) -> tuple[tuple[str, ...], tuple[str, ...]] | None:
    """Return names and units that an instrument states, with those of columns that hold nothing; None where it tells of other columns."""
    more = len(first) - len(stated.names)
    if more < 0 or not all(map(is_missing, first[len(stated.names) :])):
        return None
    names = (*stated.names, *(f"col{i + 1}" for i in range(len(stated.names), len(first))))
    return numbered(names), (*stated.units, *[""] * more)


def _named(head: _Head, forms: Forms | None, delimiter: str, path: Path) -> tuple[tuple[str, ...], tuple[str, ...], bool]:
    """Return names and units of the columns: the labels in front of the numbers, else those of the header."""
    width = len(head.first)
    if forms is not None and len(forms.names) == width:
        return forms.names, tuple(stated or unit_in(n) for stated, n in zip(forms.units, forms.names, strict=True)), True
    texts = head.texts
    if forms is not None and forms.stamped:
        # what a program says while it starts has a stamp as well, and is no header
        texts = [x for x in texts if len(row := cut(x, delimiter)) == width and all(row)]
    names, units, named = names_and_units(texts, head.first, delimiter, path)
    if forms is not None and forms.stamped:
        names = numbered((NAME_OF_STAMP, *names[1:]))
    if forms is not None and len(forms.units) == width:
        units = tuple(stated or own for stated, own in zip(forms.units, units, strict=True))
    return names, units, named


def _stamps(first: list[str], rows: list[list[str]]) -> tuple[bool, ...]:
    """Return which columns hold times written as text."""
    odd = [not is_number(c) and not is_missing(c) for c in first]
    rows = [row for row in rows if len(row) == len(first)]
    return tuple(
        o and are_stamps([c, *(row[i] for row in rows if not is_missing(row[i]))]) for i, (c, o) in enumerate(zip(first, odd, strict=True))
    )


def _known(units: tuple[str, ...], width: int) -> list[str]:
    """Return units that are known for as many columns, '' for others."""
    return [stated_unit(u) or "" for u in (*units, *[""] * width)[:width]]


def _end_of_labview(lines: list[bytes], start: int) -> int:
    """Return the line behind LabVIEW's header, or ``start`` where there is none; of a file in segments the header of the first."""
    end = start
    for i, line in enumerate(lines[start:][:MAX_HEADER_LINES], start):
        if line.startswith(b"***End_of_Header***"):
            end = i + 1
        elif end > start and line.strip()[:1] in _BEGINS_NUMBER:
            # words stand in front of what a header tells: here is the table, and a header further down is another segment's
            break
    return end


@dataclass(frozen=True)
class _Head:
    """What stands before the data: how many lines, their texts, the sign of a comment, and the cells of the first line of data."""

    lines: int
    texts: list[str]
    comment: str
    first: list[str]


def _head(sample: list[str], wanted: Layout, delimiter: str, path: Path, before: int, begin: int | None) -> _Head:
    """Return the header of a text log, whose first line here is line ``before`` + 1 of the file; its first line of data, if it is known, is line ``begin``."""
    comment, texts = wanted.comment or "", []
    for i, line in enumerate(sample):
        stripped = line.strip()
        marked = next((c for c in ((comment,) if comment else COMMENTS) if stripped.startswith(c)), "")
        if marked:
            comment = marked
            texts.append(stripped.lstrip("#%/ \t"))
        elif stripped:
            cells = cut(line, delimiter)
            if wanted.header is not True and (any(is_number(c) for c in cells) if begin is None else i == begin):
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


def _no_number(path: Path, data: list[str]) -> SstlError:
    """Return why no number was found; serial plotters want a name in front of each."""
    labelled = re.search(r"[A-Za-z]\w*\s*[:=]\s*[-+]?\d", data[-1])
    if labelled:
        what, fix = f"has a name in front of every number ('{labelled[0][:24]}...')", "keep the numbers, and the names once as a header"
    elif grouped := next((c for c in re.split(r"[;\t]", data[-1]) if grouped_sign(c.strip())), ""):
        what, fix = "holds no number in its first lines", f"{WITHOUT_MARKS} (it holds {printable(grouped)!r})"
    else:
        what, fix = "holds no number in its first lines", "raise skip_rows"
    return SstlError(what, where=str(path), fix=fix, code="E323")


def _first_lines(path: Path, skip: int) -> tuple[list[bytes], bytes, int]:
    """Return the first lines in bounded memory, the line end, and the length of a byte-order mark."""
    limit = 2 * MAX_LINE_BYTES
    with opened(path) as file:
        head = file.read(limit)
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
            fix=AS_TABLE if lines[0].lstrip()[:1] in (b"[", b"{") else "this is not a text log with one sample a line",
            code="E320",
        )
    if skip and skip >= len([x for x in lines if x.strip()]):
        raise SstlError(f"has only {len(lines)} lines, {skip} are skipped", where=str(path), fix="lower skip_rows", code="E323")
    return lines[: skip + MAX_HEADER_LINES + SAMPLE_LINES], line_end, start


def as_text(line: bytes) -> str:
    """Return a line of a text log in the encoding that it seems to be in."""
    try:
        return line.decode("utf-8").replace(MINUS, "-")
    except UnicodeDecodeError:
        # of the two-byte encodings of the East, and the Cyrillic one of Windows, the one in which words of a log's header stand there
        read = {e: _read_as(line, e) for e in (*EASTERN, CYRILLIC)}
        known = {e: sum(len(sign) for sign in (*SIGNS, *_YEARS) if sign in lowered(text)) for e, text in read.items()}
        best = max(known, key=lambda e: known[e])
        if known[best]:
            return read[best]
        # Chinese systems write two bytes a character, both of them high; accents of the West hardly stand side by side
        high = re.findall(rb"[\x80-\xff]+", line)
        if all(len(run) % 2 == 0 for run in high) and any(len(run) > 2 for run in high) and read["gb2312"]:
            return read["gb2312"]
        # nor do three, in a row of letters, which Cyrillic words are
        if any(len(run) > 2 for run in high) and all(byte >= _FIRST_LETTER for run in high for byte in run) and read[CYRILLIC]:
            return read[CYRILLIC]
        return line.decode("latin-1")


def _read_as(line: bytes, encoding: str) -> str:
    """Return a line in an encoding, '' where it cannot be in that one."""
    try:
        return line.decode(encoding)
    except UnicodeDecodeError:
        return ""


def _delimiter(lines: list[str]) -> str:
    """Return the delimiter that cuts the sample into the most columns of equal number."""
    best, best_score = ",", -1.0
    for candidate in ("\t", ";", ",", SPACES):
        widths = [len(cut(line, candidate)) for line in lines]
        common = max(set(widths), key=lambda w: (widths.count(w), w))
        if common < 2 and candidate != ",":
            continue
        cells = [c for line in lines for c in cut(line, candidate)]
        numeric = sum(is_number(c) or is_missing(c) or marks_known(c)[0] != "" or is_united(c) or is_signed(c) for c in cells) / max(
            len(cells), 1
        )
        score = widths.count(common) / len(widths) * (0.2 + numeric) + (0.01 if common > 1 else 0)
        if score > best_score + 1e-9:
            best, best_score = candidate, score
    return best


def _decimal_comma(lines: list[str], delimiter: str) -> bool:
    cells = [c for line in lines for c in cut(line, delimiter)]
    # 1,501.3 tells which mark is which, 1.501 may mean either
    if (signs := {grouped_sign(c) for c in cells} - {""}) and len(signs) == 1:
        return signs == {","}
    return any(_COMMA_NUMBER.match(c) for c in cells) and not any("." in c and is_number(c) for c in cells)
