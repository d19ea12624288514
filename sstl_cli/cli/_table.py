"""Tables as plain text: numbers are never broken, words only behind a space or a separator, wide tables are narrowed."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterable, Sequence

SEPARATION = "  "
NARROWEST = 6
# a place where a name may go on in the next line
_BREAKS = re.compile(r"(?<=\w[-_/,;:+=])(?<!\de[-+])(?=[^\s\d]|(?<=\D[-_/,;:+=]))(?=\S)|(?<=\s)(?=\S)")
_SPACES = re.compile(r"(?<=\s)(?=\S)")
# a heading keeps its unit beside it
_HEAD = re.compile(r"(?<=\s)(?=\S{4})")


def lines(header: Sequence[str], rows: Sequence[Sequence[str]], numeric: Sequence[bool], width: int) -> list[str]:
    """Return a table as lines of at most ``width`` columns, wider only where numbers alone need more.

    Examples
    --------
    >>> lines(["run", "N"], [["CP-020-trapezoid-act", "1.5"]], [False, True], 18)
    ['run              N', '──────────────────', 'CP-020-        1.5', 'trapezoid-act']
    """
    widths = _widths(header, rows, numeric, width)
    out = _row([_wrapped(h, w, _HEAD, _HEAD) for h, w in zip(header, widths, strict=True)], widths, numeric)
    out.append("─" * (sum(widths) + len(SEPARATION) * (len(widths) - 1)))
    for row in rows:
        out += _row([[c] if n else _wrapped(c, w) for c, w, n in zip(row, widths, numeric, strict=True)], widths, numeric)
    return out


def columns(text: str) -> int:
    """Return how many columns of a terminal a text takes."""
    return sum(0 if unicodedata.combining(c) else 2 if unicodedata.east_asian_width(c) in "WF" else 1 for c in text)


def _widths(header: Sequence[str], rows: Sequence[Sequence[str]], numeric: Sequence[bool], width: int) -> list[int]:
    """Return the width of each column: what it needs, less of the widest text where the sum is too large."""
    wanted, least, bare = [], [], []
    for i, name in enumerate(header):
        cells = [row[i] for row in rows]
        head = max(columns(p.rstrip()) for p in _HEAD.split(name))
        longest = max(map(columns, cells), default=0)
        piece = max((columns(p.rstrip()) for c in cells for p in _BREAKS.split(c)), default=0)
        least.append(max(head, longest if numeric[i] else min(piece, longest)))
        bare.append(max(head, longest))
        wanted.append(max(columns(name), longest))
    room = width - len(SEPARATION) * (len(header) - 1)
    # first headings go into two lines, then words, and last what would be cut
    for floor in (bare, least, [w if n else min(w, NARROWEST) for w, n in zip(least, numeric, strict=True)]):
        while sum(wanted) > room:
            able = [i for i in range(len(wanted)) if wanted[i] > floor[i]]
            if not able:
                break
            wanted[max(able, key=lambda i: (wanted[i], -i))] -= 1
    return wanted


def _wrapped(text: str, width: int, at: re.Pattern[str] = _BREAKS, between: re.Pattern[str] = _SPACES) -> list[str]:
    """Return a text in lines of at most ``width`` columns; a piece longer than that is broken where it must be."""
    out = [""]
    # words stay whole where a line can hold them
    pieces = (p for word in between.split(text) for p in ([word] if columns(word.rstrip()) <= width else at.split(word)))
    for piece in pieces:
        if out[-1] and columns((out[-1] + piece).rstrip()) > width:
            out[-1] = out[-1].rstrip()
            out.append("")
        while columns(piece.rstrip()) > width:
            cut = next(n for n in range(len(piece), 0, -1) if n == 1 or columns(piece[:n]) <= width)
            out[-1] += piece[:cut]
            out.append("")
            piece = piece[cut:]
        out[-1] += piece
    return [line.rstrip() for line in out]


def _row(cells: Sequence[Sequence[str]], widths: Sequence[int], numeric: Sequence[bool]) -> list[str]:
    height = max(map(len, cells))
    filled: Iterable[list[str]] = ([*c, *[""] * (height - len(c))] for c in cells)
    by_line = zip(*filled, strict=True)
    return [
        SEPARATION.join(
            " " * (w - columns(t)) + t if n else t + " " * (w - columns(t)) for t, w, n in zip(line, widths, numeric, strict=True)
        ).rstrip()
        for line in by_line
    ]
