"""``info`` and ``check`` of what sstl writes besides tables: JSON, JSON Lines, models, scenarios and the controller's answers."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from sstl_cli.cli.render import cell

if TYPE_CHECKING:
    from sstl_cli.cli.render import Screen
    from sstl_cli.core.documents.logs import FileInfo
    from sstl_cli.identification.samples import Finding

MAX_BYTES = 512 << 20
SHOWN = 20
LONGEST = 100
HASH = re.compile("[0-9a-f]{64}")


def other_kind(path: Path) -> str:
    """Return ``json``, ``safetensors``, ``toml`` or ``answers`` for a file that is no table, else nothing."""
    from sstl_cli.cli import _answers
    from sstl_cli.core.kinds import kind_of

    kind = kind_of(path) if path.is_file() else ""
    # TOML may begin like JSON does, with a table in brackets
    if kind in ("text", "json") and path.suffix.lower() == ".toml":
        return "toml"
    if kind in ("text", "json") and _answers.is_answers(path):
        return "answers"
    return kind if kind in ("json", "safetensors") else ""


def describe(path: Path, kind: str, screen: Screen) -> FileInfo:
    """Show a file of a kind that ``other_kind`` knows and return its entry in the document of ``info``."""
    from sstl_cli.cli import _answers

    show = {"json": _describe_json, "safetensors": _describe_model, "toml": _describe_toml, "answers": _answers.describe}
    return show[kind](path, screen)


def findings(path: Path, kind: str) -> Iterator[Finding]:
    """Yield what is wrong with a file of a kind that ``other_kind`` knows."""
    from sstl_cli.cli import _answers
    from sstl_cli.core.errors import SstlError
    from sstl_cli.identification.samples import FAILURE, Finding

    look = {"json": _of_json, "safetensors": _of_model, "toml": _of_toml, "answers": _answers.findings}
    try:
        yield from look[kind](path)
    except SstlError as error:
        yield Finding(FAILURE, "unreadable", "", 1, error.what, error.fix)


def _of_json(path: Path) -> Iterator[Finding]:
    for number, document in enumerate(_documents(path), 1):
        yield from _against_model(document, number)


def _of_model(path: Path) -> Iterator[Finding]:
    from sstl_cli.mapping.weights import load_model

    load_model(path)
    yield from ()


def _of_toml(path: Path) -> Iterator[Finding]:
    from sstl_cli.core.config import read_toml
    from sstl_cli.identification.samples import FAILURE, REMARK, Finding
    from sstl_cli.importers.mapping import read_mapping, still_open
    from sstl_cli.physics.scenario import load

    document = read_toml(path)
    if "schema" in document:
        load(str(path))
    elif _is_mapping(document):
        asked = still_open(path)
        for question in asked:
            fix = "complete the line and delete its (?)"
            yield Finding(FAILURE, "open question", question.target, 1, f"line {question.line}: {question.text}", fix)
        read_mapping(path, [q.target for q in asked])
    else:
        detail = "neither a scenario (schema = ...) nor a mapping ([columns])"
        yield Finding(REMARK, "unknown document", "", 1, detail, "none needed")


def _is_mapping(document: Mapping[str, object]) -> bool:
    return "columns" in document or "constants" in document


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

    from sstl_cli.control.parameters import SCHEMA as CONTROLLER
    from sstl_cli.core.documents import catalogue, short
    from sstl_cli.core.errors import nearest
    from sstl_cli.identification.samples import FAILURE, REMARK, Finding

    place = f"document {number}"
    schema = _schema_of(document)
    if not isinstance(schema, str):
        yield Finding(FAILURE, "no schema", "schema", 1, place, "give a document that sstl wrote")
        return
    if schema == CONTROLLER:
        yield from _of_controller(document)
        return
    known = catalogue()
    model = known.get(short(schema))
    if model is None and schema in _kept():
        # the program's own notes between two calls: the command that reads them is strict about their content
        return
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


def _schema_of(document: Any) -> Any:
    """Return the schema a document names; ``sstl schema`` writes JSON Schemas, which name themselves otherwise."""
    if not isinstance(document, dict):
        return None
    if "schema" not in document and str(document.get("$id", "")).startswith("urn:sstl:"):
        return str(document["$schema"])
    return document.get("schema")


def _kept() -> frozenset[str]:
    """Return the schemas of the documents that the program keeps for itself and publishes no form of."""
    from sstl_cli.blind import folder, learning, result, seal
    from sstl_cli.core.documents.base import DIALECT
    from sstl_cli.steps import batch, blind_library

    sealed = (seal.HASHES, seal.TRUTH, seal.PLAN)
    return frozenset((*sealed, result.SCHEMA, blind_library.PLAN, folder.DISTANCE, learning.SCHEMA, batch.RECORD, DIALECT))


def _of_controller(document: Mapping[str, object]) -> Iterator[Finding]:
    """Yield why the controller cannot be driven by what is in its parameter file."""
    from sstl_cli.control import parameters
    from sstl_cli.core.errors import SstlError
    from sstl_cli.identification.samples import FAILURE, Finding

    try:
        content = parameters.read(document, "")
    except SstlError as error:
        yield Finding(FAILURE, "does not fit its schema", "", 1, error.what, "export it again")
        return
    ids = [entry.config_id for entry in content.configurations]
    for twice in sorted({i for i in ids if ids.count(i) > 1}):
        yield Finding(FAILURE, "configuration comes twice", "configurations", ids.count(twice), repr(twice), "keep one")
    for entry in content.configurations:
        try:
            parameters.controller_of(entry, content.options)
        except SstlError as error:
            yield Finding(FAILURE, "no such controller", entry.config_id, 1, error.what, error.fix or "identify it again")


def _describe_json(path: Path, screen: Screen) -> FileInfo:
    from sstl_cli.control.parameters import SCHEMA as CONTROLLER

    documents = _documents(path)
    first = documents[0] if documents and isinstance(documents[0], dict) else {}
    schema = str(_schema_of(first) or "no schema")
    several = f", {len(documents)} documents" if len(documents) > 1 else ""
    screen.say(f"{path.name} is a JSON document {schema}{several}, {path.stat().st_size / 1e6:.2f} MB.")
    screen.table("", ("field", "value"), [(k, _brief(v)) for k, v in first.items() if k != "schema"])
    if schema == CONTROLLER:
        _show_controller(first, path, screen)
    return _file_entry(path, schema, len(documents), list(first))


def _file_entry(path: Path, schema: str, rows: int, columns: list[str]) -> FileInfo:
    from sstl_cli.core.documents.logs import FileInfo

    version = schema.rpartition("/")[2]
    number = int(version) if version.isdigit() else 0
    return FileInfo(file=str(path), schema=schema, version=number, rows=rows, provenance=None, columns=columns)


def _show_controller(document: Mapping[str, object], path: Path, screen: Screen) -> None:
    from sstl_cli.control import parameters

    rows = [
        (e.config_id, e.method, e.theta.gamma_p, e.theta.beta_p, e.theta.gamma_r, e.theta.beta_r)
        for e in parameters.read(document, str(path)).configurations
    ]
    screen.table("", ("config", "method", "Γ_p", "β_p N", "Γ_r", "β_r N"), rows, most=SHOWN)


def _describe_toml(path: Path, screen: Screen) -> FileInfo:
    from sstl_cli.core.config import read_toml
    from sstl_cli.importers.mapping import still_open

    document = read_toml(path)
    schema = str(document.get("schema", "no schema"))
    what = "a scenario" if "schema" in document else "a mapping" if _is_mapping(document) else "TOML, neither scenario nor mapping"
    screen.say(f"{path.name} is {what}{f' {schema}' if 'schema' in document else ''}, {path.stat().st_size / 1e6:.2f} MB.")
    screen.table("", ("field", "value"), [(k, _brief(v)) for k, v in document.items() if k != "schema"])
    for question in still_open(path) if _is_mapping(document) else ():
        screen.note(f"line {question.line} asks: {question.text}")
    return _file_entry(path, schema, 1, list(document))


def _brief(value: Any) -> str:
    """Return a field in a few words: numbers to four digits, long texts cut where it shows.

    Examples
    --------
    >>> _brief({"rmse_n": 0.91228101, "held_out": True, "why": None}), _brief([1, 2]), _brief("a " * 60)[-5:]
    ('rmse_n 0.9123, held_out True, why -', '2 entries', 'a ...')
    """
    if isinstance(value, dict):
        # of a hash the first digits, as where a table came from
        shown = {
            k: v[:12] if isinstance(v, str) and HASH.fullmatch(v) else cell(v) for k, v in value.items() if not isinstance(v, (dict, list))
        }
        inner = ", ".join(f"{k} {v}" for k, v in shown.items())
        return _cut(inner) if inner else f"{len(value)} entries"
    return f"{len(value)} entries" if isinstance(value, list) else _cut(cell(value))


def _cut(text: str) -> str:
    """Return at most about ``LONGEST`` letters of a text, whole words where it has them."""
    if len(text) <= LONGEST:
        return text
    words = text[:LONGEST].rpartition(" ")[0] or text[:LONGEST]
    return f"{words} ..."


def _describe_model(path: Path, screen: Screen) -> FileInfo:
    from sstl_cli.core.documents.logs import FileInfo
    from sstl_cli.mapping.weights import load_model

    header = load_model(path).header
    screen.say(f"{path.name} is a mapping model (version {header.schema_version}), {path.stat().st_size / 1e6:.2f} MB.")
    screen.say(f"  sstl {header.package_version}, seed {header.seed}, trained on {len(header.configs)} configurations")
    rows = [(v.name, v.alpha, v.weight_inv, v.rmse_validation) for v in header.variants]
    screen.table("", ("variant", "shortcut", "lambda", "RMSE validation"), rows)
    return FileInfo(
        file=str(path),
        schema=header.schema_id,
        version=header.schema_version,
        rows=len(header.variants),
        provenance={"data_sha256": header.data_sha256, "package_version": header.package_version, "seed": header.seed},
        columns=list(header.names),
    )
