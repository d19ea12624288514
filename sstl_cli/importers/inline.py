"""The mapping in short, ``--map`` and policy options of the command line, laid over a mapping file."""

from __future__ import annotations

import re
from typing import Any

from sstl_cli.core.errors import SstlError, UsageError, nearest
from sstl_cli.importers.mapping import LABELS, SIGNAL_DIMENSION, TARGETS, Mapping, mapping_of


def targets_of(text: str) -> set[str]:
    """Return the columns and labels that a ``--map`` text gives."""
    return {part.partition("=")[0].strip() for part in text.split(",") if "=" in part}


def inline_mapping(text: str, base: Mapping | None = None) -> Mapping:
    """Return the mapping of a ``--map`` text, laid over ``base``.

    Parameters
    ----------
    text : str
        Comma-separated ``target=source[:unit]``. A source is ``colN``, ``-colN`` (sign), ``colA-colB``
        (difference), ``/pattern/`` or a channel name; a label takes a plain text as a constant.

    Raises
    ------
    UsageError
        If a part is not understood, a target unknown, or a unit unknown.
    """
    document: dict[str, Any] = base.model_dump(by_alias=True, exclude_unset=True) if base else {}
    columns, constants = dict(document.get("columns", {})), dict(document.get("constants", {}))
    for part in filter(None, (p.strip() for p in text.split(","))):
        target, equals, value = (x.strip() for x in part.partition("="))
        if not equals or not value:
            raise UsageError(f"'{part}' is not target=source[:unit]", where="--map", code="E332")
        if target not in TARGETS:
            raise UsageError(f"unknown column '{target}'", where="--map", fix=nearest(target, TARGETS), code="E330")
        source = _inline_source(value, target)
        constants.pop(target, None)
        columns.pop(target, None)
        if isinstance(source, str):
            constants[target] = source
        else:
            columns[target] = source
    document["columns"], document["constants"] = columns, constants
    try:
        return mapping_of(document, "--map")
    except UsageError:
        raise
    except SstlError as error:
        raise UsageError(error.what, where="--map", fix=error.fix, code=error.code) from None


def _inline_source(value: str, target: str) -> dict[str, Any] | str:
    body, unit = value, ""
    if target in SIGNAL_DIMENSION and ":" in value:
        body, _, unit = value.rpartition(":")
    sign = 1
    if body.startswith("-") and len(body) > 1:
        sign, body = -1, body[1:]
    source: dict[str, Any] = {"unit": unit, "sign": sign}
    difference = re.fullmatch(r"col(\d+)-col(\d+)", body)
    if difference:
        return {**source, "minus": [int(difference[1]), int(difference[2])]}
    number = re.fullmatch(r"col(\d+)", body)
    if number:
        return {**source, "column": int(number[1])}
    if len(body) > 2 and body[0] == body[-1] == "/":
        return {**source, "pattern": body[1:-1]}
    if target in LABELS:
        return {"column": body[1:]} if body.startswith("@") else value
    return {**source, "column": body}


def with_policy(mapping: Mapping, on_gap: str | None, merge: str | None) -> Mapping:
    """Return the mapping with policies from the command line laid over it."""
    document = mapping.model_dump(by_alias=True, exclude_unset=True)
    if on_gap is not None:
        if on_gap not in ("split", "fill", "fail"):
            raise UsageError(f"--on-gap is '{on_gap}'", fix="use split, fill or fail", code="E332")
        document["time"] = {**document.get("time", {}), "on_gap": on_gap}
    if merge is not None:
        if merge not in ("no", "append", "channels", "rows"):
            raise UsageError(f"--merge is '{merge}'", fix="use append, channels or rows", code="E332")
        document["files"] = {**document.get("files", {}), "merge": merge}
    return mapping_of(document, "mapping")
