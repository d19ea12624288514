"""Text logs as bytes of UTF-8, also those that a spreadsheet wrote as "Unicode text" (UTF-16)."""

from __future__ import annotations

import io
from pathlib import Path
from typing import IO

from sstl_cli.core.errors import SstlError

_MARKS = (b"\xff\xfe", b"\xfe\xff")
# of UTF-16, which is turned into UTF-8 in memory; a spreadsheet holds no more
MAX_WIDE_BYTES = 64 << 20


def opened(path: Path) -> IO[bytes]:
    """Return a text log opened for reading.

    Raises
    ------
    SstlError
        If it is UTF-16 and longer than a spreadsheet writes.
    """
    if not is_wide(path):
        return open(path, "rb")
    if path.stat().st_size > MAX_WIDE_BYTES:
        raise SstlError(
            f"is UTF-16 text of more than {MAX_WIDE_BYTES >> 20} MiB", where=str(path), fix="save it as 'CSV UTF-8'", code="E321"
        )
    # what is cut off in the middle of a character shows in the cell it is in
    return io.BytesIO(path.read_bytes().decode("utf-16", "replace").encode("utf-8"))


def is_wide(path: Path) -> bool:
    """Return whether a file begins with the byte-order mark of UTF-16."""
    with open(path, "rb") as file:
        return file.read(2) in _MARKS
