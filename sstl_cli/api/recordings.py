"""Recordings of any known format, imported into memory."""

from __future__ import annotations

import warnings
from os import PathLike
from pathlib import Path

from sstl_cli.api.log import Log
from sstl_cli.core.provenance import inputs_of
from sstl_cli.core.sound import noted
from sstl_cli.importers.base import members
from sstl_cli.importers.sources import read_manifest
from sstl_cli.steps import import_ as importing


def import_(
    *files: str | PathLike[str],
    mapping: str | PathLike[str] | None = None,
    manifest: str | PathLike[str] | None = None,
    on_gap: str | None = None,
    merge: str | None = None,
    format: str | None = None,  # noqa: A002
) -> Log:
    """Return recordings (CSV, text, Parquet, MAT, HDF5, NPZ, TDMS, MCAP, ROS bags) as a log, as ``sstl import`` makes it.

    What is set aside is warned of.

    Parameters
    ----------
    files : str or path
        The recordings; canonical columns need no mapping.
    mapping : str or path, optional
        A mapping file (TOML), or a mapping in short: ``"time_s=t:ms,tension_in_n=T1:N,..."``.
    manifest : str or path, optional
        A CSV with labels by file name.
    on_gap : str, optional
        split (default), fill or fail.
    merge : str, optional
        append, channels or rows.
    format : str, optional
        Format id, instead of detection.

    Raises
    ------
    SstlError
        If a file cannot be read, or the mapping does not fit it.
    """
    paths = [Path(f) for f in files]
    short = mapping if isinstance(mapping, str) and "=" in mapping else None
    file = Path(mapping) if mapping is not None and short is None else None
    chosen = importing.mapping_of(file, short, on_gap, merge)
    table = importing.manifest_of(None if manifest is None else Path(manifest), file, chosen)
    found = importing.run(paths, chosen, wanted=format, manifest=read_manifest(table) if table is not None else {})
    runs = tuple(piece for run in found.runs for piece in noted(run))
    told = [f"{n} samples, {why}" for why, n in found.counts.notes.set_aside.items()]
    for text in [*told, *(f"{bad.path.name}, {bad.error}" for bad in found.bad)]:
        warnings.warn(f"set aside: {text}", stacklevel=2)
    return Log(runs, inputs_of([*(m for p in paths for m in members(p)), *filter(None, (file, table))]))
