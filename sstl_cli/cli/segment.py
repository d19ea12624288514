"""``sstl segment``: Theta of every run of a log."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from sstl_cli.cli.options import Config, Force, Json, NoPhysics, Out, Seed
from sstl_cli.cli.render import Screen

if TYPE_CHECKING:
    from sstl_cli.core.runs import Run

EPILOG = "Example: sstl segment log.parquet --out theta.parquet --phases phases.parquet"
# columns of a log that no line of Theta depends on
UNUSED = ("position_in_mm", "tension_ref_n", "trajectory")
SHOWN = 20


def register(app: typer.Typer) -> None:
    """Add the subcommand."""
    app.command("segment", epilog=EPILOG)(segment)


def segment(
    logs: Annotated[list[Path], typer.Argument(metavar="LOG", help="Logs (Parquet).")],
    out: Out,
    phases: Annotated[Path | None, typer.Option(help="Also write the phase PB, PP, RB or RP of every sample.")] = None,
    cutoff_hz: Annotated[
        float | None, typer.Option(help="Cut-off of the low-pass (default: from rate and motion).")
    ] = None,
    prominence_n: Annotated[
        float | None, typer.Option(help="Turn of the input that counts as a reversal (default: from noise and range).")
    ] = None,
    delta_bl_n: Annotated[
        float | None, typer.Option(help="Backlash threshold on the output (default: from noise and range).")
    ] = None,
    ransac_threshold_n: Annotated[
        float | None, typer.Option(help="Largest distance of an inlier (default: from the residuals).")
    ] = None,
    ransac_trials: Annotated[int, typer.Option(help="Pairs of points tried per direction.")] = 64,
    no_physics: NoPhysics = False,
    seed: Seed = 0,
    force: Force = False,
    as_json: Json = False,
    config: Config = None,
) -> None:
    """Segment hysteresis loops and identify the propagation lines of every run, with standard errors.

    What cannot be right is said first; runs that fail the physics gate are set aside (exit code 3; 1 if all do).
    """
    from sstl_cli.cli import _physics
    from sstl_cli.cli.origin import provenance
    from sstl_cli.core.errors import EXIT_SET_ASIDE, SstlError
    from sstl_cli.core.files import require_writable
    from sstl_cli.core.parquet import TableWriter, open_table, write_table
    from sstl_cli.core.tables import LOG, PHASES, THETA, theta_units
    from sstl_cli.identification import SegmentOptions, gate
    from sstl_cli.steps import segment as step

    screen = Screen(as_json)
    options = SegmentOptions(cutoff_hz, prominence_n, delta_bl_n, ransac_threshold_n, ransac_trials, seed)
    for path in [out] + ([phases] if phases else []):
        require_writable(path, force)
    total = sum(open_table(path, LOG).rows for path in logs)
    made = provenance(seed, logs)
    rows: list[dict[str, object]] = []
    evidence: list[gate.Evidence] = []
    unit_in = unit_out = "N"
    writer = TableWriter(phases, PHASES, made, force) if phases else nullcontext()
    with writer as file, screen.progress("segmenting", total) as advance:
        for found in step.run(_runs(logs), options):
            rows.append(found.row())
            unit_in, unit_out = found.run.unit_in, found.run.unit_out
            if not no_physics:
                evidence.append(gate.evidence_of(found.run))
            if file is not None:
                file.write(found.phase_table())
            advance(len(found.run))
        if not rows:
            raise SstlError(
                "holds no run", where=", ".join(map(str, logs)), fix="import a recording first", code="E221"
            )
        remarks = gate.judge(evidence)
        rows = step.set_aside(rows, remarks)
        # inside the block: should this fail, neither file appears
        units = theta_units(unit_in, unit_out)
        theta = THETA.in_units(units)
        write_table(out, step.theta_table(rows), theta, made, force, step.extra_columns(rows))
    aside = [{"run_id": r["run_id"], "status": r["status"]} for r in rows if r["status"] != "ok"]
    _physics.show(screen, remarks)
    screen.say(_sentence(rows, total, len(aside), out))
    _show(screen, rows, units.get("gamma_p", ""), unit_out)
    if aside:
        screen.note(f"{len(aside)} of {len(rows)} runs set aside in part or whole (null in the table, see status):")
        for entry in aside[:SHOWN]:
            screen.note(f"  {entry['run_id']}: {entry['status']}")
        if len(aside) > SHOWN:
            screen.note(f"  and {len(aside) - SHOWN} more")
    document = {
        "schema": "sstl.segment/1",
        "out": str(out),
        "phases": str(phases) if phases else None,
        "runs": len(rows),
        "samples": total,
        "set_aside": len(aside),
        "set_aside_runs": aside,
        "remarks": _physics.document(remarks),
        "theta": rows,
        "unit": unit_out,
        "unit_in": unit_in,
        "seed": seed,
    }
    screen.finish(document, EXIT_SET_ASIDE if aside else 0)


def _runs(logs: list[Path]) -> Iterator[Run]:
    from sstl_cli.core.runs import read_runs

    for path in logs:
        yield from read_runs(path, UNUSED)


def _sentence(rows: list[dict[str, Any]], samples: int, aside: int, out: Path) -> str:
    whole = "both propagation lines of"
    found = f"{whole} all {len(rows)} runs" if not aside else f"{whole} {len(rows) - aside} of {len(rows)} runs"
    return f"Found {found} ({samples} samples) -> {out}"


def _show(screen: Screen, rows: list[dict[str, Any]], slope: str, unit: str) -> None:
    names = ("gamma_p", "beta_p", "gamma_r", "beta_r")
    shown = [
        [r["run_id"], *_rounded(r, names), _percent(r, "gamma_p"), _percent(r, "gamma_r"), r["loops"]] for r in rows
    ]
    per = f" {slope}" if slope else ""
    heads = (f"Γ_p{per}", f"β_p {unit}", f"Γ_r{per}", f"β_r {unit}", "± p %", "± r %", "loops")
    screen.table("Theta: slope Γ and bias β of pull (p) and release (r), standard errors of Γ", ("run", *heads), shown, most=SHOWN)


def _rounded(row: dict[str, Any], names: tuple[str, ...]) -> list[float | None]:
    """Return slopes as they are, and biases to a thousandth of the larger slope: no tension of 1 shows more of them."""
    from math import floor, log10

    scale = max((abs(row[n]) for n in names if n.startswith("gamma") and row[n]), default=1.0)
    return [
        None if row[n] is None else row[n] if n.startswith("gamma") else round(row[n], 3 - floor(log10(scale))) + 0.0
        for n in names
    ]


def _percent(row: dict[str, Any], name: str) -> float | None:
    return None if row[name] is None else float(f"{100.0 * row[name + '_se'] / row[name]:.2g}")
