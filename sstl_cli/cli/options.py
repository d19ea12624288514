"""Options shared by the subcommands; precedence is flag, environment, --config file, default."""

from __future__ import annotations

import functools
import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any

import typer

from sstl_cli.cli.origin import remember

# the options that name what a command writes: every other one names what it reads, also where an output's name is made from it
OUTPUTS = frozenset(
    {"--out", "--phases", "--scores", "--history", "--predictions", "--save-sim", "--next-out", "--junit", "--summary"}
    # the argument of `blind library`
    | {"file"}
)


def _load_config(context: typer.Context, path: Path | None) -> Path | None:
    """Make the TOML file the defaults of this command: top-level keys, then the command's own table.

    ``[blind.make]`` is the table of ``sstl blind make``. A top-level key that only other commands know is theirs.
    """
    remember(context, path)
    if path is None:
        return None
    from sstl_cli.core.config import read_toml
    from sstl_cli.core.errors import UsageError, nearest

    known = _names(context.command)
    document = read_toml(path)
    _require_tables(context.find_root().command, document, [], path)
    table: Any = document
    for name in path_of(context):
        table = table.get(name, {})
        if not isinstance(table, dict):
            raise UsageError(f"'{name}' is not a table", where=str(path), fix=f"write [{name}]", code="E151")
    shared = {k: v for k, v in document.items() if not isinstance(v, dict)}
    # looked for only where needed: it visits every command
    others = _names_of_all(context.find_root().command) if any(_plain(k) not in known for k in shared) else set()
    defaults = {}
    for key, value in [*shared.items(), *((k, v) for k, v in table.items() if table is not document)]:
        if _plain(key) in known:
            defaults[known[_plain(key)]] = value
        elif isinstance(value, dict) or (key in shared and _plain(key) in others):
            continue
        else:
            hint = nearest(key, [k.replace("_", "-") for k in known])
            raise UsageError(f"unknown key '{key}' ({hint})", where=str(path), code="E150")
    context.default_map = {**(context.default_map or {}), **defaults}
    return path


def _require_tables(command: Any, table: dict[str, Any], words: list[str], path: Path) -> None:
    """Raise UsageError E150 if a table is no command's, of this one and those below it: it would have no effect."""
    from sstl_cli.core.errors import UsageError, nearest

    inner = getattr(command, "commands", {})
    for name, value in table.items():
        if not isinstance(value, dict):
            continue
        here = [*words, name]
        if name not in inner:
            # a command without others below it has keys only
            known = [".".join([*words, n]) for n in inner]
            fix = nearest(".".join(here), known) if known else f"give its options as keys of [{'.'.join(words)}]"
            raise UsageError(f"unknown table [{'.'.join(here)}] ({fix})", where=str(path), code="E150")
        _require_tables(inner[name], value, here, path)


def path_of(context: typer.Context) -> list[str]:
    """Return the words that name the command, without the program's own."""
    names: list[str] = []
    while context.parent is not None:
        names.insert(0, context.info_name or "")
        context = context.parent  # type: ignore[assignment]
    return names


def _plain(key: str) -> str:
    return key.replace("-", "_")


def _names(command: Any) -> dict[str, str]:
    """Return the parameter of each option (``cutoff_hz``) and argument of a command."""
    found = {}
    for parameter in command.params:
        words = [o.lstrip("-") for o in parameter.opts if o.startswith("--")] or [parameter.name]
        found.update({_plain(word): parameter.name for word in words})
    return {k: v for k, v in found.items() if k not in ("config", "help")}


def keep_files(command: Any) -> None:
    """Let no output of a command, or of those below it, take the place of a file that another of its options names."""
    for inner in getattr(command, "commands", {}).values():
        keep_files(inner)
    body = command.callback
    if body is None or getattr(command, "commands", None):
        return
    labels = {p.name: p.opts[0] if p.opts[0].startswith("-") else (p.metavar or p.name).upper() for p in command.params}
    written = [p for p in command.params if set(p.opts) & OUTPUTS]
    outputs = {labels[p.name] for p in written}
    for p in written:
        # the folder of a reproduction, and what names a folder for C source
        if p.metavar not in ("DIR", "PATH"):
            _name_a_file(p, labels[p.name])

    @functools.wraps(body)
    def kept(**values: Any) -> Any:
        from sstl_cli.core.files import call

        _require_values({labels[p.name]: values.get(p.name) for p in command.params if p.name in labels and p.default != ""})
        with call({labels[name]: value for name, value in values.items() if name in labels}, outputs):
            return body(**values)

    command.callback = kept


def _name_a_file(parameter: Any, option: str) -> None:
    """Let an output take no folder's name: a path would lose the slash at its end, and be a file."""
    processed = parameter.process_value

    def process_value(context: Any, value: Any) -> Any:
        from sstl_cli.core.errors import UsageError

        if isinstance(value, str) and value.endswith(("/", os.sep)):
            raise UsageError("is a folder", where=f"{option} {value}", fix="give a file name", code="E101")
        return processed(context, value)

    parameter.process_value = process_value


def _require_values(given: Mapping[str, object]) -> None:
    """Raise UsageError for an option with an empty text, as a script gives whose variable is not set: a gate would not be asked."""
    from sstl_cli.core.errors import UsageError

    for option, value in given.items():
        if option.startswith("--") and "" in (value if isinstance(value, (list, tuple)) else [value]):
            raise UsageError("is empty", where=option, fix="give a value, or leave it out", code="E008")


def name_variables(command: Any, prefix: str) -> None:
    """Let each option be read from ``PREFIX_OPTION``; typer alone would use the name in the source."""
    for parameter in command.params:
        flags = [o for o in parameter.opts if o.startswith("--")]
        if flags:
            parameter.envvar = f"{prefix}_{_plain(flags[0].lstrip('-')).upper()}"
    for name, inner in getattr(command, "commands", {}).items():
        name_variables(inner, f"{prefix}_{_plain(name).upper()}")


def _names_of_all(command: Any) -> set[str]:
    inner = getattr(command, "commands", {}).values()
    return set(_names(command)).union(*(_names_of_all(c) for c in inner))


@contextmanager
def usage(option: str) -> Iterator[None]:
    """Make an error in the value of an option a usage error (exit code 2) that names the option."""
    from sstl_cli.core.errors import SstlError, UsageError

    try:
        yield
    except SstlError as error:
        raise UsageError(error.what, where=option, fix=error.fix, code=error.code) from None


def effect_ids(text: str | None, option: str) -> tuple[str, ...]:
    """Return the ids in a comma-separated list of effects; UsageError for one that is not in the catalogue."""
    from sstl_cli.physics.effects import get

    with usage(option):
        return tuple(get(s.strip()).id for s in (text or "").split(",") if s.strip())


Json = Annotated[bool, typer.Option("--json", help="One JSON document on stdout; narration on stderr.")]
Force = Annotated[bool, typer.Option("--force", help="Overwrite existing outputs.")]
NoPhysics = Annotated[bool, typer.Option("--no-physics", help="Do not judge by physics (docs/gate.md): I know better.")]
Seed = Annotated[int, typer.Option("--seed", min=0, max=2**63 - 1, help="Seed of the random numbers.")]
Config = Annotated[
    Path | None,
    typer.Option(
        "--config",
        callback=_load_config,
        is_eager=True,
        metavar="FILE.toml",
        help="Options from a TOML file (flag > environment SSTL_COMMAND_OPTION > file > default).",
    ),
]
Out = Annotated[Path, typer.Option("--out", "-o", help="Output file.")]
