"""``sstl diagnose``: where the sim-to-real gap lies, which effect causes it, how far it shrinks."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, NoReturn

import typer

from sstl_cli.cli._gathered import gathered
from sstl_cli.cli._progress import Pace
from sstl_cli.cli.options import Config, Force, Json, NoPhysics, effect_ids
from sstl_cli.cli.render import Screen

if TYPE_CHECKING:
    from collections.abc import Sequence

    from sstl_cli.core.runs import Run
    from sstl_cli.steps.diagnose import DiagnoseOptions
    from sstl_cli.steps.diagnose_tendons import Diagnosed

# shares of the time that were gone when the search had told these shares of its steps, on half a dozen logs
PACE = ((0.0, 0.09), (0.2, 0.14), (0.5, 0.2), (0.6, 0.63), (0.7, 0.76), (0.8, 0.9), (0.9, 0.94), (1.0, 0.97))
# what is asked of recorded logs alone
OF_A_LOG = (
    "sim", "against", "before", "prior", "exclude", "save_sim", "next_out", "max_tension", "max_rate", "max_rmse", "max_gap_pct", "expect",
    "junit", "summary", "position", "max_seconds",
)  # fmt: skip
EPILOG = "Example: sstl diagnose log.parquet --sim rig.toml --out diagnosis.json"


def register(app: typer.Typer) -> None:
    """Add the subcommand."""
    app.command("diagnose", epilog=EPILOG)(diagnose)


@dataclass(frozen=True, kw_only=True)
class Asked:
    """What a call asks for."""

    logs: Annotated[list[Path] | None, typer.Argument(metavar="LOG", help="Logs (Parquet) with act and/or sstl runs.")] = None
    plan: Annotated[
        str | None, typer.Option(help="Before recording: a scenario TOML or name; says which effects its movement could tell apart.")
    ] = None
    sim: Annotated[str | None, typer.Option(help="The simulator: a scenario TOML (default: physical base model).")] = None
    against: Annotated[Path | None, typer.Option(help="Another simulator's log for the same input.")] = None
    before: Annotated[Path | None, typer.Option(help="What has changed since this log? The model fitted to it is the simulator.")] = None
    prior: Annotated[Path | None, typer.Option(help="TOML: effect = odds over those of the library; no confidence is given then.")] = None
    effects: Annotated[str | None, typer.Option(help="Candidates, comma-separated (default: the whole catalogue).")] = None
    exclude: Annotated[str | None, typer.Option(help="Effects that are no candidates, comma-separated.")] = None
    max_effects: Annotated[int, typer.Option(min=1, max=3, help="How many effects may be combined.")] = 3
    out: Annotated[Path | None, typer.Option("--out", "-o", help="Write the diagnosis as JSON.")] = None
    save_sim: Annotated[Path | None, typer.Option(help="Write the accepted simulator as a scenario TOML.")] = None
    next_out: Annotated[
        Path | None, typer.Option(help="Write the proposed recording: a scenario (.toml) or the tensions to drive (.csv).")
    ] = None
    max_tension: Annotated[
        float | None, typer.Option(min=0, help="What the proposed recording may ask of the input, N (default: as recorded).")
    ] = None
    max_rate: Annotated[float | None, typer.Option(min=0, help="How fast it may move the input, N/s (default: as recorded).")] = None
    max_rmse: Annotated[float | None, typer.Option(min=0, help="Gate: re-tuned RMSE in N (exit 4 if missed).")] = None
    max_gap_pct: Annotated[float | None, typer.Option(min=0, help="Gate: reducible part of the re-tuned RMSE in %.")] = None
    expect: Annotated[str | None, typer.Option(help="Gate: the effect that must be named, or none.")] = None
    junit: Annotated[Path | None, typer.Option(help="Write the gates as a JUnit file, for a build server.")] = None
    summary: Annotated[Path | None, typer.Option(help="Write the diagnosis as a short Markdown text.")] = None
    position: Annotated[
        bool, typer.Option("--position", help="Diagnose the recorded position too (the simulator claims a rigid tendon).")
    ] = False
    max_seconds: Annotated[
        float | None,
        typer.Option(min=0, help="Begin nothing after this that can be left out (pairs, triples, odd runs, ...); notes say what was."),
    ] = None
    workers: Annotated[int, typer.Option(min=1, max=64, help="Threads; the answer does not depend on it.")] = 2
    no_physics: NoPhysics = False
    force: Force = False
    as_json: Json = False
    config: Config = None


@gathered
def diagnose(asked: Asked) -> None:
    """Say where the gap between logs and simulator lies, which effect causes it, and how far it shrinks."""
    import time

    from sstl_cli.core.errors import UsageError
    from sstl_cli.core.files import require_outputs
    from sstl_cli.core.parquet import schema_id_of

    since, screen = time.monotonic(), Screen(asked.as_json)
    if asked.plan is not None:
        _plan(screen, asked, asked.plan)
    if not asked.logs:
        raise UsageError("no log", where="LOGS", fix="give logs, or --plan SCENARIO before recording", code="E904")
    require_outputs(asked.force, asked.out, asked.save_sim, asked.next_out, asked.junit, asked.summary)
    effect_ids(None if asked.expect == "none" else asked.expect, "--expect")
    options = _options(asked)
    if any(schema_id_of(path) == "sstl.command" for path in asked.logs):
        _stages(screen, asked, asked.logs)
    runs = _runs(asked.logs)
    if asked.against is not None:
        from sstl_cli.physics.rebased import rebase

        runs = rebase(runs, _runs([asked.against]))
    _end(screen, asked, _diagnosed(screen, asked, runs, options, since))


def _options(asked: Asked) -> DiagnoseOptions:
    """Return what the step is asked for; whatever is wrong with a name or a file is said here, before the logs are read."""
    from sstl_cli.core.config import read_toml
    from sstl_cli.physics.scenario import load
    from sstl_cli.steps import diagnose as step

    return step.DiagnoseOptions(
        sim=load(asked.sim) if asked.sim else None,
        effects=effect_ids(asked.effects, "--effects") or None,
        exclude=effect_ids(asked.exclude, "--exclude"),
        max_effects=asked.max_effects,
        workers=asked.workers,
        position=asked.position,
        physics=not asked.no_physics,
        max_tension_n=asked.max_tension,
        max_rate_n_per_s=asked.max_rate,
        prior=step.odds(read_toml(asked.prior), str(asked.prior)) if asked.prior else {},
        odd_runs=True,
        max_seconds=asked.max_seconds,
    )


def _runs(paths: Sequence[Path]) -> list[Run]:
    """Return the runs of logs; of many that are too short to be diagnosed not all."""
    from sstl_cli.core.runs import few_short, read_runs

    return list(few_short(run for path in paths for run in read_runs(path)))


def _diagnosed(screen: Screen, asked: Asked, runs: Sequence[Run], options: DiagnoseOptions, since: float) -> Diagnosed:
    """Return the diagnosis; with an earlier log, against the model that is fitted to it."""
    from sstl_cli.steps import diagnose_tendons as tendons

    earlier = None if asked.before is None else _runs([asked.before])
    parts = tendons.parts(runs, earlier)
    with screen.progress("diagnosing", parts, Pace(PACE, parts)) as advance:
        return tendons.run(runs, options, advance, since, earlier)


def _end(screen: Screen, asked: Asked, result: Diagnosed) -> NoReturn:
    """Write what was asked for, show the diagnosis, judge the gates, and end."""
    from sstl_cli.cli import _diagnose_show as show
    from sstl_cli.cli import _gates
    from sstl_cli.cli.origin import environment, files_among, inputs
    from sstl_cli.core.files import write_json, write_text
    from sstl_cli.physics.scenario_file import dump
    from sstl_cli.steps import diagnose_movements as movements
    from sstl_cli.steps.diagnose_gates import Gates

    told: dict[str, object] = {"inputs": inputs([*(asked.logs or ()), *files_among(asked.against, asked.sim, asked.before, asked.prior)])}
    if taken := environment():
        told["environment"] = taken
    document = result.body.model_copy(update=told)
    if asked.out is not None:
        write_json(asked.out, document.plain(), asked.force)
    if asked.save_sim is not None:
        with screen.progress("saving the model"):
            accepted = result.model()
        write_text(asked.save_sim, dump(accepted, "" if result.given.trajectories else movements.SAID), asked.force)
    experiment = document.next_experiment
    proposed = movements.proposed(experiment)
    if asked.next_out is not None and experiment is not None and proposed is not None:
        text = movements.tensions(proposed, experiment) if asked.next_out.suffix.lower() == ".csv" else dump(proposed)
        write_text(asked.next_out, text, asked.force)
    show.diagnosis(screen, document)
    if asked.next_out is not None and proposed is None:
        screen.note(_not_proposed(asked.next_out, document.verdict.status))
    gates = Gates(asked.max_rmse, asked.max_gap_pct, asked.expect)
    missed = gates.missed(document)
    if asked.junit is not None:
        write_text(asked.junit, _gates.junit(gates.asked(), missed, document.sentence or ""), asked.force)
    if asked.summary is not None:
        write_text(asked.summary, _gates.markdown(document, missed), asked.force)
    screen.finish(document, missed=missed, aside=show.aside(document, bool(asked.prior)))


def _not_proposed(path: Path, status: str) -> str:
    """Return why there is no file of a proposed recording, and what one that is there already is."""
    settled = {"none": "nothing is left to explain", "identified": "the effect is named already"}
    why = settled.get(status, "no movement of the menu would tell the candidates apart better than this recording")
    kept = ", and the file there is from before" if path.exists() else ""
    return f"--next-out: no recording is proposed, {why}; {path} was not written{kept}"


def _plan(screen: Screen, asked: Asked, plan: str) -> NoReturn:
    """Say what a movement could tell before it is recorded, and end."""
    from sstl_cli.cli import _diagnose_show as show
    from sstl_cli.cli.origin import files_among, inputs
    from sstl_cli.core.errors import UsageError
    from sstl_cli.core.files import require_outputs, write_json
    from sstl_cli.physics.scenario import load
    from sstl_cli.steps import diagnose_plan as step

    if asked.logs:
        raise UsageError("a plan takes no log", where="--plan", fix="leave out the logs, or --plan", code="E904")
    _nothing_for(asked, OF_A_LOG, "a plan", "--plan")
    require_outputs(asked.force, asked.out)
    with screen.progress("planning", 1) as advance:
        found = step.run(load(plan), effect_ids(asked.effects, "--effects") or None, advance)
    document = found.model_copy(update={"inputs": inputs(files_among(plan))})
    if asked.out is not None:
        write_json(asked.out, document.plain(), asked.force)
    show.plan(screen, document)
    screen.finish(document)


def _nothing_for(asked: Asked, names: Sequence[str], what: str, where: str) -> None:
    """Refuse options that would be read and left without effect."""
    from sstl_cli.core.errors import UsageError

    others = [f"--{n.replace('_', '-')}" for n in names if getattr(asked, n)]
    if others:
        raise UsageError(f"{what} has nothing for {', '.join(others)}", where=where, fix="leave them out, or give logs", code="E904")


def _stages(screen: Screen, asked: Asked, files: list[Path]) -> NoReturn:
    """Share the tracking error of command streams out over the controller's stages, and end."""
    import pyarrow as pa

    from sstl_cli.cli import _diagnose_show as show
    from sstl_cli.core.files import write_json
    from sstl_cli.core.parquet import open_table
    from sstl_cli.core.tables import COMMAND
    from sstl_cli.steps.diagnose_control import run

    _nothing_for(asked, (*OF_A_LOG, "effects"), "a command stream", ", ".join(map(str, files)))
    document = run(pa.concat_tables([open_table(path, COMMAND).table() for path in files]))
    if asked.out is not None:
        write_json(asked.out, document.plain(), asked.force)
    show.stages(screen, document)
    screen.finish(document, aside=[f"{run_id}: {reason}" for run_id, reason in document.set_aside.items()])
