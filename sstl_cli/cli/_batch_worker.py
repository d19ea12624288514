"""What a worker of ``sstl batch`` does with one file: stage, run the subcommand, publish, note it down."""

from __future__ import annotations

import contextlib
import hashlib
import io
import json
import os
import shutil
import sys
import tempfile
import threading
import uuid
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from sstl_cli.cli import _batch_places as places
from sstl_cli.core.errors import EXIT_DONE, EXIT_FAILED, EXIT_GATE, EXIT_SET_ASIDE, SstlError
from sstl_cli.core.workers import at_work_in, end_with
from sstl_cli.steps import batch as step

if TYPE_CHECKING:
    from sstl_cli.core.documents.outputs import State

# the subcommand sees the process's arguments and streams, of which there is one set
# (a subcommand that runs a batch in this same thread comes by twice)
_ONE_AT_A_TIME = threading.RLock()
INTERRUPTED = "E001"
_STATES: dict[int, State] = {EXIT_DONE: "done", EXIT_SET_ASIDE: "set_aside", EXIT_GATE: "gate"}


@dataclass(frozen=True)
class Job:
    """One item of a batch with all a worker on another machine needs to know."""

    command: str
    item: step.Item
    out_dir: str
    force: bool
    environment: dict[str, str]
    root: str
    named: tuple[str, ...] = ()


def run_one(job: Job) -> step.Outcome:
    """Bring one file to its output and say what became of it; never raises for a bad file."""
    try:
        return _run(job)
    except SstlError as error:
        return step.Outcome(job.item.source, job.item.output, "failed", EXIT_FAILED, error.line())


def run_here(job: Job, program: int) -> step.Outcome:
    """Do as :func:`run_one` in a process of this machine that ends with the program of that process number."""
    end_with(program)
    return run_one(job)


def _run(job: Job) -> step.Outcome:
    folder, source = places.place(job.out_dir, job.root), places.place(job.item.source, job.root)
    names = (job.item.output, *job.item.side)
    with _staging(folder) as work:
        local, digest = _staged(source, work)
        inputs = {source.url: digest, **_option_files(job)}
        wanted = step.wanted_record(job.command, job.item, inputs, job.environment)
        record_at = folder.inside(places.WORK, job.item.output + ".json")
        record = step.Record.of(places.read_record(record_at))
        with places.telling(folder.url):
            present = {n: folder.inside(n).sha256() for n in names}
        where = folder.inside(job.item.output).url
        if not step.decide(record, wanted, present, job.force, where):
            assert record is not None
            code = record.exit_code
            state: State = "skipped" if code == EXIT_DONE else _STATES.get(code, "failed")
            return step.Outcome(source.url, job.item.output, state, code, record.line, record.outputs)
        places.write_record(record_at, wanted.document())
        code, line, made = _call(job, local, work, source.url)
        outputs = {n: _digest(work / n) for n in made}
        for name in made:
            places.publish(work / name, folder.inside(name))
        if made:
            done = replace(wanted, state=step.DONE, exit_code=code, line=line, outputs=outputs)
            places.write_record(record_at, done.document())
    return step.Outcome(source.url, job.item.output, _STATES.get(code, "failed"), code, line, outputs)


def _call(job: Job, local: Path, work: Path, url: str) -> tuple[int, str, list[str]]:
    """Run the subcommand into ``work``; return its exit code, its line and the names it wrote."""
    form = step.form_of(job.command, job.item.options)
    words = [*([form.option] if form.option else []), str(local)]
    out = work / job.item.output
    if not form.printed:
        words += ["--out", str(out)]
    words += _words(job.item, work, job.root)
    code, printed, told = call_program([job.command, *words, "--json"], job.environment)
    # what the subcommand says must not show where this worker kept the file meanwhile
    printed, told = (t.replace(json.dumps(str(local))[1:-1], json.dumps(url)[1:-1]) for t in (printed, told))
    told = told.replace(str(work) + "/", "")
    if _is_error(printed):
        printed = ""
    if form.printed and printed.startswith("{"):
        out.write_text(printed, encoding="utf-8")
        with open(out, "rb") as file:
            os.fsync(file.fileno())
    lines = [line.removeprefix("sstl: ").strip() for line in told.splitlines() if line.strip()]
    if code in (EXIT_DONE, EXIT_SET_ASIDE):
        line = lines[0] if lines and code else ""
    else:
        line = lines[-1] if lines else f"exit code {code}"
    if form.printed and code == EXIT_FAILED and not lines:
        line = f"failures: {json.loads(printed).get('failures')}" if printed.startswith("{") else line
    return code, line, [n for n in (job.item.output, *job.item.side) if (work / n).is_file()]


def _is_error(printed: str) -> bool:
    """Whether a subcommand printed that it failed, instead of a document of its own."""
    return printed.startswith('{"schema": "sstl.error/1"')


def call_program(words: list[str], environment: dict[str, str]) -> tuple[int, str, str]:
    """Run ``sstl WORDS`` in this process; return exit code, standard output and standard error.

    Raises
    ------
    KeyboardInterrupt
        If Ctrl-C ended it: that is no failure of one file, and must not let the next one begin.
    """
    from sstl_cli.cli.app import main

    out, err = io.StringIO(), io.StringIO()
    with _ONE_AT_A_TIME:
        before_words, before = sys.argv, {k: v for k, v in os.environ.items() if k.startswith("SSTL_")}
        sys.argv = ["sstl", *words]
        _set_environment(before, environment)
        try:
            with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
                main()
            code = EXIT_DONE
        except SystemExit as end:
            if _interrupted(end):
                raise KeyboardInterrupt from None
            code = end.code if isinstance(end.code, int) else EXIT_DONE if end.code is None else EXIT_FAILED
        finally:
            sys.argv = before_words
            _set_environment(environment, before)
    return code, out.getvalue(), err.getvalue()


def _interrupted(end: SystemExit) -> bool:
    cause = end.__context__
    return isinstance(cause, KeyboardInterrupt) or (isinstance(cause, SstlError) and cause.code == INTERRUPTED)


def _set_environment(old: dict[str, str], new: dict[str, str]) -> None:
    for name in old:
        os.environ.pop(name, None)
    os.environ.update(new)


@contextlib.contextmanager
def _staging(folder: places.Place) -> Iterator[Path]:
    """Yield a folder on the disk of the outputs where these are local, so that a rename is enough."""
    beside = Path(folder.path, places.WORK) if folder.local else None
    if beside is not None and not beside.is_dir():
        raise SstlError("the output folder does not exist on this worker", where=folder.url, fix="use a shared folder", code="E033")
    # named before it is there: a program that is killed in between leaves nothing behind
    work = (beside or Path(tempfile.gettempdir())) / f"work-{uuid.uuid4().hex}"
    with at_work_in(work):
        try:
            with places.telling(folder.url):
                work.mkdir(mode=0o700)
            yield work
        finally:
            shutil.rmtree(work, ignore_errors=True)


def _staged(source: places.Place, work: Path) -> tuple[Path, str]:
    """Return a local name of an input, and its SHA-256 ("" for a folder or an input that is missing)."""
    if source.local:
        path = Path(source.path)
        return path, _digest(path) if path.is_file() else ""
    with places.telling(source.url):
        if not source.exists():
            raise SstlError("file not found", where=source.url, fix="correct the address", code="E034")
        inner = work / "input"
        inner.mkdir()
        path = inner / source.path.rpartition("/")[2]
        source.fs.get_file(source.path, str(path))
    return path, _digest(path)


def _option_files(job: Job) -> dict[str, str]:
    """Return the SHA-256 of every file that an option names, such as a mapping, also by a variable or a ``--config`` file."""
    found = {}
    words = [word.partition("=")[2] if word.startswith("--") else word for word in job.item.options if word not in job.item.side]
    for value in [*words, *job.named]:
        path = _file_of(value, job.root)
        if path:
            found[value] = _digest(Path(path))
    return found


def _words(item: step.Item, work: Path, root: str) -> list[str]:
    """Return the options with side outputs in ``work``, and files named from the folder the batch was started in."""
    words = []
    for word in item.options:
        head, equals, value = word.partition("=") if word.startswith("--") else ("", "", word)
        value = str(work / value) if value in item.side else _file_of(value, root) or value
        words.append(f"{head}{equals}{value}" if head else value)
    return words


def _file_of(value: str, root: str) -> str:
    path = os.path.join(root, value) if value and len(value) < 4096 and "\0" not in value else ""
    return path if path and os.path.isfile(path) else ""


def _digest(path: Path) -> str:
    digest = hashlib.sha256()
    with places.telling(str(path)), open(path, "rb") as file:
        while block := file.read(1 << 20):
            digest.update(block)
    return digest.hexdigest()
