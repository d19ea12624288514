"""``sstl diagnose``: where the sim-to-real gap lies, which effect causes it, how far it shrinks."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from sstl_cli.cli._progress import Pace
from sstl_cli.cli.options import Config, Force, Json, NoPhysics, effect_ids
from sstl_cli.cli.render import Screen

# shares of the time that were gone when the search had told these shares of its steps, on half a dozen logs
PACE = ((0.0, 0.09), (0.2, 0.14), (0.5, 0.2), (0.6, 0.63), (0.7, 0.76), (0.8, 0.9), (0.9, 0.94), (1.0, 0.97))
EPILOG = "Example: sstl diagnose log.parquet --sim rig.toml --out diagnosis.json"


def register(app: typer.Typer) -> None:
    """Add the subcommand."""
    app.command("diagnose", epilog=EPILOG)(diagnose)


def diagnose(
    logs: Annotated[list[Path] | None, typer.Argument(metavar="LOG", help="Logs (Parquet) with act and/or sstl runs.")] = None,
    plan: Annotated[
        str | None, typer.Option(help="Before recording: a scenario TOML or name; says which effects its movement could tell apart.")
    ] = None,
    sim: Annotated[
        str | None, typer.Option(help="The simulator: a scenario TOML (default: physical base model).")
    ] = None,
    against: Annotated[Path | None, typer.Option(help="Another simulator's log for the same input.")] = None,
    before: Annotated[
        Path | None, typer.Option(help="What has changed since this log? The model fitted to it is the simulator.")
    ] = None,
    prior: Annotated[
        Path | None, typer.Option(help="TOML: effect = odds over those of the library; no confidence is given then.")
    ] = None,
    effects: Annotated[
        str | None, typer.Option(help="Candidates, comma-separated (default: the whole catalogue).")
    ] = None,
    exclude: Annotated[str | None, typer.Option(help="Effects that are no candidates, comma-separated.")] = None,
    max_effects: Annotated[int, typer.Option(min=1, max=3, help="How many effects may be combined.")] = 3,
    out: Annotated[Path | None, typer.Option("--out", "-o", help="Write the diagnosis as JSON.")] = None,
    save_sim: Annotated[Path | None, typer.Option(help="Write the accepted simulator as a scenario TOML.")] = None,
    next_out: Annotated[
        Path | None, typer.Option(help="Write the proposed recording: a scenario (.toml) or the tensions to drive (.csv).")
    ] = None,
    max_tension: Annotated[float | None, typer.Option(min=0, help="What the proposed recording may ask of the input, N (default: as recorded).")] = None,
    max_rate: Annotated[float | None, typer.Option(min=0, help="How fast it may move the input, N/s (default: as recorded).")] = None,
    max_rmse: Annotated[float | None, typer.Option(help="Gate: re-tuned RMSE in N (exit 4 if missed).")] = None,
    max_gap_pct: Annotated[float | None, typer.Option(help="Gate: reducible part of the re-tuned RMSE in %.")] = None,
    expect: Annotated[str | None, typer.Option(help="Gate: the effect that must be named, or none.")] = None,
    junit: Annotated[Path | None, typer.Option(help="Write the gates as a JUnit file, for a build server.")] = None,
    summary: Annotated[Path | None, typer.Option(help="Write the diagnosis as a short Markdown text.")] = None,
    position: Annotated[
        bool, typer.Option("--position", help="Diagnose the recorded position too (the simulator claims a rigid tendon).")
    ] = False,
    max_seconds: Annotated[
        float | None, typer.Option(min=0, help="Begin nothing after this that can be left out (pairs, triples, odd runs, ...); notes say what was.")
    ] = None,
    workers: Annotated[int, typer.Option(min=1, max=64, help="Threads; the answer does not depend on it.")] = 2,
    no_physics: NoPhysics = False,
    force: Force = False,
    as_json: Json = False,
    config: Config = None,
) -> None:
    """Say where the gap between logs and simulator lies, which effect causes it, and how far it shrinks."""
    import time
    from dataclasses import replace

    from sstl_cli.cli import _diagnose_show as show
    from sstl_cli.cli import _gates
    from sstl_cli.cli.origin import environment, files_among, inputs
    from sstl_cli.core.config import read_toml
    from sstl_cli.core.errors import EXIT_DONE, EXIT_GATE, EXIT_SET_ASIDE, UsageError
    from sstl_cli.core.files import require_writable, write_json, write_text
    from sstl_cli.core.parquet import schema_id_of
    from sstl_cli.core.runs import read_runs
    from sstl_cli.physics.scenario import load
    from sstl_cli.physics.scenario_file import dump
    from sstl_cli.steps import diagnose as step
    from sstl_cli.steps import diagnose_tendons as tendons

    since, screen = time.monotonic(), Screen(as_json)
    if plan is not None:
        _plan(screen, plan, logs, effects, out, force)
    if not logs:
        raise UsageError("no log", where="LOGS", fix="give logs, or --plan SCENARIO before recording", code="E904")
    for path in (out, save_sim, next_out, junit, summary):
        if path is not None:
            require_writable(path, force)
    effect_ids(None if expect == "none" else expect, "--expect")
    options = step.DiagnoseOptions(
        sim=load(sim) if sim else None,
        effects=effect_ids(effects, "--effects") or None,
        exclude=effect_ids(exclude, "--exclude"),
        max_effects=max_effects,
        workers=workers, position=position, physics=not no_physics,
        max_tension_n=max_tension, max_rate_n_per_s=max_rate,
        prior=step.odds(read_toml(prior), str(prior)) if prior else {},
        odd_runs=True, max_seconds=max_seconds,
    )
    if any(schema_id_of(path) == "sstl.command" for path in logs):
        _stages(screen, logs, out, force)
    runs = [run for path in logs for run in read_runs(path)]
    if against is not None:
        from sstl_cli.steps.against import rebase

        runs = rebase(runs, list(read_runs(against)))
    earlier = None if before is None else list(read_runs(before))
    parts = [max(len(tendons.tendons_of(r)), 1) for r in (earlier, runs) if r is not None]
    with screen.progress("diagnosing", sum(parts), Pace(PACE, sum(parts))) as advance:
        if earlier is not None:
            was = tendons.run(earlier, replace(options, prior={}, odd_runs=False), lambda share: advance(parts[0] * share), since)
            options = replace(options, sim=was.model())
        result = tendons.run(runs, options, lambda share: advance(parts[-1] * share), since)
    document = result.document()
    document["inputs"] = inputs([*logs, *files_among(against, sim, before, prior)])
    if taken := environment():
        document["environment"] = taken
    if out is not None:
        write_json(out, document, force)
    if save_sim is not None:
        with screen.progress("saving the model"):
            accepted = result.model()
        write_text(save_sim, dump(accepted), force)
    if next_out is not None and document["next_experiment"]:
        from sstl_cli.diagnosis.following import table
        from sstl_cli.physics.scenario import Scenario

        proposed = document["next_experiment"]
        movement = Scenario.model_validate(proposed["scenario"])
        as_table = next_out.suffix.lower() == ".csv"
        write_text(next_out, table(movement, proposed["tension_factor"]) if as_table else dump(movement), force)
    show.answer(screen, document)
    show.tables(screen, document)
    missed = _missed(document, max_rmse, max_gap_pct, expect)
    if junit is not None:
        asked = {"--max-rmse": max_rmse, "--max-gap-pct": max_gap_pct, "--expect": expect}
        write_text(junit, _gates.junit(asked, missed, document["sentence"]), force)
    if summary is not None:
        write_text(summary, _gates.markdown(document, missed), force)
    for text in missed:
        screen.note(f"gate missed: {text}")
    code = EXIT_GATE if missed else (EXIT_SET_ASIDE if document["analysis"]["set_aside"] else EXIT_DONE)
    for run_id, reason in document["analysis"]["set_aside"].items():
        screen.note(f"set aside: run {run_id}: {reason}")
    screen.finish(document, code)


def _plan(screen: Screen, plan: str, logs: list[Path] | None, effects: str | None, out: Path | None, force: bool) -> None:
    """Say what a movement could tell before it is recorded, and end."""
    from sstl_cli.cli import _diagnose_show as show
    from sstl_cli.cli.origin import files_among, inputs
    from sstl_cli.core.errors import UsageError
    from sstl_cli.core.files import require_writable, write_json
    from sstl_cli.physics.scenario import load
    from sstl_cli.steps import diagnose_plan as step

    if logs:
        raise UsageError("a plan takes no log", where="--plan", fix="leave out the logs, or --plan", code="E904")
    if out is not None:
        require_writable(out, force)
    with screen.progress("planning", 1) as advance:
        document = step.run(load(plan), effect_ids(effects, "--effects") or None, advance)
    document["inputs"] = inputs(files_among(plan))
    if out is not None:
        write_json(out, document, force)
    show.plan(screen, document)
    screen.finish(document)


def _stages(screen: Screen, files: list[Path], out: Path | None, force: bool) -> None:
    """Share the tracking error of command streams out over the controller's stages, and end."""
    import pyarrow as pa

    from sstl_cli.cli import _diagnose_show as show
    from sstl_cli.core.errors import EXIT_DONE, EXIT_SET_ASIDE
    from sstl_cli.core.files import write_json
    from sstl_cli.core.parquet import open_table
    from sstl_cli.core.tables import COMMAND
    from sstl_cli.steps.diagnose_control import run

    document = run(pa.concat_tables([open_table(path, COMMAND).table() for path in files]))
    if out is not None:
        write_json(out, document, force)
    show.stages(screen, document)
    for run_id, reason in document["set_aside"].items():
        screen.note(f"set aside: {run_id}: {reason}")
    screen.finish(document, EXIT_SET_ASIDE if document["set_aside"] else EXIT_DONE)


def _missed(
    document: dict[str, Any], max_rmse: float | None, max_gap_pct: float | None, expect: str | None
) -> list[str]:
    gap, verdict = document["gap"], document["verdict"]
    missed = []
    if max_rmse is not None and gap["rmse_retuned_n"] > max_rmse:
        missed.append(f"--max-rmse: re-tuned RMSE {gap['rmse_retuned_n']:.3g} N > {max_rmse:g} N")
    reducible = 100.0 * (1.0 - gap["noise_floor_n"] / gap["rmse_retuned_n"]) if gap["rmse_retuned_n"] > 0 else 0.0
    if max_gap_pct is not None and reducible > max_gap_pct:
        missed.append(f"--max-gap-pct: reducible part {reducible:.1f} % > {max_gap_pct:g} %")
    if expect == "none" and verdict["status"] != "none":
        missed.append(f"--expect: expected none, verdict is {verdict['status']} {' + '.join(verdict['effects'])}")
    if expect not in (None, "none") and not (verdict["status"] == "identified" and expect in verdict["effects"]):
        missed.append(f"--expect: expected {expect}, verdict is {verdict['status']} {' + '.join(verdict['effects'])}")
    return missed
