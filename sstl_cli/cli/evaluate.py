"""``sstl evaluate``: Table III of a model, Tables I and II of a Theta table."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from sstl_cli.cli import _theta
from sstl_cli.cli._gathered import gathered
from sstl_cli.cli.options import Config, Force, Json
from sstl_cli.cli.render import Screen

if TYPE_CHECKING:
    import pyarrow as pa

    from sstl_cli.core.documents.base import Part
    from sstl_cli.mapping.evaluation import Evaluation
    from sstl_cli.mapping.header import Header
    from sstl_cli.steps.evaluate import Related

EPILOG = (
    "Examples: sstl evaluate mapping.safetensors --theta theta.parquet --out evaluation.parquet. "
    "Tables I and II, no model needed: sstl evaluate --theta theta.parquet --tables"
)


def register(app: typer.Typer) -> None:
    """Add the subcommand."""
    app.command("evaluate", epilog=EPILOG)(evaluate)


@dataclass(frozen=True, kw_only=True)
class Asked:
    """What a call asks for."""

    theta: Annotated[list[Path], typer.Option("--theta", help="Theta table of sstl segment (repeatable).")]
    model: Annotated[Path | None, typer.Argument(metavar="MODEL", help="Model of sstl train.")] = None
    tables: Annotated[bool, typer.Option("--tables", help="Tables I and II of the Theta table.")] = False
    everything: Annotated[bool, typer.Option("--all", help="Judge on trained configurations too.")] = False
    out: Annotated[Path | None, typer.Option("--out", "-o", help="RMSE of every variant and seed (Parquet).")] = None
    predictions: Annotated[Path | None, typer.Option(help="True and predicted slopes (Parquet).")] = None
    max_rmse: Annotated[float | None, typer.Option(min=0, help="Exit 4 if Total of the default variant is above this.")] = None
    force: Force = False
    as_json: Json = False
    config: Config = None

    @property
    def where(self) -> str:
        """The tables by name, for messages."""
        return ", ".join(map(str, self.theta))


@gathered
def evaluate(asked: Asked) -> None:
    """Judge a mapping on held-out configurations, variant by variant; or relate the slopes of both systems."""
    from sstl_cli.core.errors import GateError, UsageError
    from sstl_cli.core.files import require_outputs

    screen, model = Screen(asked.as_json), asked.model
    if model is None and not asked.tables:
        raise UsageError("needs a model, or --tables", fix="give MODEL, or --tables for Tables I and II", code="E514")
    if model is None and (asked.out or asked.predictions or asked.everything or asked.max_rmse is not None):
        raise UsageError("--out, --predictions, --all and --max-rmse need a model", fix="give MODEL", code="E514")
    require_outputs(asked.force, asked.out, asked.predictions)
    table = _theta.read(asked.theta)

    from sstl_cli.core.documents.mapping import EvaluateDocument, WrittenPart
    from sstl_cli.steps import evaluate as step

    parts: list[Part] = []
    pairs, total = None, None
    if asked.tables:
        related = step.run_tables(table, asked.where)
        parts.append(step.tables_document(related))
        _show_tables(screen, related)
        pairs = related.pairs
    if model is not None:
        header, found = _judged(screen, asked, model, table)
        out, predictions = (str(path) if path else None for path in (asked.out, asked.predictions))
        judged = step.document(found, header)
        parts += [WrittenPart(out=out, predictions=predictions), judged]
        pairs, total = found.pairs, judged.rmse_total
    # one of both was asked for
    assert pairs is not None
    _theta.note_aside(screen, pairs)
    aside = _theta.aside_rows(pairs)
    told, gate = {}, None
    if asked.max_rmse is not None and total is not None and total > asked.max_rmse:
        missed = f"Total RMSE {total:.4g} is above --max-rmse {asked.max_rmse:g}"
        told["gate"] = missed
        gate = GateError(missed, where=str(model), code="E513")
    document = EvaluateDocument.joined(
        *parts, schema="sstl.evaluate/1", rows=pairs.rows, set_aside=len(aside), set_aside_runs=aside, **told
    )
    screen.finish(document, aside=bool(aside), gate=gate)


def _judged(screen: Screen, asked: Asked, model: Path, table: pa.Table) -> tuple[Header, Evaluation]:
    """Judge a mapping, write what was asked for and show it; return what the model says of itself, and what was found."""
    from sstl_cli.cli.origin import provenance
    from sstl_cli.core.parquet import write_table
    from sstl_cli.core.tables import EVALUATION
    from sstl_cli.mapping import load_model
    from sstl_cli.mapping.tables import PREDICTIONS
    from sstl_cli.steps import evaluate as step

    mapping = load_model(model)
    found = step.run(mapping, table, asked.everything, asked.where)
    made = provenance(mapping.header.seed, [model, *asked.theta])
    if asked.out is not None:
        write_table(asked.out, step.evaluation_table(found, mapping.header.seeds), EVALUATION, made, asked.force)
    if asked.predictions is not None:
        write_table(asked.predictions, step.predictions_table(found), PREDICTIONS, made, asked.force)
    _show(screen, mapping.header, found, asked.everything)
    return mapping.header, found


def _show(screen: Screen, header: Header, found: Evaluation, everything: bool) -> None:
    from sstl_cli.cli.render import cell, many

    def plus(mean: float, sd: float) -> str:
        return f"{mean:.4f}±{sd:.4f}" if sd == sd else f"{mean:.4f}"

    rows = [
        (
            s.variant,
            *(plus(m, d) for m, d in zip(s.mean, s.spread, strict=True)),
            f"{s.scatter[0]:.3f}/{s.scatter[1]:.3f}",
            cell(float(s.ensemble[2])),
        )
        for s in found.scores
    ]
    default = found.score(header.default)
    screen.say(
        f"{header.default}, the default, errs by {default.told[2]:.3g} in the slopes (RMSE on {len(found.pairs)} pairs, "
        f"{'trained ones among them' if everything else 'all held out'})."
    )
    screen.table(
        f"Table III: RMSE on {len(found.pairs)} pairs, {many(len(header.seeds), 'seed')}",
        ("variant", "Γ_p", "Γ_r", "Total", "sd|e| p/r", "mean"),
        rows,
        ("± over seeds; " if len(header.seeds) > 1 else "") + "sd|e|: absolute errors over samples; mean: Total of the mean over seeds.",
    )
    tested = [c for c in found.comparisons if c.p_t == c.p_t]
    if tested:
        same = "one split: only the start and early stopping differ"
        split = "each with its own split" if header.per_seed_split else same
        screen.table(
            "Total, paired over seeds",
            ("difference", "Δ RMSE", "p (t)", "p (Wilcoxon)", "p (Holm)"),
            [(f"{c.a} - {c.b}", c.difference, c.p_t, c.p_wilcoxon, c.p_holm) for c in tested],
            f"Over seeds, {split}.",
        )
    share = found.outside_pct()
    if share > 0:
        screen.note(
            f"{int(found.outside.sum())} of {len(found.pairs)} inputs ({share:.3g} %) lie outside the trained range: "
            "predictions there are extrapolated"
        )


def _show_tables(screen: Screen, related: Related) -> None:
    r = related.relations
    screen.table(
        f"Table I: Γ_sstl against Γ_act², {len(related.pairs)} pairs",
        ("direction", "Pearson R", "identity RMSE", "slope a", "bias b", "fit RMSE"),
        [(d, c.pearson_r, c.identity_rmse, c.slope, c.bias, c.fit_rmse) for d, c in r.correlation.items()],
    )
    labels = {"gamma_p": "Γ_p", "gamma_r": "Γ_r", "product": "Γ_p Γ_r"}
    screen.table(
        "Table II: slopes and their product",
        ("system", "quantity", "mean", "sd", "min", "max"),
        [(s, labels[q], v.mean, v.std, v.min, v.max) for s, rows in r.slopes.items() for q, v in rows.items()],
    )
