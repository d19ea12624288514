"""The options of a command as one frozen dataclass: a field an option, in the order of its help."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import MISSING, fields, is_dataclass
from functools import wraps
from inspect import Parameter, Signature
from typing import Any, TypeVar, get_type_hints

T = TypeVar("T")


def gathered(body: Callable[[T], None]) -> Callable[..., None]:
    """Let typer see the fields of the dataclass that a command takes as the options of the command.

    A field that is a dataclass itself holds options that several commands share; they stand in its place.
    """
    (options,) = (hint for name, hint in get_type_hints(body).items() if name != "return")

    @wraps(body)
    def command(**values: Any) -> None:
        body(_filled(options, values))

    command.__signature__ = Signature(list(_parameters(options)))  # type: ignore[attr-defined]
    # typer asks for these too, and would find those of the body
    command.__annotations__ = {}
    return command


def _parameters(options: Any) -> Iterator[Parameter]:
    hints = get_type_hints(options, include_extras=True)
    for field in fields(options):
        hint = hints[field.name]
        if is_dataclass(hint):
            yield from _parameters(hint)
        else:
            default = Parameter.empty if field.default is MISSING else field.default
            yield Parameter(field.name, Parameter.KEYWORD_ONLY, annotation=hint, default=default)


def _filled(options: Any, values: Mapping[str, Any]) -> Any:
    hints = get_type_hints(options)
    return options(**{f.name: _filled(hints[f.name], values) if is_dataclass(hints[f.name]) else values[f.name] for f in fields(options)})
