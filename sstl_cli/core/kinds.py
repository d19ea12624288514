"""What a file is by its first bytes, so that an error can say which command reads it."""

from __future__ import annotations

import struct
from pathlib import Path

HEAD_BYTES = 4096


def kind_of(path: Path) -> str:
    """Return ``parquet``, ``json``, ``safetensors``, ``text``, or ``other`` for what is none of them."""
    with open(path, "rb") as file:
        head = file.read(HEAD_BYTES)
    if head[:4] == b"PAR1":
        return "parquet"
    if len(head) > 8 and head[8:9] == b"{" and 1 < struct.unpack("<Q", head[:8])[0] <= path.stat().st_size:
        return "safetensors"
    if head.lstrip(b"\xef\xbb\xbf \t\r\n")[:1] in (b"{", b"["):
        return "json"
    control = sum(head.count(bytes([c])) for c in range(32) if c not in (9, 10, 12, 13))
    return "text" if head.strip() and not control else "other"


def not_parquet(path: Path) -> tuple[str, str]:
    """Return what is wrong with a file that should be a table of sstl, and what to do."""
    try:
        kind = kind_of(path)
    except OSError as error:
        return f"cannot be read: {error.strerror}", "check path and rights"
    name = path.name
    if kind == "parquet":
        return "is a Parquet file that was cut off or damaged", "copy it again, or make it again"
    if kind == "json":
        return "is a JSON document, not a table", f"see what it holds with: sstl info {name}"
    if kind == "safetensors":
        return "is a model file, not a table", f"give the log or Theta table; sstl info {name} shows the model"
    if path.stat().st_size == 0:
        return "is empty", "give a table that sstl wrote"
    what = "is text, not a table of sstl" if kind == "text" else "is no Parquet file"
    return what, f"turn it into a log: sstl import {name} --out {path.stem}-log.parquet (--guess proposes a mapping)"
