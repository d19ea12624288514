"""Options shared by the subcommands; precedence is flag, environment, --config file, default."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated, Any

import typer


def _load_config(context: typer.Context, path: Path | None) -> Path | None:
    """Make the TOML file (or its table named like the subcommand) the defaults of this command."""
    if path is None:
        return None
    from sstl_cli.core.config import read_toml
    from sstl_cli.core.errors import UsageError, nearest

    document = read_toml(path)
    name = context.info_name or ""
    values: dict[str, Any] = document.get(name, {k: v for k, v in document.items() if not isinstance(v, dict)})
    known = {p.name: p for p in context.command.params if p.name not in ("config", "help")}
    defaults = {}
    for key, value in values.items():
        parameter = key.replace("-", "_")
        if parameter not in known:
            hint = nearest(key, [k.replace("_", "-") for k in known if k])
            raise UsageError(f"unknown key '{key}' ({hint})", where=str(path), code="E150")
        defaults[parameter] = value
    context.default_map = {**(context.default_map or {}), **defaults}
    return path


Json = Annotated[bool, typer.Option("--json", help="One JSON document on stdout; narration on stderr.")]
Force = Annotated[bool, typer.Option("--force", help="Overwrite existing outputs.")]
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


def command_line() -> str:
    """Return the command line for provenance: option values as typed, folders removed.

    Folders are dropped so that the same inputs in another folder give the same bytes.
    """
    words = [Path(w).name if "/" in w and "://" not in w else w for w in sys.argv[1:]]
    return " ".join(["sstl", *words])
