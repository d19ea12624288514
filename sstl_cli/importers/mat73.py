"""MATLAB files of version 7.3: HDF5 with MATLAB's conventions (columns stored as rows, text as codes)."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from sstl_cli.importers.base import Block, Channel, Layout, Notes, guarded
from sstl_cli.importers.hdf5 import has_signature, list_channels, read_blocks
from sstl_cli.importers.isolate import isolated, isolated_blocks

ID = "mat73"
TITLE = "a MATLAB file (v7.3)"
EXTENSIONS = (".mat",)
RANK = 24


def sniff(head: bytes, path: Path) -> bool:
    """Return whether the file begins with MATLAB's text and holds the HDF5 signature behind it."""
    return head.startswith(b"MATLAB") and has_signature(head)


def channels(path: Path, layout: Layout) -> list[Channel]:
    """Return variables and struct fields (``log.time``), matrix columns as ``name[2]``."""
    with guarded(path, TITLE):
        return isolated(lambda: list_channels(path, matlab=True), path)


def read(path: Path, numbers: list[str], labels: list[str], layout: Layout, notes: Notes) -> Iterator[Block]:
    """Yield blocks of the named variables."""
    with guarded(path, TITLE):
        yield from isolated_blocks(lambda: read_blocks(path, numbers, labels, matlab=True), path)
