"""``sstl train``: the mapping from the sensing loop's slopes to the actuation tendon's."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from sstl_cli.cli import _theta
from sstl_cli.cli._gathered import gathered
from sstl_cli.cli.options import Config, Force, Json, Out, Seed
from sstl_cli.cli.render import Screen, many

if TYPE_CHECKING:
    from sstl_cli.core.documents.mapping import TrainDocument
    from sstl_cli.steps.train import Result

EPILOG = "Example: sstl train theta.parquet --out mapping.safetensors --seeds 20 --history history.parquet"


def register(app: typer.Typer) -> None:
    """Add the subcommand."""
    app.command("train", epilog=EPILOG)(train)


@dataclass(frozen=True, kw_only=True)
class Asked:
    """What a call asks for."""

    theta: Annotated[list[Path], typer.Argument(metavar="THETA", help="Theta tables of sstl segment (Parquet).")]
    out: Out
    variants: Annotated[str, typer.Option(help="all, or some of linear,plain,plain-inv,skip,skip-inv (inv: inverse consistency).")] = "all"
    seeds: Annotated[int, typer.Option(min=1, max=1000, help="Number of training seeds, from --seed upwards.")] = 20
    seed: Seed = 0
    epochs: Annotated[int | None, typer.Option(min=1, max=1_000_000, help="Most epochs (default 600).")] = None
    weight_inv: Annotated[float, typer.Option("--lambda", min=0, max=1e3, help="Weight of the inverse-consistency term.")] = 2e-3
    test_share: Annotated[float, typer.Option(min=0.01, max=0.9, help="Share of configurations held out.")] = 0.25
    per_seed_split: Annotated[bool, typer.Option("--per-seed-split", help="Hold out other configurations for every seed.")] = False
    leave_out: Annotated[str | None, typer.Option(help="Hold out this location, for example ND, instead of a share.")] = None
    tendons: Annotated[
        Literal["auto", "one-hot", "separate"],
        typer.Option(help="Several tendons: one mapping with tendon inputs (one-hot), one each (separate), or the better of both (auto)."),
    ] = "auto"
    history: Annotated[Path | None, typer.Option(help="Also write the learning curves (Parquet).")] = None
    force: Force = False
    as_json: Json = False
    config: Config = None


@gathered
def train(asked: Asked) -> None:
    """Train the variants of Table III for several seeds at once and write one model file (safetensors)."""
    from sstl_cli.cli.origin import provenance, refuse
    from sstl_cli.core.files import require_outputs
    from sstl_cli.core.parquet import write_table
    from sstl_cli.mapping.variants import chosen

    screen = Screen(asked.as_json)
    names = chosen(asked.variants, asked.weight_inv)
    if asked.leave_out is not None:
        refuse("--leave-out", ("--test-share", "--per-seed-split"), "a location is left out, or a share; not both")
    require_outputs(asked.force, asked.out, asked.history)
    table = _theta.read(asked.theta)

    from sstl_cli.mapping import save_model
    from sstl_cli.mapping.tables import HISTORY
    from sstl_cli.steps import train as step

    settings = step.Config(
        names, asked.seeds, asked.seed, asked.epochs, asked.test_share, asked.per_seed_split, asked.leave_out, asked.tendons
    )
    with screen.progress("training", 1.0) as advance:
        result = step.run(table, settings, advance, ", ".join(map(str, asked.theta)))
    save_model(asked.out, result.model, asked.force)
    if asked.history is not None:
        write_table(asked.history, result.history, HISTORY, provenance(asked.seed, asked.theta), asked.force)
    _show(screen, result, asked.out)
    screen.finish(_document(result, asked.out, asked.history), aside=bool(result.pairs.aside))


def _show(screen: Screen, result: Result, out: Path) -> None:
    header = result.model.header
    best = next(v for v in header.variants if v.name == header.default)
    screen.say(
        f"{header.default} predicts best on the validation part (RMSE {best.rmse_validation:.3g} of the slopes); it is the default -> {out}"
    )
    screen.table(
        f"{len(result.pairs)} pairs, {many(len(header.seeds), 'seed')}",
        ("variant", "validation RMSE", "best epoch"),
        [(v.name, v.rmse_validation, result.epochs.get(v.name)) for v in header.variants],
        "Validation errors are means over seeds.",
    )
    screen.say("Configurations: " + ", ".join(f"{v} {k.replace('_', '-')}" for k, v in result.counts.items()))
    if header.tendons:
        tried = ", ".join(f"{k} {v:.4g}" for k, v in header.strategy_rmse.items())
        screen.say(f"{len(header.tendons)} tendons: {header.strategy} mapping (validation RMSE: {tried})")
    _theta.note_aside(screen, result.pairs)


def _document(result: Result, out: Path, history: Path | None) -> TrainDocument:
    from sstl_cli.core.documents.mapping import TrainDocument, TrainedVariant

    header, aside = result.model.header, _theta.aside_rows(result.pairs)
    return TrainDocument(
        schema="sstl.train/1",
        out=str(out),
        history=str(history) if history else None,
        pairs=len(result.pairs),
        configurations=result.counts,
        seed=header.seed,
        seeds=list(header.seeds),
        default=header.default,
        variants=[TrainedVariant(**v.model_dump(), best_epoch=result.epochs.get(v.name)) for v in header.variants],
        tendons=list(header.tendons),
        strategy=header.strategy,
        strategy_rmse=header.strategy_rmse,
        left_out=header.left_out or None,
        per_seed_split=header.per_seed_split,
        beta_act_n=header.beta_act,
        input_low=list(header.input_low),
        input_high=list(header.input_high),
        data_sha256=header.data_sha256,
        rows=result.pairs.rows,
        set_aside=len(aside),
        set_aside_runs=aside,
    )
