"""Text logs as bytes of UTF-8, also those that a spreadsheet or a Windows program wrote as "Unicode text" (UTF-16), and JSON as one value."""

from __future__ import annotations

import io
from pathlib import Path
from typing import IO

from sstl_cli.core.errors import SstlError
from sstl_cli.importers.text_whole import records_of

_MARKS = {b"\xff\xfe": "utf-16", b"\xfe\xff": "utf-16"}
# without a mark: of the numbers and marks that a table consists of, one byte in two is zero, always the same one
_SAMPLE, _MOSTLY, _HARDLY = 512, 0.9, 0.02
# of UTF-16, which is turned into UTF-8 in memory; a spreadsheet holds no more
MAX_WIDE_BYTES = 64 << 20


def opened(path: Path) -> IO[bytes]:
    """Return a text log opened for reading.

    Raises
    ------
    SstlError
        If it is UTF-16 and longer than a spreadsheet writes.
    """
    encoding = wide(path)
    if not encoding:
        records = records_of(path)
        return io.BytesIO(records) if records else open(path, "rb")
    if path.stat().st_size > MAX_WIDE_BYTES:
        raise SstlError(
            f"is UTF-16 text of more than {MAX_WIDE_BYTES >> 20} MiB", where=str(path), fix="save it as 'CSV UTF-8'", code="E321"
        )
    # what is cut off in the middle of a character shows in the cell it is in
    return io.BytesIO(path.read_bytes().decode(encoding, "replace").encode("utf-8"))


def wide(path: Path) -> str:
    """Return the encoding of a file of UTF-16, an empty text for any other."""
    with open(path, "rb") as file:
        return wide_encoding(file.read(_SAMPLE))


def wide_encoding(head: bytes) -> str:
    """Return the encoding of UTF-16 that a file begins in, by its byte-order mark or its zero bytes; an empty text for any other.

    Examples
    --------
    >>> [wide_encoding("t,F".encode(e)) for e in ("utf-16", "utf-16-le", "utf-16-be", "utf-8")]
    ['utf-16', 'utf-16-le', 'utf-16-be', '']
    """
    if head[:2] in _MARKS:
        return _MARKS[head[:2]]
    head = head[:_SAMPLE]
    zeros = [head[k::2].count(0) / max(1, len(head) // 2) for k in (0, 1)]
    for at, encoding in ((1, "utf-16-le"), (0, "utf-16-be")):
        if zeros[at] > _MOSTLY and zeros[1 - at] < _HARDLY:
            return encoding
    return ""
