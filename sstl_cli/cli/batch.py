"""``sstl batch``: one subcommand over many files, on this machine or on a cluster."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from typer.core import TyperCommand

from sstl_cli.cli._gathered import gathered
from sstl_cli.cli.options import Config, Force, Json
from sstl_cli.cli.render import Screen, many

if TYPE_CHECKING:
    from sstl_cli.cli._batch_places import Place
    from sstl_cli.steps.batch import Outcome

EPILOG = """Examples:

  sstl batch segment logs/*.parquet --out-dir theta -- --cutoff-hz 20

  sstl batch segment logs/*.parquet --out-dir theta -- --phases {name}-phases.parquet

  sstl batch import 's3://rig/day1/*.csv' --out-dir s3://rig/logs --scheduler tcp://10.0.0.5:8786 -- --mapping rig.toml
"""
REST = "sstl.batch.rest"
SHOWN = 40


class WithRest(TyperCommand):
    """A command that keeps the words after ``--`` for the subcommand it runs."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Take the words after ``--`` aside and parse the others."""
        if "--" in args:
            at = args.index("--")
            ctx.meta[REST] = args[at + 1 :]
            args = args[:at]
        return super().parse_args(ctx, args)


def register(app: typer.Typer) -> None:
    """Add the subcommand."""
    app.command("batch", cls=WithRest, epilog=EPILOG)(batch)


@dataclass(frozen=True, kw_only=True)
class Asked:
    """What a call asks for."""

    context: typer.Context
    command: Annotated[str, typer.Argument(metavar="COMMAND", help="import, check, segment, diagnose, report, ...")]
    files: Annotated[list[str], typer.Argument(metavar="FILE", help="Files, or addresses such as s3://rig/*.csv.")]
    out_dir: Annotated[str, typer.Option("--out-dir", help="Folder (or address) for one output a file.")]
    workers: Annotated[int, typer.Option(min=0, max=1024, help="Local processes (0: one a core).")] = 0
    scheduler: Annotated[str | None, typer.Option(metavar="tcp://HOST:PORT", help="Run on the workers of this Dask scheduler instead.")] = (
        None
    )
    force: Force = False
    as_json: Json = False
    config: Config = None


@gathered
def batch(asked: Asked) -> None:
    """Run a subcommand over many files; its options stand after --.

    What an earlier batch completed from the same input is skipped. A bad file is listed and does not stop the rest
    (exit code 3). Outputs are the same bytes for any number of workers, on a cluster too.
    """
    from sstl_cli.cli import _batch_places as places
    from sstl_cli.cli._batch_pool import default_workers, run_all
    from sstl_cli.cli._batch_worker import Job
    from sstl_cli.cli.origin import refuse
    from sstl_cli.core.errors import SstlError
    from sstl_cli.steps import batch as step

    screen, command, context = Screen(asked.as_json), asked.command, asked.context
    if asked.scheduler:
        refuse("--scheduler", ("--workers",), "the cluster has workers of its own")
    rest: list[str] = context.meta.get(REST, [])
    step.form_of(command, rest)
    sources = places.expand(asked.files)
    items = step.plan(command, sources, rest)
    named = _parse_once(context, command, items[0])
    out, workers = places.place(asked.out_dir), asked.workers
    if out.own or any(places.place(s).own for s in sources):
        if asked.scheduler:
            raise SstlError("memory:// exists in one process only", where=asked.scheduler, fix="leave out --scheduler", code="E045")
        workers = 1
    prefix = f"SSTL_{command.upper()}_"
    environment = {k: v for k, v in sorted(os.environ.items()) if k.startswith(prefix)}
    _keep_inputs(out, items, named)
    jobs = [Job(command, item, asked.out_dir, asked.force, environment, os.getcwd(), named) for item in items]
    with _folder(out), screen.progress(f"batch {command}", len(jobs)) as advance:
        outcomes = run_all(jobs, min(workers or default_workers(), len(jobs)), asked.scheduler, lambda _: advance(1))
    _show(screen, command, outcomes)
    screen.finish(step.document(command, asked.out_dir, rest, outcomes), step.exit_code(outcomes))


def _keep_inputs(out: Place, items: list[Any], named: tuple[str, ...]) -> None:
    """Refuse outputs that are inputs of the same batch, or read by its subcommand (``named``), or no regular files."""
    from sstl_cli.cli._batch_places import place
    from sstl_cli.core.files import keep_safe, require_writable

    if not out.local:
        return
    sources = [place(item.source) for item in items]
    inputs = [*(s.path for s in sources if s.local and os.path.isfile(s.path)), *named]
    keep_safe([Path(name) for name in dict.fromkeys(inputs)], "an input of the batch")
    for item in items:
        for name in (item.output, *item.side):
            target = Path(out.inside(name).path)
            if os.path.lexists(target):
                require_writable(target, True)


def _parse_once(context: typer.Context, command: str, item: Any) -> tuple[str, ...]:
    """Let a wrong option after ``--`` be one usage error instead of one failure a file; return the files that the options name."""
    from sstl_cli.cli._batch_named import named_files, require_outputs_of_its_own
    from sstl_cli.cli._batch_places import WORK
    from sstl_cli.steps.batch import FORMS

    inner = context.find_root().command.get_command(context, command)  # type: ignore[attr-defined]
    form = FORMS[command]
    words = [*([form.option] if form.option else []), item.source]
    # a name that nobody gives: any other output was named after --
    out = f"{WORK}/{item.output}"
    words += [] if form.printed else ["--out", out]
    parsed = inner.make_context(command, [*words, *item.options], parent=context.find_root())
    parsed.close()
    require_outputs_of_its_own(parsed, form, out)
    outputs = {p.name for p in inner.params if set(p.opts) & {"--out", *form.side}}
    return named_files({name: value for name, value in parsed.params.items() if name not in outputs}, item)


@contextmanager
def _folder(out: Place) -> Iterator[None]:
    """Make the output folder, clear what a killed batch left, and keep a second batch out of it."""
    from sstl_cli.cli._batch_places import WORK, telling
    from sstl_cli.core.errors import SstlError
    from sstl_cli.core.files import require_followed

    if out.local:
        require_followed(Path(out.path))
        if os.path.exists(out.path) and not os.path.isdir(out.path):
            raise SstlError("is a file, not a folder", where=out.url, fix="give another --out-dir", code="E032")
    with telling(out.url):
        out.fs.makedirs(out.inside(WORK).path, exist_ok=True)
    if not out.local:
        yield
        return
    work = Path(out.path, WORK)
    with telling(out.url):
        lock = open(work / "lock", "a")
    with lock:
        if not _locked(lock):
            raise SstlError("another batch is writing here", where=out.url, fix="wait for it, or give another folder", code="E035")
        _clear(work)
        try:
            yield
        finally:
            # workers that were stopped in the middle
            _clear(work)


def _clear(work: Path) -> None:
    """Remove what stopped workers left."""
    import shutil

    for stale in [*work.glob("work-*"), *work.glob("*.tmp")]:
        if stale.is_dir():
            shutil.rmtree(stale, ignore_errors=True)
        else:
            stale.unlink(missing_ok=True)


def _locked(lock: Any) -> bool:
    try:
        import fcntl
    except ImportError:
        # no such lock on this system: outputs are still whole, only work may be done twice
        return True
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    return True


def _show(screen: Screen, command: str, outcomes: list[Outcome]) -> None:
    from sstl_cli.steps.batch import counts

    parts = ", ".join(f"{n} {state.replace('_', ' ')}" for state, n in counts(outcomes).items() if n)
    screen.say(f"{command}: {many(len(outcomes), 'file')}: {parts}")
    told = [o for o in outcomes if o.state not in ("done", "skipped")]
    for outcome in told[:SHOWN]:
        screen.note(f"{outcome.state.replace('_', ' ')}: {outcome.source}: {outcome.line}")
    if len(told) > SHOWN:
        screen.note(f"and {len(told) - SHOWN} more (all of them with --json)")
