"""Rows of statistics (Mean, Max) that programs write below the samples of a text log."""

from __future__ import annotations

import os
import sys
from dataclasses import dataclass
from pathlib import Path

from sstl_cli.importers.text_cells import SPACES, cut, is_number
from sstl_cli.importers.text_file import opened
from sstl_cli.importers.text_header import statistic
from sstl_cli.importers.text_layout import TextLayout

# they are a few lines
TAIL_BYTES = 8192


@dataclass(frozen=True)
class Footer:
    """Where the samples end (bytes), and the words in front of the rows behind them (none: they go on to the end of the file)."""

    end: int = sys.maxsize
    names: tuple[str, ...] = ()


def footer_of(path: Path, found: TextLayout) -> Footer:
    """Return the rows of statistics at the end of a text log whose first column holds numbers."""
    if not found.text or found.text[0]:
        return Footer()
    with opened(path) as file:
        size = file.seek(0, os.SEEK_END)
        file.seek(max(found.first_byte, size - TAIL_BYTES))
        lines = file.read().split(found.line_end)
    names: list[str] = []
    end, at = sys.maxsize, size
    for line in reversed(lines[1:]):
        at -= len(line)
        cells = _cells(line, found)
        if word := statistic(cells):
            end, names = at, [word, *names]
        elif names and line.strip() and len(cells) > 1 and not any(map(is_number, cells)):
            # the names once more, above a table of statistics of its own
            end = at
        elif line.strip():
            break
        at -= len(found.line_end)
    return Footer(end, tuple(names))


def _cells(line: bytes, found: TextLayout) -> list[str]:
    return cut(line.decode("latin-1"), "\t" if found.delimiter == SPACES and b"\t" in line else found.delimiter)
