"""``info`` and ``check`` of what sstl writes besides tables: JSON documents, JSON Lines and models."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from sstl_cli.cli.render import cell

if TYPE_CHECKING:
    from sstl_cli.cli.render import Screen
    from sstl_cli.steps.check import Finding

MAX_BYTES = 512 << 20
LONGEST = 100
HASH = re.compile("[0-9a-f]{64}")


def describe(path: Path, kind: str, screen: Screen) -> dict[str, Any]:
    """Show a JSON document or a model and return its entry in the document of ``info``."""
    return _describe_model(path, screen) if kind == "safetensors" else _describe_json(path, screen)


def findings(path: Path, kind: str) -> Iterator[Finding]:
    """Yield what is wrong with a JSON document or a model."""
    from sstl_cli.core.errors import SstlError
    from sstl_cli.steps.check import FAILURE, Finding

    try:
        if kind == "safetensors":
            from sstl_cli.mapping.weights import load_model

            load_model(path)
            return
        for number, document in enumerate(_documents(path), 1):
            yield from _against_model(document, number)
    except SstlError as error:
        yield Finding(FAILURE, "unreadable", "", 1, error.what, error.fix)


def _documents(path: Path) -> list[Any]:
    """Return the documents of a file: one, or one a line."""
    import json

    from sstl_cli.core.errors import SstlError
    from sstl_cli.core.files import read_json

    if path.stat().st_size > MAX_BYTES:
        raise SstlError(f"is larger than {MAX_BYTES >> 20} MiB", where=str(path), fix="give a document of sstl", code="E113")
    lines = path.read_bytes().split(b"\n")
    if len([x for x in lines if x.strip()]) > 1:
        try:
            return [json.loads(line) for line in lines if line.strip()]
        except (ValueError, RecursionError):
            # no JSON Lines: one document over several lines
            pass
    return [read_json(path)]


def _against_model(document: Any, number: int) -> Iterator[Finding]:
    from pydantic import ValidationError

    from sstl_cli.core.documents import catalogue, short
    from sstl_cli.core.errors import nearest
    from sstl_cli.steps.check import FAILURE, REMARK, Finding

    place = f"document {number}"
    schema = document.get("schema") if isinstance(document, dict) else None
    if not isinstance(schema, str):
        yield Finding(FAILURE, "no schema", "schema", 1, place, "give a document that sstl wrote")
        return
    known = catalogue()
    model = known.get(short(schema))
    if model is None:
        yield Finding(REMARK, "unknown document", "schema", 1, f"{schema!r} ({nearest(short(schema), known)})", "none needed")
        return
    if model.schema_name() != schema:
        yield Finding(FAILURE, "another version", "schema", 1, f"{schema!r}, not {model.schema_name()!r}", "make it again")
        return
    try:
        model.model_validate(document)
    except ValidationError as error:
        for one in error.errors(include_url=False)[:20]:
            field = ".".join(map(str, one["loc"]))
            fix = f"compare with: sstl schema {short(schema)}"
            yield Finding(FAILURE, "does not fit its schema", field, 1, f"{place}: {one['msg']}", fix)


def _describe_json(path: Path, screen: Screen) -> dict[str, Any]:
    documents = _documents(path)
    first = documents[0] if documents and isinstance(documents[0], dict) else {}
    schema = str(first.get("schema", "no schema"))
    several = f", {len(documents)} documents" if len(documents) > 1 else ""
    screen.say(f"{path.name} is a JSON document {schema}{several}, {path.stat().st_size / 1e6:.2f} MB.")
    screen.table("", ("field", "value"), [(k, _brief(v)) for k, v in first.items() if k != "schema"])
    version = schema.rpartition("/")[2]
    return {
        "file": str(path),
        "schema": schema,
        "version": int(version) if version.isdigit() else 0,
        "rows": len(documents),
        "provenance": None,
        "columns": list(first),
    }


def _brief(value: Any) -> str:
    """Return a field in a few words: numbers to four digits, long texts cut where it shows.

    Examples
    --------
    >>> _brief({"rmse_n": 0.91228101, "held_out": True, "why": None}), _brief([1, 2]), _brief("a " * 60)[-5:]
    ('rmse_n 0.9123, held_out True, why -', '2 entries', 'a ...')
    """
    if isinstance(value, dict):
        # of a hash the first digits, as where a table came from
        shown = {k: v[:12] if isinstance(v, str) and HASH.fullmatch(v) else cell(v) for k, v in value.items() if not isinstance(v, (dict, list))}
        inner = ", ".join(f"{k} {v}" for k, v in shown.items())
        return _cut(inner) if inner else f"{len(value)} entries"
    return f"{len(value)} entries" if isinstance(value, list) else _cut(cell(value))


def _cut(text: str) -> str:
    """Return at most about ``LONGEST`` letters of a text, whole words where it has them."""
    if len(text) <= LONGEST:
        return text
    words = text[:LONGEST].rpartition(" ")[0] or text[:LONGEST]
    return f"{words} ..."


def _describe_model(path: Path, screen: Screen) -> dict[str, Any]:
    from sstl_cli.mapping.weights import load_model

    header = load_model(path).header
    screen.say(f"{path.name} is a mapping model (version {header.schema_version}), {path.stat().st_size / 1e6:.2f} MB.")
    screen.say(f"  sstl {header.package_version}, seed {header.seed}, trained on {len(header.configs)} configurations")
    rows = [(v.name, v.alpha, v.weight_inv, v.rmse_validation) for v in header.variants]
    screen.table("", ("variant", "shortcut", "lambda", "RMSE validation"), rows)
    return {
        "file": str(path),
        "schema": header.schema_id,
        "version": header.schema_version,
        "rows": len(header.variants),
        "provenance": {"data_sha256": header.data_sha256, "package_version": header.package_version, "seed": header.seed},
        "columns": list(header.names),
    }
