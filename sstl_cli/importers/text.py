"""CSV, TSV and whitespace text, with or without header, streamed in blocks of bounded size."""

from __future__ import annotations

import re
import sys
from collections.abc import Collection, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import IO

import numpy as np
import pyarrow as pa
import pyarrow.csv as pc

from sstl_cli.core.errors import SstlError, printable
from sstl_cli.core.runs import ahead
from sstl_cli.importers.base import Block, Channel, Layout, Notes, Values
from sstl_cli.importers.text_blocks import NAME, SIGN, head_of, labels_of_block, labels_told, parts_of
from sstl_cli.importers.text_cells import MINUS, MISSING, SPACES, WITHOUT_MARKS, cut, grouped_sign, is_number
from sstl_cli.importers.text_file import opened, wide_encoding
from sstl_cli.importers.text_footer import Footer, footer_of
from sstl_cli.importers.text_layout import MAX_LINE_BYTES, TextLayout, as_text, layout_of
from sstl_cli.importers.text_mend import again, blanks, how_to_mend, readable
from sstl_cli.importers.text_stamps import StampReader

ID = "text"
TITLE = "CSV, TSV or whitespace text"
EXTENSIONS = (".csv", ".tsv", ".txt", ".dat", ".log", ".asc", ".lvm")
RANK = 90
BLOCK_BYTES = 4 << 20
# comments between samples that are looked at
MAX_REMARKS = 1_000
# the blanks that a spreadsheet writes between thousands, which are also cut at as blanks
_NARROW = re.compile(r"[+-]?\d{1,3}(?:[\u00a0\u202f\u2009]\d{3})+(?:[.,]\d*)?")
_TOO_LONG = f"a line is longer than {MAX_LINE_BYTES >> 20} MiB"


def sniff(head: bytes, path: Path) -> bool:
    """Return whether the head is text: no zero byte, hardly any control character."""
    if not head or b"\0" in head:
        return bool(wide_encoding(head)) and path.suffix.lower() in EXTENSIONS
    control = sum(head.count(bytes([c])) for c in range(32) if c not in (9, 10, 12, 13))
    return control <= len(head) // 1000 and any(48 <= c <= 57 for c in head)


def channels(path: Path, layout: Layout) -> list[Channel]:
    """Return the columns of the text: names from its header, else ``col1`` to ``colN``."""
    found = layout_of(path, layout)
    table = zip(found.names, found.units, found.text, found.stamps, strict=True)
    columns = [Channel(n, None, "s" if stamps else u, text=t, label=found.labels.get(n, ""), stamps=stamps) for n, u, t, stamps in table]
    told = [NAME, *(f"{SIGN}{label}" for label in labels_told(layout))] if layout.blocks else []
    return [*columns, *(Channel(n, text=True) for n in told)]


def require_once(name: str, names: Collection[str], where: str) -> None:
    """Raise SstlError if a header holds a name more than once (its columns are numbered then)."""
    if name not in names and f"{name}.1" in names and f"{name}.2" in names:
        raise SstlError(
            f"column '{name}' stands in the header more than once",
            where=where,
            fix=f"rename all but one, or say in the mapping which is meant: '{name}.1', '{name}.2', ...",
            code="E329",
        )


def read(path: Path, numbers: list[str], labels: list[str], layout: Layout, notes: Notes) -> Iterator[Block]:
    """Yield blocks of the named columns.

    Raises
    ------
    SstlError
        With the line number, for text in a number column, a line of another width, or one too long.
    """
    found = layout_of(path, layout)
    of_block = [n for n in labels if layout.blocks and n.startswith(SIGN) and n not in found.names]
    labels = [n for n in labels if n not in of_block]
    if not numbers and not labels:
        # rows are counted in a column
        labels = list(found.names[:1])
    wanted = list(dict.fromkeys([*numbers, *labels]))
    stamps = [n for n, stamped in zip(found.names, found.stamps, strict=True) if stamped and n in numbers]
    types = {n: pa.binary() if n in stamps else pa.float64() for n in numbers} | {n: pa.binary() for n in labels if n not in numbers}
    delimiter = "\t" if found.delimiter == SPACES else found.delimiter
    # a lone quote can only be damage where every wanted cell is a number
    parse = pc.ParseOptions(delimiter=delimiter, ignore_empty_lines=True, quote_char='"' if found.delimiter != SPACES else False)
    convert = pc.ConvertOptions(
        column_types=types,
        include_columns=wanted,
        null_values=list(MISSING),
        strings_can_be_null=True,
        decimal_point=found.decimal,
        check_utf8=False,
    )
    rows = _Rows(path, found, parse, convert, numbers, labels, notes)
    yield from ahead(_stacked(rows, layout, of_block) if layout.blocks else _blocks(rows))


@dataclass(frozen=True)
class _Rows:
    """What turns lines of a text log into columns."""

    path: Path
    found: TextLayout
    parse: pc.ParseOptions
    convert: pc.ConvertOptions
    numbers: list[str]
    labels: list[str]
    notes: Notes

    def stamps(self) -> dict[str, StampReader]:
        """Return a reader for each column of times written as text, which begins anew."""
        found = self.found
        return {n: StampReader() for n, stamped in zip(found.names, found.stamps, strict=True) if stamped and n in self.numbers}

    def columns(self, raw: bytes, offset: int, last: bool, stamps: dict[str, StampReader]) -> dict[str, Values]:
        """Return the columns of lines that begin at a byte, none where no line holds anything."""
        body = _normal(raw, self.found)
        if last:
            body = _whole_lines(body, self.found, self.notes)
        if not body.strip():
            return {}
        table = _parse(body, self.found, self.parse, self.convert, self.path, offset)
        try:
            block: dict[str, Values] = {
                n: stamps[n].seconds(_texts(table.column(n))) if n in stamps else _numbers(table.column(n)) for n in self.numbers
            }
        except ValueError as error:
            raise _no_time(str(error), body, self.path, _line_at(self.path, self.found, offset)) from None
        return block | {n: _strings(table.column(n)) for n in self.labels if n not in self.numbers}


def _blocks(rows: _Rows) -> Iterator[Block]:
    with opened(rows.path) as file:
        file.seek(rows.found.first_byte)
        footer = _footer(rows)
        stamps = rows.stamps()
        for raw, offset, last in pieces(file, rows.found, rows.path, footer.end):
            position = file.tell()
            if columns := rows.columns(raw, offset, last, stamps):
                yield Block(columns, position)


def _footer(rows: _Rows) -> Footer:
    """Return the rows of statistics at the end of a file, which are counted."""
    footer = footer_of(rows.path, rows.found)
    rows.notes.aside(f"rows of statistics below the samples ({', '.join(footer.names)})", len(footer.names))
    return footer


def _stacked(rows: _Rows, layout: Layout, of_block: list[str]) -> Iterator[Block]:
    """Yield the rows of blocks below each other with what the channels ``of_block`` tell of each."""
    path, found = rows.path, rows.found
    head = head_of(path, found)
    if head is None:
        fix = "take blocks out of the mapping, or split the file into one for each"
        raise SstlError("has no header row that could begin another block", where=str(path), fix=fix, code="E323")
    with opened(path) as file:
        file.seek(found.first_byte)
        stamps, told = rows.stamps(), dict[str, str]()
        for part in parts_of(pieces(file, found, path, _footer(rows).end), head, found, path, rows.notes):
            if part.first:
                # a clock goes over midnight within a block
                stamps, told = rows.stamps(), labels_of_block(part, layout, path)
            if columns := rows.columns(part.body, part.offset, part.last, stamps):
                block = Block(columns, file.tell())
                block.columns |= {c: pa.repeat(pa.scalar(told[c], pa.string()), len(block)) for c in of_block}
                yield block


def _no_time(cell: str, body: bytes, path: Path, line: int) -> SstlError:
    """Return the error of a cell that is no time in a column of times written as text; ``line`` is the number of the first line of its block."""
    line += next((i for i, raw in enumerate(body.split(b"\n")) if cell in as_text(raw)), 0)
    what = f"holds {printable(cell[:40])!r} in a column of times"
    return SstlError(what, where=f"{path}, line {line}", fix="correct the value, or leave it empty for 'not measured'", code="E328")


def pieces(file: IO[bytes], found: TextLayout, path: Path, stop: int) -> Iterator[tuple[bytes, int, bool]]:
    """Yield byte blocks that end at a line end (all line ends become a line feed), where they begin, and the last."""
    rest = b""
    end = found.line_end
    offset = found.first_byte
    while True:
        data = file.read(max(0, min(BLOCK_BYTES, stop - file.tell())))
        rest = rest + data
        if not data:
            if rest:
                yield rest if end == b"\n" else rest.replace(end, b"\n"), offset, True
            return
        at = rest.rfind(end)
        if at < 0:
            if len(rest) > MAX_LINE_BYTES:
                raise _too_long(path, found, offset)
            continue
        piece, rest = rest[: at + len(end)], rest[at + len(end) :]
        if len(rest) > MAX_LINE_BYTES:
            raise _too_long(path, found, offset + len(piece))
        yield piece if end == b"\n" else piece.replace(end, b"\n"), offset, False
        offset += len(piece)


def _too_long(path: Path, found: TextLayout, offset: int) -> SstlError:
    what = f"line {_line_at(path, found, offset)}: {_TOO_LONG}"
    return SstlError(what, where=str(path), fix="the file is damaged", code="E320")


def _line_at(path: Path, found: TextLayout, offset: int) -> int:
    """Return the number of the line that begins at a byte; lines are counted only where one is wrong."""
    line, left = found.first_line, offset - found.first_byte
    with opened(path) as file:
        file.seek(found.first_byte)
        while left > 0:
            data = file.read(min(left, BLOCK_BYTES))
            if not data:
                break
            # a carriage return and its line feed may stand on either side of the cut
            line += data.count(found.line_end[-1:])
            left -= len(data)
    return line


def _normal(body: bytes, found: TextLayout) -> bytes:
    """Return the block as plain cells without comment lines and, for whitespace text, with one tab between columns."""
    if found.forms is not None:
        body = found.forms.undone(body)
    if found.comment and found.comment.encode() in body:
        body = re.sub(rb"(?m)^[ \t]*" + re.escape(found.comment.encode()) + rb".*$", b"", body)
    if MINUS.encode() in body:
        body = re.sub(MINUS.encode() + rb"(?=[\d.,])", b"-", body)
    if found.delimiter == SPACES:
        body = body.replace(b"\t", b" ")
        while b"  " in body:
            body = body.replace(b"  ", b" ")
        body = body.replace(b"\n ", b"\n").replace(b" \n", b"\n").strip(b" ").replace(b" ", b"\t")
    return body


def _whole_lines(body: bytes, found: TextLayout, notes: Notes) -> bytes:
    """Set aside a last line that was cut off in the middle (no line end and too few columns)."""
    if body.endswith(b"\n"):
        return body
    at = body.rfind(b"\n") + 1
    cells = cut(body[at:].decode("latin-1"), "\t" if found.delimiter == SPACES else found.delimiter)
    if body[at:].strip() and len(cells) < len(found.names):
        notes.aside("last line cut off in the middle", 1)
        return body[:at]
    return body


def _parse(body: bytes, found: TextLayout, parse: pc.ParseOptions, convert: pc.ConvertOptions, path: Path, offset: int) -> pa.Table:
    options = pc.ReadOptions(column_names=list(found.names), use_threads=False, block_size=max(len(body) + 1, 1024))
    try:
        return pc.read_csv(pa.py_buffer(body), options, parse, convert)
    except (pa.ArrowException, UnicodeDecodeError) as error:
        line = _line_at(path, found, offset)
        _explain(body, found, convert, path, offset)
        raise SstlError(
            f"cannot be read near line {line} ({' '.join(str(error).split())[:100]})",
            where=str(path),
            fix="correct or remove the line",
            code="E326",
        ) from None


def _explain(body: bytes, found: TextLayout, convert: pc.ConvertOptions, path: Path, begin: int) -> None:
    """Raise the error with the line and the column that the fast parser stumbled over."""
    delimiter = "\t" if found.delimiter == SPACES else found.delimiter
    width, line = len(found.names), _line_at(path, found, begin)
    checked = [(i, n) for i, n in enumerate(found.names) if n in convert.include_columns and pa.types.is_floating(convert.column_types[n])]
    for offset, raw in enumerate(body.split(b"\n")):
        text = as_text(raw)
        if not text.strip():
            continue
        cells = cut(text, delimiter)
        where = f"{path}, line {line + offset}"
        if len(cells) != width:
            if narrow := _NARROW.search(text):
                what = f"holds {blanks(narrow[0])!r} with a blank between thousands"
                raise SstlError(what, where=where, fix=WITHOUT_MARKS, code="E328")
            what, fix = f"has {len(cells)} columns, the lines before have {width}", "correct or remove the line, or raise skip_rows"
            if found.forms is not None and text.lstrip().startswith("{"):
                what, fix = (
                    "holds a record with other keys than those before",
                    "give every record the same keys, null where nothing was read",
                )
            elif 2 * sum(map(is_number, cells)) < sum(c.strip() != "" for c in cells):
                # what says how a block was recorded may hold a number or two
                fix = "it holds words: where another table begins, split the file there, else remove the line"
            raise SstlError(what, where=where, fix=fix, code="E327")
        for i, name in checked:
            if i < len(cells) and not readable(cells[i], found.decimal):
                cell = _as_written(path, begin, offset, cells[i], found)
                raise SstlError(
                    f"column '{name}' holds {printable(blanks(cell[:40]))!r}, not a number",
                    where=where,
                    fix=again(cells, found.names) if cell == name else how_to_mend(cell),
                    code="E328",
                )


def _as_written(path: Path, begin: int, number: int, cell: str, found: TextLayout) -> str:
    """Return a cell of a line, so many behind the one at a byte, as the file holds it, where the line was written anew to be read."""
    if found.forms is None:
        return cell
    with opened(path) as file:
        file.seek(begin)
        lines = file.read(BLOCK_BYTES + MAX_LINE_BYTES).split(found.line_end)
    written = as_text(lines[number]) if number < len(lines) else ""
    anew = dict(zip(cut(found.forms.line(written), found.delimiter), cut(written, found.delimiter), strict=False))
    return cell if cell in written else anew.get(cell, written.strip())


def grouped_in(path: Path) -> str:
    """Return the first cell of a text log with both a mark between thousands and a decimal sign, '' where no line of its beginning has one."""
    return next((blanks(c) for c in _first_cells(path) if grouped_sign(c)), "")


def _first_cells(path: Path) -> Iterator[str]:
    """Yield the cells of the beginning of a text log."""
    return (c for row in first_rows(path)[1] for c in row)


def first_rows(path: Path) -> tuple[tuple[str, ...], Iterator[list[str]]]:
    """Return the names of a text log's columns and the cells of its first rows as they are written."""
    found = layout_of(path, Layout())
    with opened(path) as file:
        file.seek(found.first_byte)
        body = file.read(BLOCK_BYTES).replace(found.line_end, b"\n")
    lines = (found.forms.undone(body) if found.forms is not None else body).split(b"\n")
    return found.names, ([c.strip() for c in cut(as_text(line), found.delimiter)] for line in lines)


def remarks(path: Path) -> list[str]:
    """Return the lines above the samples that are not those of the columns' names."""
    found = layout_of(path, Layout())
    with opened(path) as file:
        above = file.read(found.first_byte).split(found.line_end)
    lines = map(as_text, above)
    # a comment without the sign between cells may speak of two columns
    return [line for line in lines if sum(n in line for n in found.names) < 2 or (found.delimiter.strip() and found.delimiter not in line)]


def remarks_within(path: Path) -> list[str]:
    """Return the comments between the samples, each once."""
    found = layout_of(path, Layout())
    if not found.comment:
        return []
    told: dict[str, None] = {}
    with opened(path) as file:
        file.seek(found.first_byte)
        for raw, _, _ in pieces(file, found, path, sys.maxsize):
            if found.comment.encode() in raw and len(told) < MAX_REMARKS:
                told |= {
                    as_text(m[0]).strip(): None for m in re.finditer(rb"(?m)^[ \t]*" + re.escape(found.comment.encode()) + rb".*$", raw)
                }
    return list(told)[:MAX_REMARKS]


def _numbers(column: pa.ChunkedArray) -> np.ndarray:
    return np.asarray(column.to_numpy(), np.float64)


def _texts(column: pa.ChunkedArray) -> Iterator[str]:
    """Yield the cells of a column of text, an empty text where nothing stands."""
    return (v or "" for v in _strings(column).to_pylist())


def _strings(column: pa.ChunkedArray) -> pa.Array:
    raw = pa.concat_arrays(column.chunks) if column.num_chunks else pa.array([], pa.binary())
    try:
        return raw.cast(pa.string())
    except pa.ArrowInvalid:
        # labels and times in an older encoding, or damaged: read as the header is
        return pa.array([v if v is None else as_text(v) for v in raw.to_pylist()], pa.string())
