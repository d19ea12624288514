"""Documents held against what is published of them: every field that one has is a field of its schema."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping
from functools import cache
from typing import Any

import jsonschema

from sstl_cli.cli.render import Screen
from sstl_cli.core import documents
from sstl_cli.core.documents.base import Part
from sstl_cli.core.files import dumps


def closed(schema: Any) -> Any:
    """Return a JSON schema to which a field that it does not name is an error.

    The published ones let such a field pass, as a later version may have added it; this version names all of its own.
    """
    if isinstance(schema, list):
        return [closed(part) for part in schema]
    if not isinstance(schema, dict):
        return schema
    found = {key: closed(part) for key, part in schema.items()}
    return found | {"additionalProperties": False} if "properties" in found else found


@cache
def validator(name: str) -> jsonschema.Draft202012Validator:
    return jsonschema.Draft202012Validator(closed(documents.get(name).json_schema()))


def checked(document: Mapping[str, Any] | Part) -> dict[str, Any]:
    """Return a document as JSON holds it, once it fits its schema and has no field beside it."""
    plain: dict[str, Any] = json.loads(dumps(document.plain() if isinstance(document, Part) else document))
    validator(plain["schema"]).validate(plain)
    return plain


def undeclared(value: Any, path: str = "") -> Iterator[str]:
    """Yield the fields of a document that no model names, with the way to them."""
    if isinstance(value, Part):
        yield from (f"{path}.{name}" for name in value.model_extra or {})
        for name in type(value).model_fields:
            yield from undeclared(getattr(value, name), f"{path}.{name}")
    elif isinstance(value, Mapping):
        for name, part in value.items():
            yield from undeclared(part, f"{path}.{name}")
    elif isinstance(value, (list, tuple)):
        for part in value:
            yield from undeclared(part, f"{path}[]")


def guarded(show: Callable[[Screen, Any], None]) -> Callable[[Screen, Any], None]:
    """Return what shows a document as the program does, if the document fits its model and every field of it is declared."""

    def shown(screen: Screen, document: Any) -> None:
        if isinstance(document, type):
            # its schema is shown
            return show(screen, document)
        plain = document.plain() if isinstance(document, Part) else document
        model = documents.get(str(plain["schema"]))
        found = sorted(set(undeclared(model.model_validate_json(dumps(plain)))))
        assert not found, f"{plain['schema']} has fields that it does not declare: {', '.join(found)}"
        return show(screen, document)

    return shown
