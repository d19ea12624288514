"""``sstl segment``: Theta of every run of a log."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from sstl_cli.cli._gathered import gathered
from sstl_cli.cli.options import Config, Force, Json, NoPhysics, Out, Seed
from sstl_cli.cli.render import Screen

if TYPE_CHECKING:
    from sstl_cli.core.documents.mapping import ThetaRow
    from sstl_cli.core.runs import Run
    from sstl_cli.steps.segment import Identified, Segmented

EPILOG = "Example: sstl segment log.parquet --out theta.parquet --phases phases.parquet"
# a column of a log that no line of Theta depends on, only the physics gate; the others are read for what no recorder can have given
UNUSED = ("trajectory",)
SHOWN = 20


def register(app: typer.Typer) -> None:
    """Add the subcommand."""
    app.command("segment", epilog=EPILOG)(segment)


@dataclass(frozen=True, kw_only=True)
class Asked:
    """What a call asks for."""

    logs: Annotated[list[Path], typer.Argument(metavar="LOG", help="Logs (Parquet).")]
    out: Out
    phases: Annotated[Path | None, typer.Option(help="Also write the phase PB, PP, RB or RP of every sample.")] = None
    cutoff_hz: Annotated[float | None, typer.Option(help="Cut-off of the low-pass (default: from rate and motion).")] = None
    prominence_n: Annotated[
        float | None, typer.Option(help="Turn of the input that counts as a reversal (default: from noise and range).")
    ] = None
    delta_bl_n: Annotated[float | None, typer.Option(help="Backlash threshold on the output (default: from noise and range).")] = None
    ransac_threshold_n: Annotated[float | None, typer.Option(help="Largest distance of an inlier (default: from the residuals).")] = None
    ransac_trials: Annotated[int, typer.Option(help="Pairs of points tried per direction.")] = 64
    no_physics: NoPhysics = False
    seed: Seed = 0
    force: Force = False
    as_json: Json = False
    config: Config = None


@gathered
def segment(asked: Asked) -> None:
    """Segment hysteresis loops and identify the propagation lines of every run, with standard errors.

    What cannot be right is said first; runs that fail the physics gate are set aside (exit code 3; 1 if all do).
    """
    from sstl_cli.cli import _physics
    from sstl_cli.core.aside import LISTED
    from sstl_cli.core.documents.mapping import Aside, SegmentDocument
    from sstl_cli.core.files import require_outputs
    from sstl_cli.core.parquet import open_table
    from sstl_cli.core.tables import LOG

    screen = Screen(asked.as_json)
    require_outputs(asked.force, asked.out, asked.phases)
    total = sum(open_table(path, LOG).rows for path in asked.logs)
    found = _identified(screen, asked, total)
    rows = found.rows
    aside = found.aside
    _physics.show(screen, found.remarks)
    screen.say(_sentence(len(rows), total, len(aside), asked.out))
    _show(screen, found)
    if aside:
        told = [f"{run_id}: {status}" for run_id, status in aside[:SHOWN]]
        title = f"{len(aside)} of {len(rows)} runs set aside in part or whole (null in the table, see status):"
        screen.note_some(title, told, SHOWN, len(aside) - len(told))
    # a document is made where it is shown; of many runs it takes gigabytes
    theta, left_out = rows.told(LISTED) if asked.as_json else ([], 0)
    document = SegmentDocument(
        schema="sstl.segment/1",
        out=str(asked.out),
        phases=str(asked.phases) if asked.phases else None,
        runs=len(rows),
        samples=total,
        set_aside=len(aside),
        set_aside_runs=[Aside(run_id=run_id, status=status) for run_id, status in aside[:LISTED]],
        remarks=_physics.document(found.remarks),
        theta=theta,
        **({"theta_left_out": left_out} if left_out else {}),
        unit=found.unit_out,
        unit_in=found.unit_in,
        seed=asked.seed,
    )
    screen.finish(document, aside=bool(aside))


def _identified(screen: Screen, asked: Asked, total: int) -> Identified:
    """Segment every run and write the tables, both or none."""
    from sstl_cli.cli.origin import provenance
    from sstl_cli.core.parquet import TableWriter, write_table
    from sstl_cli.core.tables import PHASES, THETA
    from sstl_cli.identification import SegmentOptions
    from sstl_cli.steps import segment as step

    options = SegmentOptions(
        asked.cutoff_hz, asked.prominence_n, asked.delta_bl_n, asked.ransac_threshold_n, asked.ransac_trials, asked.seed
    )
    made = provenance(asked.seed, asked.logs)
    writer = TableWriter(asked.phases, PHASES, made, asked.force) if asked.phases else nullcontext()
    with writer as file, screen.progress("segmenting", total) as advance:

        def write(one: Segmented) -> None:
            if file is not None:
                file.write(one.phase_table())
            advance(len(one.run))

        found = step.identify(_runs(asked), options, not asked.no_physics, write, ", ".join(map(str, asked.logs)))
        # inside the block: should this fail, neither file appears
        extra = step.extra_columns(found.rows)
        write_table(asked.out, step.theta_table(found.rows), THETA.in_units(found.units), made, asked.force, extra)
    return found


def _runs(asked: Asked) -> Iterator[Run]:
    from sstl_cli.core.runs import read_runs

    for path in asked.logs:
        yield from read_runs(path, UNUSED if asked.no_physics else ())


def _sentence(runs: int, samples: int, aside: int, out: Path) -> str:
    whole = "both propagation lines of"
    found = f"{whole} all {runs} runs" if not aside else f"{whole} {runs - aside} of {runs} runs"
    return f"Found {found} ({samples} samples) -> {out}"


def _show(screen: Screen, found: Identified) -> None:
    from sstl_cli.core.aside import LISTED

    rows, slope, unit = found.rows[:SHOWN], found.units.get("gamma_p", ""), found.unit_out
    names = ("gamma_p", "beta_p", "gamma_r", "beta_r")
    shown = [[r.run_id, *_rounded(r, names), _percent(r.gamma_p, r.gamma_p_se), _percent(r.gamma_r, r.gamma_r_se), r.loops] for r in rows]
    # beyond that many a document leaves out runs without a line
    whole = "--json" if len(found.aside) <= LISTED else "the table"
    per = f" {slope}" if slope else ""
    heads = (f"Γ_p{per}", f"β_p {unit}", f"Γ_r{per}", f"β_r {unit}", "± p %", "± r %", "loops")
    screen.table(
        "Theta: slope Γ and bias β of pull (p) and release (r), standard errors of Γ",
        ("run", *heads),
        shown,
        more=len(found.rows) - len(rows),
        whole=whole,
    )


def _rounded(row: ThetaRow, names: tuple[str, ...]) -> list[float | None]:
    """Return slopes as they are, and biases to a thousandth of the larger slope: no tension of 1 shows more of them."""
    from math import floor, log10

    values: dict[str, float | None] = {n: getattr(row, n) for n in names}
    scale = max((abs(v) for n, v in values.items() if n.startswith("gamma") and v), default=1.0)
    return [v if v is None or n.startswith("gamma") else round(v, 3 - floor(log10(scale))) + 0.0 for n, v in values.items()]


def _percent(slope: float | None, error: float | None) -> float | None:
    return None if slope is None or error is None else float(f"{100.0 * error / slope:.2g}")
