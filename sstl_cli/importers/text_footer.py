"""Rows of statistics (Mean, Max) that programs write below the samples of a text log."""

from __future__ import annotations

import os
import sys
from dataclasses import dataclass
from pathlib import Path

from sstl_cli.importers.guess_words import words
from sstl_cli.importers.text_cells import SPACES, cut
from sstl_cli.importers.text_file import opened
from sstl_cli.importers.text_layout import TextLayout

# they are a few lines
TAIL_BYTES = 8192
STATISTICS = words(
    "mean average avg peak max maximum min minimum std stdev stddev sd median sum total count rms range var variance "
    "mittelwert mittel standardabweichung stabw moyenne media promedio"
)


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
        if word := _statistic(line, found):
            end, names = at, [word, *names]
        elif line.strip():
            break
        at -= len(found.line_end)
    return Footer(end, tuple(names))


def _statistic(line: bytes, found: TextLayout) -> str:
    """Return the word for a statistic that stands in front of a line, '' where none does."""
    if not line.strip():
        return ""
    cells = cut(line.decode("latin-1"), "\t" if found.delimiter == SPACES and b"\t" in line else found.delimiter)
    # "Std Dev", "Max:"
    name = cells[0].strip(" :.")
    return name if name.lower().split(" ")[0] in STATISTICS else ""
