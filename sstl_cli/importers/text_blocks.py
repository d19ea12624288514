"""Text logs in which tables of one header stand below each other: where each begins, its rows, and the lines of its own above the header."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

from sstl_cli.core.errors import SstlError, printable
from sstl_cli.importers.base import Layout, Notes
from sstl_cli.importers.mapping import LABELS
from sstl_cli.importers.pattern import search
from sstl_cli.importers.text_cells import cut, is_missing, is_number
from sstl_cli.importers.text_file import opened
from sstl_cli.importers.text_forms import behind_stamp
from sstl_cli.importers.text_header import statistic
from sstl_cli.importers.text_layout import TextLayout, as_text
from sstl_cli.importers.text_stamps import are_stamps

# the channels that tell the block of a row and what its lines say are called so: @block, @config_id
SIGN = "@"
NAME = f"{SIGN}block"
# lines of its own that a block may have, and rows of its header
MAX_LINES, MAX_ROWS = 200, 12
NEW_LINE = b"\n"
CUT_OFF = "last line of a block cut off in the middle"
# bytes as they were read, where they begin in the file, and whether they are the last and may lack a line end
Piece = tuple[bytes, int, bool]


@dataclass(frozen=True)
class Head:
    """The rows of a header from the names on, without blanks and a serial monitor's clock around them, and the lines above the first."""

    rows: tuple[bytes, ...]
    above: tuple[str, ...]
    stamped: bool = False

    def row(self, line: bytes) -> bytes:
        """Return a line as the rows of a header are compared."""
        return behind_stamp(line.strip().decode("latin-1")).encode("latin-1") if self.stamped else line.strip()


@dataclass(frozen=True)
class Part:
    """Rows of one block: its number from 1, the lines above its header and the line it begins at, and whether these are its first rows."""

    body: bytes
    offset: int
    last: bool
    number: int
    lines: tuple[str, ...]
    begins: int
    first: bool


def labels_told(layout: Layout) -> list[str]:
    """Return the labels that patterns of a mapping take from the lines of blocks."""
    return [k for k in LABELS if any(f"(?P<{k}>" in p for p in layout.block_lines)]


def labels_of_block(part: Part, layout: Layout, path: Path) -> dict[str, str]:
    """Return what the channels of labels hold for the rows of a block, by the nearest line above its header; SstlError (E341) where none fits."""
    out = {NAME: f"{path.stem or path.name}-{part.number}"}
    for pattern in layout.block_lines:
        found = next((m for m in search(pattern, part.lines[::-1]) if m), None)
        if found is None:
            what = f"block {part.number} has no line above its header that fits '{pattern}'"
            raise SstlError(what, where=f"{path}, line {part.begins}", fix="correct block_lines in the mapping, or the line", code="E341")
        out |= {f"{SIGN}{k}": v for k, v in found.items() if k in LABELS}
    return out


def head_of(path: Path, found: TextLayout) -> Head | None:
    """Return the header of a text log as it would stand above a further block, None where no row holds the names of the columns."""
    if not found.named:
        return None
    with opened(path) as file:
        above = file.read(found.first_byte).split(found.line_end)
    while above and not above[-1].strip():
        above.pop()
    for i in range(len(above) - 1, max(-1, len(above) - 1 - MAX_ROWS), -1):
        if _names(above[i], found):
            head = Head((), tuple(as_text(x).strip() for x in above[:i] if x.strip()), _is_stamped(found))
            return replace(head, rows=tuple(head.row(x) for x in above[i:] if x.strip()))
    return None


def _is_stamped(found: TextLayout) -> bool:
    return found.forms is not None and found.forms.stamped


def _names(line: bytes, found: TextLayout) -> bool:
    """Return whether a line is the row of the columns' names."""
    text = behind_stamp(as_text(line).strip()) if _is_stamped(found) else as_text(line).strip()
    plain = text.removeprefix(found.comment).lstrip("#%/ \t") if found.comment and text.startswith(found.comment) else text
    # LabVIEW has a column for comments behind its readings
    cells = [c for c in cut(plain, found.delimiter)[: len(found.names)] if c]
    known = {*found.names, *(n.rpartition(".")[0] for n in found.names if n.rpartition(".")[2].isdigit())}
    return len(cells) > 1 and 2 * len(cells) > len(found.names) and set(cells) <= known


def parts_of(pieces: Iterator[Piece], head: Head, found: TextLayout, path: Path, notes: Notes) -> Iterator[Part]:
    """Yield the rows of all blocks in order.

    Raises
    ------
    SstlError
        E327 where the names stand there again and the rows below them, such as that of the units, are others.
    """
    number, lines, begins, first = 1, head.above, 1, True
    held, start, line = b"", found.first_byte, found.first_line
    wide = len(found.line_end) - 1
    for raw, _, last in _ended(pieces):
        raw = held + raw
        # lines that a further piece may tell to be those of another block
        keep = len(raw) if last is None else _begin_of_lines(raw, len(raw), found)
        raw, held = (raw, b"") if last is not None and last else (raw[:keep], raw[keep:])
        at = 0
        while (names := _find(raw, head, at)) >= 0:
            begin = max(at, _begin_of_lines(raw, names, found))
            end = _below(raw, names, head, line + raw.count(NEW_LINE, 0, names), path)
            body, cut_off = _without_cut(raw[at:begin], found)
            notes.aside(CUT_OFF, cut_off)
            if body and not body.isspace():
                yield Part(body, start + at + wide * raw.count(NEW_LINE, 0, at), False, number, lines, begins, first)
            told = [as_text(x).strip() for x in raw[begin:names].split(NEW_LINE) if x.strip()]
            notes.aside("rows of statistics below the samples of a block", sum(bool(statistic(cut(x, found.delimiter))) for x in told))
            blank = len(raw[begin:end]) - len(raw[begin:end].lstrip())
            number, lines, begins, first = number + 1, tuple(told), line + raw.count(NEW_LINE, 0, begin + blank), True
            at = end
        if (left := raw[at:]) and not left.isspace():
            yield Part(left, start + at + wide * raw.count(NEW_LINE, 0, at), bool(last), number, lines, begins, first)
            first = False
        start, line = start + len(raw) + wide * raw.count(NEW_LINE), line + raw.count(NEW_LINE)


def _ended(pieces: Iterator[Piece]) -> Iterator[tuple[bytes, int, bool | None]]:
    """Yield pieces, and an empty one (None) behind the last."""
    yield from pieces
    yield b"", 0, None


def _find(raw: bytes, head: Head, at: int) -> int:
    """Return where the line begins, from a place on, that holds the names and nothing else, -1 where none does."""
    row = head.rows[0]
    while (found := raw.find(row, at)) >= 0:
        begin, end = raw.rfind(NEW_LINE, 0, found) + 1, raw.find(NEW_LINE, found)
        if head.row(raw[begin : end if end >= 0 else len(raw)]) == row:
            return begin
        at = found + len(row)
    return -1


def _begin_of_lines(raw: bytes, end: int, found: TextLayout) -> int:
    """Return where the lines in front of a place begin that are no readings."""
    for _ in range(MAX_LINES):
        if end == 0:
            break
        begin = raw.rfind(NEW_LINE, 0, end - 1) + 1
        if _is_row(raw[begin:end], found):
            break
        end = begin
    return end


def _cells(line: bytes, found: TextLayout) -> list[str]:
    text = as_text(line).rstrip("\r\n")
    return cut(found.forms.line(text) if found.forms is not None else text, found.delimiter)


def _is_row(line: bytes, found: TextLayout) -> bool:
    """Return whether a line holds readings, also where it was cut off or one of them is no number."""
    if found.comment and line.lstrip().startswith(found.comment.encode()):
        return False
    cells = _cells(line, found)
    held = [c for c in cells if not is_missing(c)]
    numbers = sum(map(is_number, held))
    if numbers == len(held):
        # a number alone is the title of a block, and no row that was cut off
        return len(held) > 1 or len(found.names) == 1
    at = next((i for i, text in enumerate(found.text) if not text), 0)
    if len(cells) != len(found.names):
        return False
    # LabVIEW's "Samples 400 400" begins with a word
    return is_number(cells[at]) or (is_missing(cells[at]) and numbers > 0) or (found.stamps[at] and are_stamps([cells[at]]))


def _without_cut(body: bytes, found: TextLayout) -> tuple[bytes, int]:
    """Return rows without a last one that ends before its last column, and how many that was, as where a recorder was switched off."""
    begin = body.rfind(NEW_LINE, 0, max(len(body) - 1, 0)) + 1
    short = body[begin:].strip() and len(_cells(body[begin:], found)) < len(found.names)
    return (body[:begin], 1) if short else (body, 0)


def _below(raw: bytes, names: int, head: Head, line: int, path: Path) -> int:
    """Return where the rows of a header that stand there again end; SstlError where they are others than those of the first."""
    at = names
    for row in head.rows:
        begin = at
        while at < len(raw):
            end = raw.find(NEW_LINE, at)
            end = len(raw) if end < 0 else end
            begin, at = at, min(end + 1, len(raw))
            if raw[begin:end].strip():
                break
        # a block that ends in its header has no readings
        if (there := head.row(raw[begin:at])) != row and there:
            what = f"the names of the columns stand there again, and below them {printable(as_text(there)[:60])!r}, not {printable(as_text(row)[:60])!r}"
            where = f"{path}, line {line + raw.count(NEW_LINE, names, begin)}"
            raise SstlError(what, where=where, fix="split the file there: what has other units needs a mapping of its own", code="E327")
    return at
