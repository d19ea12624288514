"""``sstl blind``: the withheld-effect check, from drawing cases to the score."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal, NoReturn

import typer

from sstl_cli.blind import FULL_CASES, QUICK_CASES
from sstl_cli.cli import _blind_show
from sstl_cli.cli._gathered import gathered
from sstl_cli.cli.options import Config, Force, Json, Out, Seed, effect_ids
from sstl_cli.cli.render import Screen

Set = Annotated[Path, typer.Argument(metavar="OUT", help="Folder of the set.")]
Workers = Annotated[int, typer.Option(min=1, max=64, help="Processes; the answer does not depend on it.")]
Simulator = Annotated[Literal["rig", "bristle", "variant", "mixed"], typer.Option(help="What stands in for hardware; mixed: all in turn.")]
Recordings = Annotated[
    Literal["plain", "lab", "mixed"],
    typer.Option(help="plain: complete, at a steady rate; lab: as labs make them (rates, gaps, held sensors); mixed: in turn."),
]

blind = typer.Typer(no_args_is_help=True, rich_markup_mode=None, help="Check the diagnosis on effects it cannot see.")


def register(app: typer.Typer) -> None:
    """Add the subcommand with its steps."""
    app.add_typer(blind, name="blind", epilog="Example: sstl blind make set --cases 60; sstl blind run set")


@dataclass(frozen=True, kw_only=True)
class Making:
    """What ``sstl blind make`` asks for."""

    out: Set
    cases: Annotated[int | None, typer.Option(min=1, max=100_000, help=f"Cases (default {FULL_CASES}, quick {QUICK_CASES}).")] = None
    nulls: Annotated[int, typer.Option(min=0, max=100_000, help="Further cases in which nothing is missing.")] = 0
    quick: Annotated[bool, typer.Option("--quick", help="Short recordings: a subset for CI.")] = False
    simulator: Simulator = "mixed"
    recordings: Recordings = "mixed"
    workers: Workers = 2
    seed: Annotated[int | None, typer.Option(min=0, max=2**63 - 1, help="Seed (default: one that nobody knows, kept under the seal).")] = (
        None
    )
    force: Force = False
    as_json: Json = False
    config: Config = None


@blind.command("make", epilog="Example: sstl blind make set --cases 60 --simulator mixed")
@gathered
def make(asked: Making) -> None:
    """Draw cases from simulators that stand in for hardware: recordings under neutral names, truth sealed apart."""
    from sstl_cli.blind.folder import Folder
    from sstl_cli.steps import blind_set as step

    screen, out = Screen(asked.as_json), asked.out
    wanted = step.Making(asked.cases, asked.nulls, asked.quick, asked.simulator, asked.recordings, asked.seed)
    with screen.progress("drawing cases", wanted.count) as advance:
        made = step.make(Folder(out), wanted, asked.workers, asked.force, advance)
    screen.say(f"{made.cases} cases, {made.samples} samples -> {out}; sealed as {made.seal[:16]}")
    screen.finish(made)


@blind.command("run", epilog="Example: sstl blind run set --workers 2")
def run(
    out: Set,
    workers: Workers = 2,
    force: Annotated[bool, typer.Option("--force", help="Diagnose cases again that have a result.")] = False,
    as_json: Json = False,
    config: Config = None,
) -> None:
    """Diagnose every case from its recordings alone; an interrupted run goes on where it stopped."""
    from sstl_cli.blind.folder import Folder, read_plan
    from sstl_cli.steps import blind_set as step

    screen = Screen(as_json)
    folder = Folder(out)
    plan = read_plan(folder)
    with screen.progress("diagnosing cases", len(plan)) as advance:
        done = step.diagnose(folder, plan, workers, force, advance)
    screen.say(f"{done.diagnosed} cases diagnosed, {done.kept} had a result -> {out / 'results'}")
    screen.finish(done)


@dataclass(frozen=True, kw_only=True)
class Scoring:
    """What ``sstl blind score`` asks for."""

    out: Set
    out_file: Annotated[Path | None, typer.Option("--out", "-o", help="Write the score as JSON.")] = None
    realised: Annotated[bool, typer.Option(help="Apply accepted models to recordings nobody diagnosed.")] = True
    gates: _blind_show.Gates
    force: Force = False
    as_json: Json = False
    config: Config = None


@blind.command("score", epilog="Example: sstl blind score set --max-false-alarm 0.05 --out score.json")
@gathered
def score(asked: Scoring) -> None:
    """Check the seals, open the truth, and say how well the diagnosis did, by strength."""
    from sstl_cli.blind.folder import Folder
    from sstl_cli.core.files import keep_safe, require_outputs, write_json
    from sstl_cli.steps import blind_set as step

    screen = Screen(asked.as_json)
    folder = Folder(asked.out)
    keep_safe(folder.files(), "a file of the set")
    require_outputs(asked.force, asked.out_file)
    found = step.opened(folder)
    with screen.progress("scoring", len(found.results)) as advance:
        document = step.score(folder, found, asked.realised, advance)
    missed = _blind_show.missed(document.scores, asked.gates)
    document = document.model_copy(update={"gates_missed": missed})
    if asked.out_file is not None:
        write_json(asked.out_file, document.plain(), asked.force)
    _blind_show.score(screen, document)
    lacking = document.missing_results
    screen.finish(document, missed=missed, aside=[f"{lacking} cases without a result"] if lacking else ())


@blind.command("limit", epilog="Example: sstl blind limit set --workers 2; sstl blind score set")
def limit(
    out: Set,
    workers: Workers = 2,
    force: Annotated[bool, typer.Option("--force", help="Compute distances again that are there.")] = False,
    as_json: Json = False,
    config: Config = None,
) -> None:
    """Say of each diagnosed case how far its truth is from the base and from its nearest rival; needs every result."""
    from sstl_cli.blind.folder import Folder, read_plan
    from sstl_cli.steps import blind_set as step

    screen = Screen(as_json)
    folder = Folder(out)
    plan = read_plan(folder)
    with screen.progress("computing distances", len(plan)) as advance:
        document = step.limit(folder, plan, workers, force, advance)
    screen.say(
        f"{document.decidable} of {document.judged} cases with something withheld can be told from base and rivals "
        f"(D^2 >= {document.decidable_d2:g}) -> {folder.limit}"
    )
    screen.finish(document)


@dataclass(frozen=True, kw_only=True)
class Library:
    """What ``sstl blind library`` asks for."""

    file: Annotated[Path, typer.Argument(help="Library to write (Parquet).")]
    cases: Annotated[int, typer.Option(min=1, max=100_000, help="Cases to draw and search.")]
    simulator: Simulator = "mixed"
    recordings: Recordings = "mixed"
    strength: Annotated[
        list[float] | None, typer.Option(min=0.05, max=100, help="Gap over the noise; again for more (default: 0.4, 1.2 and 4).")
    ] = None
    accepted: Annotated[bool, typer.Option("--accepted", help="Ask what has changed since a session whose model was accepted.")] = False
    habits: Annotated[
        bool, typer.Option("--habits", help="Of rigs that do what no law describes, too (with --accepted some do in any case).")
    ] = False
    quick: Annotated[bool, typer.Option("--quick", help="Short recordings.")] = False
    workers: Workers = 2
    seed: Seed = 0
    force: Force = False
    as_json: Json = False
    config: Config = None


@blind.command("library", epilog="Example: sstl blind library library.parquet --cases 600 --quick --workers 2")
@gathered
def library(asked: Library) -> None:
    """Draw cases and keep the evidence that a verdict is made from; an interrupted run goes on where it stopped."""
    from sstl_cli.blind.strength import STRENGTHS
    from sstl_cli.steps import blind_library as step

    screen, strengths = Screen(asked.as_json), tuple(asked.strength or STRENGTHS)
    options = step.Options(asked.cases, asked.seed, asked.simulator, asked.quick, asked.recordings, strengths, asked.accepted, asked.habits)
    with screen.progress("drawing and searching cases", asked.cases) as advance:
        made = step.run(asked.file, options, asked.workers, asked.force, advance)
    if made.failed:
        screen.note(f"set aside: {made.failed} cases that could not be drawn or searched")
    screen.say(f"{made.cases} cases of {', '.join(made.simulators)}, {made.rows} candidates -> {asked.file}")
    screen.finish(made)


@blind.command("learn", epilog="Example: sstl blind learn library.parquet --out weights.json")
def learn(
    libraries: Annotated[list[Path], typer.Argument(help="Libraries (sstl blind library).")],
    out: Out,
    force: Force = False,
    as_json: Json = False,
    config: Config = None,
) -> None:
    """Learn the verdict's weights, thresholds and confidence; says how they do on simulators left out."""
    from sstl_cli.core.files import require_writable, write_json
    from sstl_cli.steps import blind_learn as step

    screen = Screen(as_json)
    require_writable(out, force)
    with screen.progress("learning") as advance:
        weights, document = step.run(libraries, str(out), advance)
    write_json(out, weights, force)
    _blind_show.learned(screen, document)
    screen.finish(document)


@dataclass(frozen=True, kw_only=True)
class Real:
    """What ``sstl blind real`` asks for."""

    logs: Annotated[list[Path], typer.Argument(help="Logs (Parquet) of a real rig.")]
    model: Annotated[str | None, typer.Option(help="The accepted simulator (default: diagnose the logs).")] = None
    plant: Annotated[str | None, typer.Option(help="Effects to add and take out again, comma-separated (default: if none is there).")] = (
        None
    )
    strength: Annotated[float, typer.Option(min=0.05, max=100, help="Their gap over the residual RMS.")] = 2.0
    inject: Annotated[
        str | None,
        typer.Option(help="Put effects into the second half of each log: a TOML file (effect = size), or all at 7 % of the span."),
    ] = None
    out: Annotated[Path | None, typer.Option("--out", "-o", help="Write the result as JSON.")] = None
    seed: Seed = 0
    force: Force = False
    as_json: Json = False
    config: Config = None


@blind.command("real", epilog="Example: sstl blind real log.parquet --plant zero_offset,channel_delay")
@gathered
def real(asked: Real) -> None:
    """Fit the accepted model to recordings, take one term out of it, and diagnose it back."""
    from sstl_cli.cli.origin import files_among, inputs
    from sstl_cli.core.files import require_outputs, write_json
    from sstl_cli.core.runs import read_logs
    from sstl_cli.physics.scenario import load
    from sstl_cli.steps import blind_real as step

    screen = Screen(asked.as_json)
    require_outputs(asked.force, asked.out)
    if asked.inject is not None and (asked.model or asked.plant):
        from sstl_cli.core.errors import UsageError

        option = "--model" if asked.model else "--plant"
        raise UsageError(f"{option} has no meaning with --inject", fix="leave one out", code="E904")
    if asked.inject is not None:
        _inject(screen, asked, asked.inject)
    runs = read_logs(asked.logs)
    terms = None if asked.plant is None else list(effect_ids(asked.plant, "--plant"))
    with screen.progress("diagnosing back") as advance:
        found = step.run(runs, load(asked.model) if asked.model else None, terms, asked.strength, asked.seed, advance=advance)
    document = found.model_copy(update={"inputs": inputs([*asked.logs, *files_among(asked.model)])})
    if asked.out is not None:
        write_json(asked.out, document.plain(), asked.force)
    _blind_show.real(screen, document)
    screen.finish(document)


def _inject(screen: Screen, asked: Real, inject: str) -> NoReturn:
    """Put effects into the second half of each log, diagnose them, and end."""
    from sstl_cli.cli.origin import inputs
    from sstl_cli.core.config import read_toml
    from sstl_cli.core.files import write_json
    from sstl_cli.core.runs import read_logs
    from sstl_cli.steps import blind_inject
    from sstl_cli.steps.diagnose import odds

    each = {path.stem: read_logs([path]) for path in asked.logs}
    sizes = None if inject == "all" else odds(read_toml(Path(inject)), inject)
    with screen.progress("putting effects in") as advance:
        found = blind_inject.run(each, sizes, advance=advance)
    document = found.model_copy(update={"inputs": inputs([*asked.logs, *([] if sizes is None else [Path(inject)])])})
    if asked.out is not None:
        write_json(asked.out, document.plain(), asked.force)
    _blind_show.injected(screen, document)
    screen.finish(document)
