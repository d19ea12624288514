"""The ``sstl`` program: its subcommands, and how every failure ends in one clear line."""

from __future__ import annotations

import importlib
import os
import pkgutil
import sys

import typer

from sstl_cli import cli
from sstl_cli.core.errors import EXIT_FAILED, SstlError, printable

app = typer.Typer(
    name="sstl",
    help="Identify, compensate and diagnose tendon-sheath hysteresis from recorded tension logs.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    context_settings={"auto_envvar_prefix": "SSTL", "help_option_names": ["-h", "--help"]},
    rich_markup_mode=None,
)
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
]


def _register() -> None:
    """Let every module beside this one that has ``register(app)`` add its subcommand."""
    names = [
        m.name for m in pkgutil.iter_modules(cli.__path__) if m.name not in _NOT_COMMANDS and not m.name.startswith("_")
    ]
    rank = {n: i for i, n in enumerate(_ORDER)}
    for name in sorted(names, key=lambda n: (rank.get(n.removesuffix("_"), 99), n)):
        importlib.import_module(f"sstl_cli.cli.{name}").register(app)


def _version(value: bool) -> None:
    if value:
        from sstl_cli import __version__

        typer.echo(f"sstl {__version__}")
        raise typer.Exit


@app.callback()
def _root(
    version: bool = typer.Option(False, "--version", callback=_version, is_eager=True, help="Print the version."),
) -> None:
    pass


def main() -> None:
    """Run the program; errors print one line on standard error and set the exit code."""
    _register()
    try:
        app()
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
