"""What ``import --guess`` proposes for a text, as tests of several kinds of files ask it."""

from __future__ import annotations

import tomllib
from pathlib import Path

from sstl_cli.importers.guess import Guess, guess


def proposed(path: Path, text: str, encoding: str = "utf-8") -> tuple[dict[str, dict[str, object]], Guess]:
    """Return the proposed columns of a file with this text, and all of the proposal."""
    path.write_text(text, encoding)
    found = guess([path])
    return tomllib.loads(found.toml)["columns"], found
