"""``sstl compensate`` without ``--stream``: read, run, write, show."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from sstl_cli.cli import _controller as shared
from sstl_cli.cli._compensate_asked import Job
from sstl_cli.cli.render import Screen, cell

if TYPE_CHECKING:
    from sstl_cli.core.documents.control import CompensatedRun, MeanScore, ScoreRow
    from sstl_cli.core.provenance import Provenance
    from sstl_cli.steps.compensate import Result
    from sstl_cli.steps.compensate_setup import Plan
    from sstl_cli.steps.compensate_summary import Gain


@dataclass(frozen=True)
class Done:
    """Scores (a row a run and window) and what else is told of each run."""

    rows: list[ScoreRow]
    runs: list[CompensatedRun]


def run(screen: Screen, job: Job) -> None:
    """Compensate, write what was asked for, show it, and end."""
    from sstl_cli.cli.origin import files_among, provenance
    from sstl_cli.core.documents.control import CompensateDocument, ControllerSettings
    from sstl_cli.core.errors import GateError
    from sstl_cli.core.files import require_outputs
    from sstl_cli.steps import compensate_summary as summing

    asked = job.asked
    require_outputs(asked.force, asked.out, asked.scores)
    plan = _plan(screen, job)
    for name, reason in plan.impossible.items():
        screen.note(f"left out method '{name}': {reason}")
    read = (job.source, asked.model, asked.plant, asked.recorded, asked.biases.bias_theta, *job.references, job.plant_sim)
    done = _run(screen, job, plan, provenance(asked.seed, files_among(*read)))
    summary, worst = summing.means(done.rows), summing.worst_rmse_n(done.rows)
    outside = sorted(c.config_id for c in plan.cases if c.outside)
    _show(screen, asked.mape_floor, plan, done, summary, outside)
    document = CompensateDocument(
        schema="sstl.compensate/1",
        seed=asked.seed,
        out=str(asked.out) if asked.out else None,
        scores_file=str(asked.scores) if asked.scores else None,
        options=ControllerSettings.model_validate(job.options.model_dump(mode="json")),
        methods=plan.methods,
        left_out_methods=plan.impossible,
        summary=summary,
        scores=done.rows,
        runs=done.runs,
        set_aside=plan.aside,
        outside_trained_range=outside,
        worst_rmse_n=worst,
        max_rmse_n=asked.max_rmse,
    )
    gate = None
    if asked.max_rmse is not None and worst > asked.max_rmse:
        gate = GateError(f"RMSE {worst:.4g} N is above --max-rmse {asked.max_rmse:g} N", code="E411")
    screen.finish(document, aside=bool(plan.aside), gate=gate)


def _plan(screen: Screen, job: Job) -> Plan:
    """Read the configurations and their plants, and say what of it is possible."""
    from sstl_cli.control.plant import TensionLoop
    from sstl_cli.core.parquet import open_table
    from sstl_cli.core.tables import THETA
    from sstl_cli.physics.scenario import load
    from sstl_cli.steps import compensate as step
    from sstl_cli.steps import compensate_setup as setup

    asked = job.asked
    cases, aside = shared.load_cases(job.source, job.stored, asked.model, asked.biases, asked.config_id)
    truth = cases if asked.plant is None else step.cases_of(open_table(asked.plant, THETA).table())[0]
    scenario = load(job.plant_sim) if job.plant_sim is not None else None
    screen.note_versions(scenario and scenario.package_version, "the plant")
    loop = TensionLoop(asked.loop_tau) if asked.loop_tau is not None else None
    plant_of = setup.plants(truth, scenario, loop)
    return setup.plan(cases, aside, job.methods, job.insist, plant_of, str(job.source))


def _results(job: Job, plan: Plan) -> tuple[Iterator[Result], int | None]:
    """Return the runs to come, and how many they are (None where only the recording knows)."""
    from sstl_cli.control import reference_file, references
    from sstl_cli.core.runs import read_runs
    from sstl_cli.steps import compensate as step
    from sstl_cli.steps import compensate_setup as setup

    asked, options, names = job.asked, job.options, job.references
    if asked.recorded is not None:
        runs = read_runs(asked.recorded)
        return step.run_recorded(plan.cases, runs, plan.methods, options, asked.mape_floor, plan.plant_of), None
    loaded = {n: reference_file.read(Path(n), options.dt_s) for n in names if n not in references.NAMES}
    wanted = setup.references_of(names, loaded, options.dt_s, asked.cycles, asked.seed)
    results = step.run(plan.cases, wanted, plan.plant_of, plan.methods, options, asked.seed, asked.mape_floor)
    return results, len(plan.cases) * len(names) * len(plan.methods)


def _run(screen: Screen, job: Job, plan: Plan, made: Provenance) -> Done:
    """Run everything, and write commands and scores as they come."""
    from contextlib import ExitStack

    from sstl_cli.core.parquet import TableWriter, write_table
    from sstl_cli.core.tables import COMMAND, SCORE
    from sstl_cli.steps import compensate as step
    from sstl_cli.steps.compensate_summary import run_entry

    asked = job.asked
    results, total = _results(job, plan)
    done = Done([], [])
    with ExitStack() as stack:
        advance = stack.enter_context(screen.progress("compensating", total))
        writer = None
        if asked.out is not None:
            writer = stack.enter_context(TableWriter(asked.out, COMMAND, made, asked.force))
        for result in results:
            done.rows.extend(step.score_rows(result))
            done.runs.append(run_entry(result))
            if writer is not None:
                writer.write(step.command_table(result))
            advance(1)
    if asked.scores is not None:
        write_table(asked.scores, step.score_table(done.rows), SCORE, made, asked.force)
    return done


def _show(screen: Screen, floor_n: float, plan: Plan, done: Done, summary: list[MeanScore], outside: list[str]) -> None:
    from sstl_cli.steps.compensate_summary import gain

    screen.say(_sentence(gain(summary)))
    shown = ("trajectory", "location", "method", "n", "rmse_n", "std_n", "mape_pct", "reduction_pct")
    screen.table(
        "Tension tracking",
        ["reference", "place", "method", "n", "RMSE N", "STD N", "MAPE %", "less %"],
        # an exact inverse leaves rounding errors: 1e-10 N is zero to a reader
        [[round(v, 5) if isinstance(v, float) else v for v in (getattr(s, k) for k in shown)] for s in summary],
        notes=f"Means over n configurations; window: {summary[0].window}; MAPE above a reference of {floor_n:g} N.",
    )
    costs = [e.bound_cost_n for e in done.runs if e.bound_cost_n is not None]
    if costs:
        screen.say(f"Bounds on rate and jump cost {max(costs):.3g} N of RMSE at most.")
    if outside:
        screen.note(f"{len(outside)} configurations outside the trained range of the mapping: {', '.join(outside[:8])}")
    if plan.aside:
        told = "; ".join(f"{k}: {v}" for k, v in list(plan.aside.items())[:5])
        screen.note(f"set aside {len(plan.aside)}: {told}")


def _sentence(found: Gain) -> str:
    """Return what the compensation gained, in words."""
    less = found.less_pct
    if less is None or found.after_n is None or found.before_n is None:
        return f"{found.method}: tracking error {cell(found.after_n)} N (RMSE)."
    share = f"{abs(less):.1f}" if abs(less) > 99 else f"{abs(less):.0f}"
    word = "less" if less >= 0 else "MORE"
    return f"{found.method} tracks with an error of {found.after_n:.2g} N instead of {found.before_n:.2g} N: {share} % {word} (RMSE)."
