"""Regular expressions of a mapping, matched in time linear in the text, so that no pattern can hang an import.

They are those of RE2, which Arrow brings: Python's, but for looking ahead or behind and for references back.
"""

from __future__ import annotations

import re
from collections.abc import Sequence

import pyarrow as pa
import pyarrow.compute as pc

from sstl_cli.core.errors import SstlError

# an escaped character, a class of characters, or a group without a name
_TOKEN = re.compile(r"\\.|\[\^?\]?(?:\\.|[^\]\\])*\]|\((?!\?)", re.DOTALL)
_WHOLE = "sstl_whole"


def compiled(pattern: str | None) -> str | None:
    """Return a pattern that compiles; ValueError says where it does not."""
    if pattern is not None:
        try:
            _find(pattern, [""])
        except pa.ArrowException as error:
            raise ValueError(f"pattern does not compile: {str(error).partition(': ')[2] or error}") from None
    return pattern


def search(pattern: str, texts: Sequence[str]) -> list[dict[str, str] | None]:
    """Return what the named groups of a pattern hold in each text (empty ones left out), None where it does not fit."""
    try:
        found = _find(pattern, texts)
    except pa.ArrowException as error:
        raise SstlError(f"pattern '{pattern[:60]}' cannot be matched ({str(error)[:80]})", code="E319") from None
    return [None if m is None else {k: v for k, v in m.items() if v and k != _WHOLE} for m in found]


def starts(pattern: str, texts: Sequence[str]) -> list[str | None]:
    """Return what a pattern matches at the start of each text, None where it does not."""
    whole = f"\\A(?:{pattern})"
    return [None if m is None else m[_WHOLE] for m in _find(whole, texts)]


def _find(pattern: str, texts: Sequence[str]) -> list[dict[str, str] | None]:
    # Arrow wants a name for every group that it shall report
    named = _TOKEN.sub(lambda m: "(?:" if m[0] == "(" else m[0], pattern)
    # names of files may hold bytes that are no text
    plain = [t.encode("utf-8", "replace").decode() for t in texts]
    found: list[dict[str, str] | None] = pc.extract_regex(pa.array(plain, pa.string()), f"(?P<{_WHOLE}>{named})").to_pylist()
    return found
