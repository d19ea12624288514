"""What is written of a reproduction: files, and the document.

A command asks here first whether its folder can be written. What loads the simulators, scipy or the figures (up to 2.8 s) is therefore
imported by the functions that use it, after the work, when it is there anyway.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import pyarrow as pa

from sstl_cli.core.documents.outputs import BesidePart, ReproduceDocument
from sstl_cli.core.errors import SstlError, UsageError
from sstl_cli.core.files import atomic, require_followed, require_writable, write_text
from sstl_cli.core.kept import fonts_beside
from sstl_cli.core.parquet import write_table
from sstl_cli.core.provenance import Provenance
from sstl_cli.core.runs import Run, write_runs
from sstl_cli.core.tables import EVALUATION as EVALUATION_SCHEMA
from sstl_cli.core.tables import SCORE, Schema
from sstl_cli.core.tables import THETA as THETA_SCHEMA
from sstl_cli.paper.compare import COMPARISON, count, table_of
from sstl_cli.paper.spread import stored

if TYPE_CHECKING:
    from sstl_cli.paper.grid import Grid
    from sstl_cli.paper.reproduce import Options, Reproduction

FIXED = ("tables.parquet", "tables.tex", "reproduction.html")
GAP_LOGS = ("fitted.parquet", "stated.parquet")
THETA = {"cp40_theta.parquet": "slopes", "paper150_theta.parquet": "mapping"}
SCORES = "tracking_scores.parquet"
EVALUATION = "mapping_evaluation.parquet"
FIGURES = (
    "loop",
    "segmentation",
    "correlation",
    "product",
    "parameters",
    "tracking_sinusoid",
    "tracking_random",
    "ablation",
    "better",
    "probe",
)


def names() -> tuple[str, ...]:
    """Return every name that may be written."""
    return (*FIXED, *THETA, SCORES, EVALUATION, *(f"{n}.svg" for n in FIGURES))


def require(folder: Path, wanted: Sequence[str], force: bool) -> None:
    """Make the folder if it is missing, and refuse before the work begins what could not be written."""
    require_followed(folder)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise SstlError(f"cannot be made a folder: {error.strerror}", where=str(folder), fix="choose another --out", code="E806") from None
    for name in wanted:
        require_writable(folder / name, force)


@dataclass(frozen=True)
class Shown:
    """What is shown of a reproduction: tables, sentences, and how many entries have each verdict."""

    grids: Sequence[Grid]
    facts: Sequence[str]
    counts: dict[str, int]


def shown(found: Reproduction) -> Shown:
    """Return what is shown of a reproduction."""
    from sstl_cli.paper import show

    return Shown(show.grids(found), show.facts(found), count(found.compared))


def document(found: Reproduction, said: Shown, options: Options, written: Sequence[str] = ()) -> ReproduceDocument:
    """Return a reproduction as ``sstl.reproduce/1``."""
    return ReproduceDocument.joined(
        extras(found),
        schema="sstl.reproduce/1",
        tables=list(options.tables),
        seed=options.seed,
        seeds=options.seeds,
        verdicts=said.counts,
        facts=said.facts,
        entries=[c.record() for c in found.compared],
        written=list(written),
    )


def write(folder: Path, found: Reproduction, said: Shown, provenance: Provenance, force: bool) -> list[str]:
    """Write Parquet, LaTeX, HTML and SVG; return the names."""
    # before anything imports matplotlib
    fonts_beside(folder / FIXED[0])

    from sstl_cli.paper import drawings, page
    from sstl_cli.paper.latex import document as latex
    from sstl_cli.reporting.drawing import picture, save

    drawn = drawings.drawings(found) if found.figures or found.better or found.probes else []
    done = list(FIXED)
    write_table(folder / FIXED[0], table_of(found.compared), COMPARISON, provenance, force)
    write_text(folder / FIXED[1], latex(said.grids), force)
    pictures = [page.Shown(d.name, str(picture(d, None, d.name).svg), d.caption) for d in drawn]  # type: ignore[arg-type]
    write_text(folder / FIXED[2], page.page(said.grids, pictures, said.counts, said.facts, provenance.command), force)
    done += _write_tables(folder, found, provenance, force)
    for d in drawn:
        with atomic(folder / f"{d.name}.svg", force) as temporary:
            save(d, None, temporary, "svg")  # type: ignore[arg-type]
        done.append(f"{d.name}.svg")
    return done


def _write_tables(folder: Path, found: Reproduction, provenance: Provenance, force: bool) -> list[str]:
    """Write the tables beside the entries; return their names."""
    made = beside(found)
    for name, (table, schema) in made.items():
        write_table(folder / name, table, schema, provenance, force)
    return list(made)


def beside(found: Reproduction) -> dict[str, tuple[pa.Table, Schema]]:
    """Return the Theta tables, the errors of the mapping and the scores that were rebuilt, by the names of their files."""
    from sstl_cli.steps.compensate import score_rows, score_table

    parts = {name: getattr(found, part) for name, part in THETA.items()}
    done = {name: (made.theta, THETA_SCHEMA) for name, made in parts.items() if made is not None}
    if found.mapping is not None:
        rows = [
            {"variant": v, "seed": i, "rmse_gamma_p": p, "rmse_gamma_r": r, "rmse_total": t, "outside_range_pct": 0.0}
            for v, values in found.mapping.per_seed.items()
            for i, (p, r, t) in enumerate(values.tolist())
        ]
        done[EVALUATION] = (pa.Table.from_pylist(rows, schema=EVALUATION_SCHEMA.arrow()), EVALUATION_SCHEMA)
    if found.blocks:
        scores = [
            row.model_copy(update={"run_id": f"{b.settings.name}-{row.run_id}"})
            for b in found.blocks
            for r in b.results
            for row in score_rows(r)
        ]
        done[SCORES] = (score_table(scores), SCORE)
    return done


def write_gap_logs(folder: Path, found: Reproduction, seed: int, provenance: Provenance, force: bool) -> list[str]:
    """Write the explaining runs and what the stated settings predict for them, paired by run_id."""
    for name, runs in zip(GAP_LOGS, gap_runs(found, seed), strict=True):
        write_runs(folder / name, runs, provenance, force)
    return list(GAP_LOGS)


def gap_runs(found: Reproduction, seed: int) -> tuple[Iterator[Run], Iterator[Run]]:
    """Return the explaining runs, and what the stated settings predict for them.

    Raises
    ------
    UsageError
        E805 where Table IV was not rebuilt.
    """
    from sstl_cli.paper.table_iv_gap import logs

    if found.prepared is None:
        raise UsageError("needs Table IV", where="--gap-logs", fix="add --table IV", code="E805")
    return logs(found.prepared, found.blocks[-1], seed)


def extras(found: Reproduction) -> BesidePart:
    """Return what the JSON document holds beside the entries."""
    from sstl_cli.paper.contests import contests

    told: dict[str, object] = {}
    if found.mapping is not None:
        m = found.mapping
        told["mapping"] = {
            "best": m.best,
            "bayes_total": m.limit.total,
            "bayes_total_here": m.limit_here.total,
            "tests": [asdict(c) for c in contests(stored("III"))],
            "left_out": {p: {n: e.total for n, e in v.items()} for p, v in m.left_out.items()},
        }
    if found.rig:
        told["rig"] = {
            "seeds": [d.seed for d in found.rig],
            "committed_seeds": stored("R").seeds,
            "outside": [o.text() for o in found.outside],
        }
    if found.closed:
        told["closed"] = [{**asdict(c), "right": c.right} for c in found.closed]
    if found.gap is not None:
        told["gap"] = {**asdict(found.gap), "shrink_pct": found.gap.shrink_pct}
    if found.calibration is not None:
        c = found.calibration
        fitted = {f"{effect}.{p}": v for (effect, p), v in c.presliding.values.items()}
        told["identified"] = {"loop_lag": asdict(c.lag), "presliding": {**fitted, "rms_n": c.presliding.rms_n}}
    for name, rows in (("better", found.better), ("probe", found.probes), ("tendons", found.tendons), ("distal", found.distal)):
        if rows:
            told[name] = [asdict(row) for row in rows]
    return BesidePart.model_validate(told)
