"""The JSON documents that users and their scripts may rely on: one model each, found by their schema ids."""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Mapping
from functools import cache

from sstl_cli.core.documents.base import Document
from sstl_cli.core.errors import UsageError, nearest


@cache
def catalogue() -> Mapping[str, type[Document]]:
    """Return every document model by its short name: ``diagnosis`` for ``sstl.diagnosis/1``.

    Examples
    --------
    >>> catalogue()["error"].schema_name()
    'sstl.error/1'
    """
    for module in pkgutil.iter_modules(__path__):
        importlib.import_module(f"{__name__}.{module.name}")
    found = {short(model.schema_name()): model for model in Document.__subclasses__()}
    return {name: found[name] for name in sorted(found)}


def short(schema: str) -> str:
    """Return the name of a document without family and version: ``blind.score`` for ``sstl.blind.score/1``."""
    return schema.removeprefix("sstl.").partition("/")[0]


def get(name: str) -> type[Document]:
    """Return the model of a document by its short name or its schema id.

    Raises
    ------
    UsageError
        E160 for a name that no document has, with the nearest.
    """
    known = catalogue()
    model = known.get(short(name))
    if model is None or ("/" in name and name != model.schema_name()):
        raise UsageError(f"no document '{name}' ({nearest(name, known)})", where="NAME", code="E160")
    return model
