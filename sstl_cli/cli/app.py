"""The ``sstl`` program: its subcommands, and how every failure ends in one clear line."""

from __future__ import annotations

import contextlib
import errno
import importlib
import os
import pkgutil
import signal
import sys
from typing import Any, NoReturn

import typer
from typer.core import TyperGroup
from typer.exceptions import TyperException

from sstl_cli import cli
from sstl_cli.cli._help import polish
from sstl_cli.cli.options import keep_files, name_variables
from sstl_cli.cli.render import begin, show_error
from sstl_cli.cli.streams import drop_output, open_streams, settle_errors, tell
from sstl_cli.core.aside import kept_apart, ledger
from sstl_cli.core.errors import EXIT_DONE, EXIT_FAILED, SstlError, UsageError, cut
from sstl_cli.core.workers import is_interrupt, last_words_said, stop_on_signals

_NOT_COMMANDS = {"app", "options", "origin", "render", "streams"}
# without a file name these come from a standard stream
_NO_SPACE = {errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO}
# the order of the work, and what fits beside the name in the list of commands
_COMMANDS = {
    "simulate": "Simulate recordings of a scenario, with any effects.",
    "import": "Bring a lab's recordings into the log table.",
    "check": "Find everything that is wrong with a table.",
    "info": "Show what is in a table and where it came from.",
    "segment": "Find slopes and biases (Theta) of every run.",
    "train": "Learn the mapping from sensing loop to actuation tendon.",
    "evaluate": "Judge a mapping on held-out configurations.",
    "compensate": "Compute feedforward commands and score them.",
    "diagnose": "Say where the gap lies, which effect causes it, how far.",
    "blind": "Check the diagnosis on effects it cannot see.",
    "reproduce": "Rebuild the paper's tables beside the published values.",
    "report": "Make one HTML page of any outputs.",
    "effects": "List and explain the effects of the catalogue.",
    "export": "Write a controller, a mapping or a log for other programs.",
    "batch": "Run one of these over many files.",
    "watch": "Follow growing logs and raise alarms.",
    "doctor": "Test this installation.",
    "plot": "Draw one figure as a picture file.",
    "schema": "Print the JSON Schema of a document.",
}


def _rank(name: str) -> tuple[int, str]:
    """Return the place of a command in the help: the order of the work, then the alphabet."""
    order = list(_COMMANDS)
    return (order.index(name) if name in order else len(order), name)


class Commands(TyperGroup):
    """The subcommands in the order of the work."""

    def list_commands(self, ctx: typer.Context) -> list[str]:  # type: ignore[override]
        """Return the names in the order in which a user meets them."""
        return sorted(super().list_commands(ctx), key=_rank)

    def get_command(self, ctx: typer.Context, cmd_name: str) -> Any:  # type: ignore[override]
        """Return a subcommand whose options are read from variables named like them."""
        command = super().get_command(ctx, cmd_name)
        if command is not None:
            command.short_help = _COMMANDS.get(cmd_name, command.short_help)
            polish(command)
            name_variables(command, f"SSTL_{cmd_name.upper()}")
            keep_files(command)
        return command

    def format_options(self, ctx: typer.Context, formatter: Any) -> None:  # type: ignore[override]
        """Write the program's own options without the variables, which nobody sets for them."""
        for parameter in self.params:
            parameter.show_envvar = False  # type: ignore[attr-defined]
        super().format_options(ctx, formatter)

    def invoke(self, ctx: typer.Context) -> Any:  # type: ignore[override]
        """Run a subcommand; Ctrl-C becomes an error of ours before typer makes a silent exit of it."""
        try:
            return super().invoke(ctx)
        except KeyboardInterrupt:
            raise _interrupted() from None


app = typer.Typer(
    name="sstl",
    cls=Commands,
    help="Identify, compensate and diagnose tendon-sheath hysteresis from recorded tension logs.",
    no_args_is_help=True,
    epilog="Each command has --help with an example; 'sstl COMMAND -q' keeps stderr for errors. First steps: docs/tutorial.md.",
    pretty_exceptions_enable=False,
    context_settings={"auto_envvar_prefix": "SSTL", "help_option_names": ["-h", "--help"]},
    rich_markup_mode=None,
)


def _register() -> None:
    """Let every module beside this one that has ``register(app)`` add its subcommand (once a process)."""
    if app.registered_commands:
        return
    names = [m.name for m in pkgutil.iter_modules(cli.__path__) if m.name not in _NOT_COMMANDS and not m.name.startswith("_")]
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
        False, "--version", "-V", callback=_version, is_eager=True, allow_from_autoenv=False, help="Print the version."
    ),
) -> None:
    pass


def program() -> None:
    """Run the program as a process of its own."""
    import warnings

    if not sys.warnoptions and not os.environ.get("SSTL_DEBUG"):
        # what a library tells its developers, with paths of its sources, is no message of ours; workers inherit it
        os.environ["PYTHONWARNINGS"] = "ignore"
        warnings.simplefilter("ignore")
    stop_on_signals(f"sstl: {_interrupted().line()}\n")
    try:
        main()
    except KeyboardInterrupt:
        # it came where the command's own handling did not reach: before it began, or while it tidied up
        _end(_interrupted())
    finally:
        last_words_said()
        settle_errors()
        # the outputs are whole or gone by now: Ctrl-C while Python shuts down must not look like a crash
        for kind in (signal.SIGINT, signal.SIGTERM):
            signal.signal(kind, signal.SIG_IGN)


def main() -> NoReturn:
    """Run the program and exit; errors print one line on standard error (with --json a document too)."""
    with kept_apart():
        _main()


def _main() -> NoReturn:
    open_streams()
    begin()
    try:
        _require_folder()
        _register()
        try:
            code = app(standalone_mode=False, prog_name="sstl")
        finally:
            # what is still buffered must fail here, where it can be told, not while Python shuts down
            sys.stdout.flush()
        sys.exit(code or EXIT_DONE)
    except SstlError as error:
        book = ledger()
        if book is not None and (aside := book.brief()):
            error.fix += f" (set aside before: {aside})"
        _end(error)
    except TyperException as error:
        _usage(error)
    except KeyboardInterrupt:
        _end(_interrupted())
    except BrokenPipeError:
        # the reader of our output went away (for example `| head`): not an error of ours
        drop_output()
        sys.exit(EXIT_FAILED)
    except MemoryError:
        _end(SstlError("out of memory", fix="split the log with 'sstl import' or use a machine with more", code="E002"))
    except Exception as error:
        if is_interrupt(error):
            _end(_interrupted())
        if os.environ.get("SSTL_DEBUG"):
            raise
        if isinstance(error, OSError) and (error.filename or error.errno in _NO_SPACE):
            drop_output()
            where = str(error.filename or "standard output")
            what = f"cannot be read or written: {error.strerror}"
            _end(SstlError(what, where=where, fix="check space and rights", code="E005"))
        if isinstance(error, UnicodeEncodeError) and error.reason == "surrogates not allowed":
            # names of files alone hold what no text does
            _end(SstlError("its name is no UTF-8, which Parquet files have to have", where=error.object, fix="rename it", code="E005"))
        text = f"{type(error).__name__}: {error}"[:300]
        _end(SstlError(f"internal error, {text}", fix="set SSTL_DEBUG=1 for details and report it", code="E003"))


def _require_folder() -> None:
    """Raise SstlError where the folder that the program was started in was removed: names of files mean nothing there."""
    try:
        os.getcwd()
    except OSError:
        raise SstlError("the working folder is gone", where=".", fix="change to one that is there", code="E007") from None


def _interrupted() -> SstlError:
    return SstlError("interrupted; nothing half-written was left behind", code="E001")


def _end(error: SstlError) -> NoReturn:
    tell(f"sstl: {error.line()}")
    show_error(error)
    sys.exit(error.exit_code)


def _usage(error: Any) -> NoReturn:
    """End with what typer says of a wrong option or argument, after the usage line of the command."""
    if isinstance(getattr(error, "message", None), str):
        error.message = cut(error.message)
    with contextlib.suppress(OSError):
        error.show()
    if error.exit_code:
        message = " ".join(error.format_message().split())
        if message:
            show_error(UsageError(message, fix="see the command's --help", code="E004"))
    sys.exit(error.exit_code)
