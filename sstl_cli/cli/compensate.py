"""``sstl compensate``: the feedforward controller, offline against a plant or on a stream of lines."""

from __future__ import annotations

from pathlib import Path

import typer

from sstl_cli.cli import _compensate_offline as offline
from sstl_cli.cli import _controller as shared
from sstl_cli.cli._compensate_asked import Asked, Job
from sstl_cli.cli._gathered import gathered
from sstl_cli.cli.render import Screen

EPILOG = (
    "Example: sstl compensate --theta theta.parquet --model mapping.safetensors --reference sinusoid "
    "--out commands.parquet --scores scores.parquet. "
    "Stream: sstl compensate --stream --theta theta.parquet --config-id CP-040"
)


def register(app: typer.Typer) -> None:
    """Add the subcommand."""
    app.command("compensate", epilog=EPILOG)(compensate)


@gathered
def compensate(asked: Asked) -> None:
    """Compensate the hysteresis along a reference (Algorithm 1) and score it, or control a live stream."""
    from sstl_cli.cli.origin import refuse
    from sstl_cli.core.errors import UsageError

    methods = _methods(asked.methods)
    _check_references(asked.reference or [])
    source = _source(asked.theta, asked.sim)
    stored = shared.stored_in(source)
    job = Job(asked, source, methods, stored, shared.controller_options(stored, asked.settings))
    if asked.stream:
        refuse("a stream", ("--cycles", "--loop-tau", "--mape-floor"))
        forbid_with_stream(
            out=asked.out,
            scores=asked.scores,
            recorded=asked.recorded,
            plant=asked.plant,
            plant_sim=asked.plant_sim,
            reference=asked.reference,
            max_rmse=asked.max_rmse,
            json=asked.as_json,
        )
        _stream(job)
        return
    both = asked.plant is not None and asked.plant_sim is not None
    if both or (asked.recorded is not None and asked.reference):
        what = "--plant and --plant-sim" if both else "--recorded and --reference"
        raise UsageError(f"{what} exclude one another", fix="give one", code="E413")
    refuse("a call without --stream", ("--timeout",), "add --stream, or leave it out")
    if asked.recorded is not None:
        refuse("a recorded input", ("--cycles",))
    offline.run(Screen(asked.as_json), job)


def _methods(text: str | None) -> list[str]:
    """Return the methods of a list with commas; all where none was given."""
    from sstl_cli.control.controller import METHODS
    from sstl_cli.core.errors import UsageError, nearest

    asked = [m.strip() for m in text.split(",") if m.strip()] if text is not None else list(METHODS)
    for name in asked:
        if name not in METHODS:
            raise UsageError(f"no method '{name}' ({nearest(name, METHODS)})", where="--methods", code="E404")
    if not asked:
        raise UsageError("no method given", where="--methods", fix=f"use some of {','.join(METHODS)}", code="E404")
    return asked


def _check_references(given: list[str]) -> None:
    """Raise UsageError for a reference that is neither a name nor a file."""
    from sstl_cli.control.references import NAMES
    from sstl_cli.core.errors import UsageError, nearest

    for name in given:
        if name not in NAMES and not Path(name).exists():
            hint = nearest(name, NAMES)
            raise UsageError(f"'{name}' is neither a reference ({hint}) nor a file", where="--reference", code="E407")


def _source(theta: Path | None, sim: Path | None) -> Path:
    """Return where the lines come from."""
    from sstl_cli.core.errors import UsageError

    if theta is not None and sim is None:
        return theta
    if sim is None:
        raise UsageError("no lines to drive with", fix="give --theta, or --sim with a saved model", code="E413")
    if theta is not None:
        raise UsageError("--theta and --sim exclude one another", fix="give one", code="E413")
    if sim.suffix != ".toml":
        raise UsageError("is not a simulator", where=str(sim), fix="give a TOML file, as diagnose --save-sim writes it", code="E413")
    return sim


def forbid_with_stream(**given: object) -> None:
    """Raise UsageError for the options that mean nothing on a stream."""
    from sstl_cli.core.errors import UsageError

    for name, value in given.items():
        if value:
            option = f"--{name.replace('_', '-')}"
            raise UsageError(f"{option} has no meaning with --stream", fix="leave it out", code="E413")


def _stream(job: Job) -> None:
    """Answer the lines of standard input."""
    import sys

    from sstl_cli.cli.streams import tell
    from sstl_cli.control.streaming import LineServer, read_lines
    from sstl_cli.core.errors import UsageError, printable
    from sstl_cli.steps import compensate_live

    asked, options = job.asked, job.options
    cases, _ = shared.load_cases(job.source, job.stored, asked.model, asked.biases, asked.config_id)
    if job.insist and len(job.methods) != 1:
        raise UsageError("a stream runs one method", where="--methods", fix="give one", code="E413")
    live = compensate_live.run(cases, asked.config_id, job.methods[0] if job.insist else None, options, str(job.source))

    def log(text: str) -> None:
        tell(printable(text))

    log(f"{live.method} on {live.config_id}, {options.dt_s:g} s a line, command 0..{options.t_max_n:g} N")
    server = LineServer(live.controller, log)
    for line in read_lines(sys.stdin.fileno(), asked.timeout or None):
        answer = server.silence(asked.timeout) if line is None else server.answer(line)
        sys.stdout.write(answer + "\n")
        sys.stdout.flush()
    log(f"end of input: {server.lines} lines, {server.faulty_samples} without sound input")
