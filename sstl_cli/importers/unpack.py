"""Compressed chunks of robot logs, unpacked within limits."""

from __future__ import annotations

import bz2
from pathlib import Path

from sstl_cli.core.errors import SstlError
from sstl_cli.importers.base import need

MAX_CHUNK_BYTES = 256 << 20


def unpacked(data: bytes, how: str, declared: int, path: Path) -> bytes:
    """Return the plain bytes of a chunk compressed as ``how`` (none, bz2, lz4, zstd).

    Raises
    ------
    SstlError
        If the chunk declares or yields more than 256 MiB, or another size than declared.
    """
    if declared > MAX_CHUNK_BYTES:
        raise SstlError(
            f"a chunk declares {declared:.3g} bytes", where=str(path), fix=f"at most {MAX_CHUNK_BYTES >> 20} MiB are read", code="E312"
        )
    if how in ("", "none"):
        return data
    if how == "bz2":
        plain = bz2.BZ2Decompressor().decompress(data, declared + 1)
    elif how == "lz4":
        lz4 = need(path, "lz4.frame", "robot")
        plain = lz4.LZ4FrameDecompressor().decompress(data, declared + 1)
    elif how == "zstd":
        zstandard = need(path, "zstandard", "robot")
        with zstandard.ZstdDecompressor(max_window_size=1 << 27).stream_reader(data) as stream:
            plain = stream.read(declared + 1)
    else:
        raise SstlError(f"has chunks compressed as '{how[:20]}'", where=str(path), fix="use lz4, zstd, bz2 or none", code="E347")
    if len(plain) != declared:
        raise SstlError(
            f"a chunk yields another size than the {declared} bytes it declares",
            where=str(path),
            fix="truncated or damaged: record or copy it again",
            code="E310",
        )
    return plain
