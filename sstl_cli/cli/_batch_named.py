"""Which files the subcommand of a batch reads beside its input: named by its options, by ``SSTL_*`` values or by a ``--config`` file."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from sstl_cli.steps.batch import Item


def named_files(values: dict[str, Any], item: Item) -> tuple[str, ...]:
    """Return the files that the values of a subcommand's options name, without its input and outputs.

    Parameters
    ----------
    values : dict
        Value of each option, wherever it came from, as typer parsed it for ``item``.
    """
    own = {item.source, item.output, *item.side}
    texts = (str(t) for v in values.values() for t in (v if isinstance(v, (list, tuple)) else [v]) if isinstance(t, (str, Path)))
    found = [t for t in texts if t not in own and 0 < len(t) < 4096 and "\0" not in t and os.path.isfile(t)]
    return tuple(dict.fromkeys([*found, *_manifests(values.get("mapping"))]))


def _manifests(mapping: object) -> Iterator[str]:
    """Yield the table of labels that a mapping names; what is wrong with the mapping is for the import to say."""
    from sstl_cli.core.config import read_toml
    from sstl_cli.core.errors import SstlError

    if not isinstance(mapping, Path):
        return
    try:
        manifest = read_toml(mapping).get("manifest")
    except SstlError:
        return
    if isinstance(manifest, str) and manifest and os.path.isfile(mapping.parent / manifest):
        yield str(mapping.parent / manifest)
