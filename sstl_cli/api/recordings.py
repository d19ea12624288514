"""Recordings of any known format, imported into memory."""

from __future__ import annotations

import warnings
from os import PathLike
from pathlib import Path

from sstl_cli.api.log import Log
from sstl_cli.core.provenance import inputs_of
from sstl_cli.core.sound import noted
from sstl_cli.importers import guess as guessing
from sstl_cli.importers.base import members, require_recording
from sstl_cli.importers.guess import Guess
from sstl_cli.importers.sources import read_manifest
from sstl_cli.steps import import_ as importing

__all__ = ["Guess", "guess", "import_"]


def import_(
    *files: str | PathLike[str],
    mapping: str | PathLike[str] | None = None,
    manifest: str | PathLike[str] | None = None,
    on_gap: str | None = None,
    merge: str | None = None,
    format: str | None = None,  # noqa: A002
) -> Log:
    r"""Return recordings (CSV, text, Parquet, MAT, HDF5, NPZ, TDMS, MCAP, ROS bags) as a log, as ``sstl import`` makes it.

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

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> rows = [f"{20 * k},{5 + k % 50},{3 + k % 50 / 2}" for k in range(100)]
    >>> with TemporaryDirectory() as folder:
    ...     file = Path(folder, "bend.csv")
    ...     _ = file.write_text("\n".join(["t,T1,T2", *rows]))
    ...     import_(file, mapping="time_s=t:ms,tension_in_n=T1:N,tension_out_n=T2:N,system=act")
    Log(1 run, 100 samples)
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


def guess(*files: str | PathLike[str], format: str | None = None) -> Guess:  # noqa: A002
    r"""Return a proposed mapping for recordings of one kind, with its reasons and questions, as ``sstl import --guess`` makes it.

    Parameters
    ----------
    files : str or path
        The recordings.
    format : str, optional
        Format id, instead of detection.

    Raises
    ------
    SstlError
        If no file can be read, or they hold fewer than two numeric channels.

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> rows = [f"{20 * k},{5 + k % 50},{3 + k % 50 / 2}" for k in range(100)]
    >>> with TemporaryDirectory() as folder:
    ...     file = Path(folder, "bend.csv")
    ...     _ = file.write_text("\n".join(["t_ms,T_in,T_out", *rows]))
    ...     found = guess(file)
    >>> found.format, found.toml.splitlines()[0], len(found.questions)
    ('text', '# Proposed by sstl import --guess. Complete every line that ends in a question and delete its mark.', 3)
    """
    paths = [Path(f) for f in files]
    for path in paths:
        require_recording(path)
    return guessing.guess(paths, format)
