"""The first runs of the sample recording, one of each system: what a test asks of a diagnosis, in a quarter of the time."""

from __future__ import annotations

from pathlib import Path

import sstl_cli as sstl

SAMPLE = Path(__file__).parents[1] / "data/samples/log.parquet"


def short() -> sstl.Log:
    """Return the trapezoids of the first bend; the friction of the pulley is found in them as in the whole."""
    return sstl.Log(sstl.read(SAMPLE).runs[:2])


def write(path: Path) -> Path:
    """Write them as a log."""
    short().write(path)
    return path
