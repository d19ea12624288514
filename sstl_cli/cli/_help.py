"""Help by groups of options, and the options that every command has."""

from __future__ import annotations

from functools import partial
from typing import Any

import typer

from sstl_cli.cli import render
from sstl_cli.cli.options import path_of

GROUPS = ("Options", "Outputs", "Gates (exit 4 if missed)", "Common options")
# what a value is, in words of everyday
PLAIN = {
    "list[Path]": "path",
    "list[float]": "number",
    "list[str]": "text",
    "str": "text",
    "int": "number",
    "float": "number",
    "int range": "number",
    "float range": "number",
}
COMMON = {"force", "json", "config", "seed", "workers", "help", "quiet", "verbose"}


def polish(command: Any) -> None:
    """Give a command and its subcommands ``--quiet`` and ``--verbose``, and a help that is grouped."""
    inner = getattr(command, "commands", None)
    if inner is None and not any(p.name == "quiet" for p in command.params):
        command.params += _narration()
    for parameter in command.params:
        # one line below tells the name of every variable
        parameter.show_envvar = False
    command.format_options = partial(_options, command)
    for below in (inner or {}).values():
        polish(below)


def group_of(option: Any) -> str:
    """Return the heading under which an option is listed, by its name and by what its help says."""
    text = option.help or ""
    words = {o.lstrip("-") for o in option.opts}
    if words & COMMON:
        return GROUPS[3]
    if text.startswith("Gate") or "xit 4" in text:
        return GROUPS[2]
    if "out" in words or text.startswith(("Write", "Also write", "Output", "Folder for")):
        return GROUPS[1]
    return GROUPS[0]


def _options(command: Any, ctx: Any, formatter: Any) -> None:
    arguments: list[tuple[str, str]] = []
    groups: dict[str, list[tuple[str, str]]] = {g: [] for g in GROUPS}
    for parameter in command.get_params(ctx):
        record = parameter.get_help_record(ctx)
        if record is None:
            continue
        name, text = record
        record = _plain(name), text.replace("0<=x<=9223372036854775807", "a whole number")
        if parameter.param_type_name == "argument":
            arguments.append(record)
        else:
            groups[group_of(parameter)].append(record)
    for title, rows in (("Arguments", arguments), *groups.items()):
        if rows:
            with formatter.section(title):
                formatter.write_dl(rows)
    if getattr(command, "commands", None) is None:
        variable = "_".join(["SSTL", *path_of(ctx)]).replace("-", "_").upper()
        formatter.write_paragraph()
        with formatter.indentation():
            formatter.write_text(f"Options can be set by variables too ({variable}_OPTION), or by keys of a --config file.")


def _plain(name: str) -> str:
    """Return the left column of an option with the kind of its value in plain words.

    Examples
    --------
    >>> _plain("--seeds <int range>"), _plain("LOG <list[Path]>"), _plain("--format <c|json>")
    ('--seeds <number>', 'LOG <path>', '--format <c|json>')
    """
    head, opens, kind = name.rpartition("<")
    return f"{head}<{PLAIN.get(kind[:-1], kind[:-1])}>" if opens and kind.endswith(">") else name


def _narration() -> list[Any]:
    """Return the options ``--quiet`` and ``--verbose``; what they ask for goes to the renderer, not to the command."""
    template = typer.Typer(add_completion=False, rich_markup_mode=None)
    template.command()(_narrated)
    found = [p for p in typer.main.get_command(template).params if p.name in ("quiet", "verbose")]
    for parameter in found:
        parameter.expose_value = False
    return found


def _narrate(parameter: typer.CallbackParam, value: bool) -> bool:
    if value:
        render.narrate(str(parameter.name))
    return value


def _narrated(
    quiet: bool = typer.Option(False, "--quiet", "-q", callback=_narrate, help="Errors only on stderr: no narration, no progress."),
    verbose: bool = typer.Option(
        False, "--verbose", "-v", callback=_narrate, help="Say on stderr how long it took and with how much memory."
    ),
) -> None:
    pass
