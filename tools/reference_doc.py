"""Keep docs/reference.md complete: every field of every JSON document, of scenario files, and every key of --config.

``python tools/reference_doc.py`` writes the page from the models and commands themselves; ``--check`` only compares
and ends with 1 where the page is out of date.
"""

from __future__ import annotations

import sys
import tomllib
import types
import typing
from functools import cache
from pathlib import Path
from typing import Any, Literal, get_args, get_origin

import typer
from pydantic import BaseModel
from pydantic.fields import FieldInfo

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs" / "reference.md"
HEAD = """# Reference: JSON documents, scenario files, configuration files

Written by `python tools/reference_doc.py` from the program itself; `sstl schema NAME` prints the same as a JSON Schema.
Fields are added, never renamed. `[]` stands for each entry of a list, `*` for any name. Beside its own fields every document may hold:

"""
SCENARIO = """## Scenario TOML

What `simulate --scenario`, `diagnose --sim`, `compensate --sim` or `--plant-sim` and `export` read and `diagnose --save-sim` writes. Unknown keys
are errors that name the nearest known one. Built-in scenarios: {names}.
"""
CONFIG = """## Configuration files and variables

Every command takes `--config FILE.toml`. A key is the name of an option, with `-` or `_`; top-level keys are for every command that
has the option, a table `[segment]` or `[blind.make]` for that one. A variable has the name of the command and the option:
`SSTL_SEGMENT_CUTOFF_HZ`. Flag comes before variable, variable before file, file before default.

```toml
seed = 7

[segment]
cutoff-hz = 8.0

[diagnose]
max-effects = 2
exclude = "acquisition_faults,quantisation"
```

| command | keys |
|---|---|
"""


def page() -> str:
    """Return the whole page."""
    from sstl_cli.core.documents import catalogue
    from sstl_cli.core.documents.base import Document
    from sstl_cli.physics.scenario import Scenario, builtin_names

    parts = [HEAD + _table(Document), "## JSON documents\n"]
    for model in catalogue().values():
        doc = (model.__doc__ or "").strip().splitlines()[0]
        parts.append(f"### {model.schema_name()}\n\n{doc}\n\n{_table(model)}")
    names = ", ".join(f"`{n}`" for n in builtin_names())
    parts.append(SCENARIO.format(names=names) + "\n" + _table(Scenario))
    parts.append(CONFIG + "\n".join(f"| `{name}` | {', '.join(f'`{k}`' for k in keys)} |" for name, keys in _commands()) + "\n")
    return "\n".join(parts)


def _table(model: type[BaseModel]) -> str:
    rows = [f"| `{name}` | {kind} | {text} |" for name, kind, text in _fields(model, "")]
    return "\n".join(["| field | type | meaning |", "|---|---|---|", *rows, ""])


def _fields(model: type[BaseModel], prefix: str) -> list[tuple[str, str, str]]:
    from sstl_cli.core.documents.base import Document

    # what all documents may hold is said once
    shared = Document.model_fields if issubclass(model, Document) and model is not Document else {}
    found: list[tuple[str, str, str]] = []
    for name, field in model.model_fields.items():
        if name in shared:
            continue
        path = prefix + (field.alias or name)
        inner, mark = _inner(field.annotation)
        found.append((path, _kind(field.annotation), _meaning(field, inner) or _usual(path)))
        if inner is not None:
            found += _fields(inner, f"{path}{mark}.")
    return found


@cache
def _meanings() -> dict[str, str]:
    found: dict[str, str] = tomllib.loads((ROOT / "tools" / "field_meanings.toml").read_text(encoding="utf-8"))
    return found


def _usual(path: str) -> str:
    """Return what a field of this name means everywhere; the longer name wins."""
    words = path.replace("[]", "").replace(".*", "").split(".")
    tails = (".".join(words[i:]) for i in range(len(words)))
    return next((_meanings()[t] for t in tails if t in _meanings()), "")


def _meaning(field: FieldInfo, inner: type[BaseModel] | None) -> str:
    text = field.description or ((inner.__doc__ or "").strip().splitlines() or [""])[0] if inner else field.description or ""
    limits = ", ".join(
        f"{sign} {getattr(m, name):g}"
        for m in field.metadata
        for name, sign in (("gt", ">"), ("ge", "≥"), ("lt", "<"), ("le", "≤"))
        if hasattr(m, name)
    )
    default = field.default
    shown = (
        ""
        if field.is_required() or default is None or default == "" or isinstance(default, (BaseModel, tuple, dict, list))
        else f"default {default}"
    )
    return "; ".join(t for t in (text, limits, shown) if t).replace("|", "\\|")


def _inner(annotation: Any) -> tuple[type[BaseModel] | None, str]:
    """Return the model that a field holds, and how an entry is reached."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return annotation, ""
    origin = get_origin(annotation)
    mark = "[]" if origin in (list, tuple) else ".*" if origin is dict else ""
    for part in get_args(annotation):
        inner, deeper = _inner(part)
        if inner is not None:
            return inner, mark + deeper
    return None, ""


def _kind(annotation: Any) -> str:
    plain = {str: "text", float: "number", int: "whole number", bool: "true or false", Any: "any", type(None): "null"}
    if annotation in plain:
        return plain[annotation]
    origin, parts = get_origin(annotation), get_args(annotation)
    if origin is Literal:
        return ", ".join(f"`{p}`" for p in parts)
    if origin is typing.Annotated:
        return _kind(parts[0])
    if origin in (types.UnionType, typing.Union):
        return " or ".join(dict.fromkeys(_kind(p) for p in parts))
    if origin in (list, tuple):
        inner = [p for p in parts if p is not Ellipsis]
        return "pair of " + _kind(inner[0]) if origin is tuple and len(inner) == 2 else "list of " + _kind(inner[0] if inner else Any)
    return "object" if origin is dict or (isinstance(annotation, type) and issubclass(annotation, BaseModel)) else "any"


def _commands() -> list[tuple[str, list[str]]]:
    from sstl_cli.cli import app as program

    program._register()
    found: list[tuple[str, list[str]]] = []

    def walk(command: Any, path: tuple[str, ...]) -> None:
        inner = getattr(command, "commands", None)
        if inner is None:
            words = [next((o for o in p.opts if o.startswith("--")), "") for p in command.params]
            keys = [w.lstrip("-") for w in words if w and w not in ("--help", "--config")]
            found.append((" ".join(path), keys))
        for name, below in (inner or {}).items():
            walk(below, (*path, name))

    walk(typer.main.get_command(program.app), ())
    return sorted(found)


def main() -> int:
    """Write the page, or compare it."""
    text = page()
    if "--check" in sys.argv:
        same = PAGE.read_text(encoding="utf-8") == text
        print("docs/reference.md is complete" if same else "docs/reference.md is out of date: python tools/reference_doc.py")
        return 0 if same else 1
    PAGE.write_text(text, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
