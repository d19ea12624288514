"""The ``sstl`` program: its subcommands, and how every failure ends in one clear line."""

from __future__ import annotations

import importlib
import os
import pkgutil
import signal
import sys
from typing import Any

import typer
from typer.core import TyperGroup

from sstl_cli import cli
from sstl_cli.cli.options import name_variables
from sstl_cli.core.errors import EXIT_FAILED, SstlError, printable

_NOT_COMMANDS = {"app", "options", "render"}
_ORDER = [
    "simulate",
    "import",
    "check",
    "info",
    "segment",
    "train",
    "evaluate",
    "compensate",
    "diagnose",
    "blind",
    "reproduce",
    "report",
    "effects",
    "export",
    "batch",
    "watch",
]


def _rank(name: str) -> tuple[int, str]:
    """Return the place of a command in the help: the order of the work, then the alphabet."""
    return (_ORDER.index(name) if name in _ORDER else len(_ORDER), name)


class Commands(TyperGroup):
    """The subcommands in the order of the work."""

    def list_commands(self, ctx: typer.Context) -> list[str]:  # type: ignore[override]
        """Return the names in the order in which a user meets them."""
        return sorted(super().list_commands(ctx), key=_rank)

    def get_command(self, ctx: typer.Context, cmd_name: str) -> Any:  # type: ignore[override]
        """Return a subcommand whose options are read from variables named like them."""
        command = super().get_command(ctx, cmd_name)
        if command is not None:
            name_variables(command, f"SSTL_{cmd_name.upper()}")
        return command

    def invoke(self, ctx: typer.Context) -> Any:  # type: ignore[override]
        """Run a subcommand; Ctrl-C becomes an error of ours before typer makes a silent exit of it."""
        try:
            return super().invoke(ctx)
        except KeyboardInterrupt:
            raise SstlError("interrupted; nothing half-written was left behind", code="E001") from None


app = typer.Typer(
    name="sstl",
    cls=Commands,
    help="Identify, compensate and diagnose tendon-sheath hysteresis from recorded tension logs.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    context_settings={"auto_envvar_prefix": "SSTL", "help_option_names": ["-h", "--help"]},
    rich_markup_mode=None,
)


def _register() -> None:
    """Let every module beside this one that has ``register(app)`` add its subcommand (once a process)."""
    if app.registered_commands:
        return
    names = [
        m.name for m in pkgutil.iter_modules(cli.__path__) if m.name not in _NOT_COMMANDS and not m.name.startswith("_")
    ]
    for name in sorted(names, key=lambda n: _rank(n.removesuffix("_"))):
        importlib.import_module(f"sstl_cli.cli.{name}").register(app)


def _version(value: bool) -> None:
    if value:
        from sstl_cli import __version__

        typer.echo(f"sstl {__version__}")
        raise typer.Exit


@app.callback()
def _root(
    version: bool = typer.Option(
        False, "--version", callback=_version, is_eager=True, allow_from_autoenv=False, help="Print the version."
    ),
) -> None:
    pass


def program() -> None:
    """Run the program as a process of its own."""
    try:
        main()
    finally:
        # the outputs are whole or gone by now: Ctrl-C while Python shuts down must not look like a crash
        signal.signal(signal.SIGINT, signal.SIG_IGN)


def main() -> None:
    """Run the program; errors print one line on standard error and set the exit code."""
    try:
        _register()
        try:
            app()
        finally:
            # what is still buffered must fail here, where it can be told, not while Python shuts down
            sys.stdout.flush()
    except SstlError as error:
        _end(error.line(), error.exit_code)
    except KeyboardInterrupt:
        _end("[E001] interrupted; nothing half-written was left behind", EXIT_FAILED)
    except BrokenPipeError:
        # the reader of our output went away (for example `| head`): not an error of ours
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        sys.exit(EXIT_FAILED)
    except MemoryError:
        _end("[E002] out of memory; split the log with 'sstl import' or use a machine with more", EXIT_FAILED)
    except Exception as error:
        if os.environ.get("SSTL_DEBUG"):
            raise
        text = printable(f"{type(error).__name__}: {error}")[:300]
        _end(f"[E003] internal error, {text}; set SSTL_DEBUG=1 for details and report it", EXIT_FAILED)


def _end(line: str, code: int) -> None:
    print(f"sstl: {line}", file=sys.stderr)
    sys.exit(code)
