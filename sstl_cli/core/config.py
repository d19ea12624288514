"""TOML configuration read into checked, frozen models; a wrong key answers with the nearest."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path
from typing import Any, TypeVar

from pydantic import BaseModel, ConfigDict, ValidationError

from sstl_cli.core.errors import SstlError, nearest
from sstl_cli.core.files import MAX_DEPTH, deeper_than, require_regular

MAX_TOML_BYTES = 4 << 20
# strings and comments, to the end of the line or the text where they do not close
_NO_KEY = re.compile(r'''"""(?:\\.|[^\\])*?(?:"""|\Z)|\'\'\'.*?(?:\'\'\'|\Z)|"(?:\\.|[^"\\\n])*"?|'[^'\n]*'?|#[^\n]*''', re.DOTALL)
_BETWEEN_KEYS = re.compile(r"[\[\]{},=\n]")


class Model(BaseModel):
    """Base of every configuration model: frozen, unknown keys refused, no NaN or infinity."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


M = TypeVar("M", bound=BaseModel)


def read_toml(path: Path) -> dict[str, Any]:
    """Return a TOML document; SstlError where it cannot be read or parsed."""
    require_regular(path)
    try:
        if path.stat().st_size > MAX_TOML_BYTES:
            raise SstlError("is larger than 4 MiB", where=str(path), fix="give a TOML file", code="E140")
        text = path.read_text(encoding="utf-8")
        # the parser's memory grows with the square of the parts of a key
        if any(piece.count(".") >= MAX_DEPTH for piece in _BETWEEN_KEYS.split(_NO_KEY.sub("", text))):
            raise SstlError(f"has a key of more than {MAX_DEPTH} parts", where=str(path), fix="shorten it", code="E142")
        document = tomllib.loads(text)
        if deeper_than(document, MAX_DEPTH):
            raise SstlError(f"is nested deeper than {MAX_DEPTH} levels", where=str(path), fix="flatten it", code="E142")
        return document
    except OSError as error:
        raise SstlError(f"cannot be read: {error.strerror}", where=str(path), fix="check path and rights", code="E141") from None
    except (ValueError, RecursionError) as error:
        raise SstlError(
            # what follows is advice to programmers
            f"is not valid TOML ({str(error).split('; use sys')[0][:120]})",
            where=str(path),
            fix="correct that place; texts stand in quotes",
            code="E142",
        ) from None


def parse(model: type[M], document: Any, where: str) -> M:
    """Return ``document`` as a checked model; the first problem becomes one clear line."""
    try:
        return model.model_validate(document)
    except ValidationError as error:
        raise SstlError(_problem(model, error), where=where, code="E143") from None


def _problem(model: type[BaseModel], error: ValidationError) -> str:
    first = error.errors(include_url=False)[0]
    path = ".".join(str(p) for p in first["loc"]) or "document"
    if first["type"] == "extra_forbidden":
        return f"unknown key '{path}' ({nearest(str(first['loc'][-1]), _keys_at(model, first['loc'][:-1]))})"
    found = f", found {first['input']!r:.60}" if first["type"] != "missing" else ""
    return f"'{path}': {first['msg']}{found}"


def _keys_at(model: type[BaseModel], path: tuple[int | str, ...]) -> list[str]:
    """Return the field names of the model that stands at ``path`` inside ``model``."""
    for step in path:
        field = model.model_fields.get(str(step)) if not isinstance(step, int) else None
        inner = _model_in(field.annotation) if field else None
        if inner is not None:
            model = inner
    return list(model.model_fields)


def _model_in(annotation: Any) -> type[BaseModel] | None:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return annotation
    for argument in getattr(annotation, "__args__", ()):
        found = _model_in(argument)
        if found is not None:
            return found
    return None
