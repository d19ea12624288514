"""The parts of file names, as words and numbers that stand beside each other."""

from __future__ import annotations

import re

from sstl_cli.importers.guess_words import unaccented, words

# of Latin letters with their accents, which some systems write as characters of their own
LETTERS = r"A-Za-z\u00c0-\u024f\u0300-\u036f"
TRIAL = words("run trial rep take test nr no t v rec log set file part dataset messung versuch essai ensayo prova")
# the parts at one place in each of the names, place by place
Columns = list[tuple[str, ...]]


def at(i: int, columns: Columns) -> str:
    """Return a part of the first name in small letters without accents, an empty text behind its end."""
    part = columns[i][0].lower() if 0 <= i < len(columns) else ""
    if not re.match(f"[{LETTERS}]", part):
        return part
    return unaccented(part)


def before(i: int, columns: Columns) -> str:
    """Return the part in front of another, over what separates them."""
    part = at(i - 1, columns)
    # letters of other scripts stand between parts, among what separates them
    if others := re.findall(r"[^\W\d_]+", "" if part.isascii() else part):
        return str(others[-1])
    return at(i - 2, columns) if part and not part[0].isalnum() and i > 1 else part


def next_word(i: int, step: int, columns: Columns) -> int | None:
    """Return the place of the part beside another, over what separates them, None at the end of the name."""
    k = i + step
    if 0 <= k < len(columns) and not columns[k][0][0].isalnum():
        k += step
    return k if 0 <= k < len(columns) else None


def next_words(i: int, columns: Columns) -> list[str]:
    """Return the parts of the first name behind a place, without what separates them."""
    return [p for p in (at(k, columns) for k in range(i + 1, len(columns))) if p[0].isalnum()]
