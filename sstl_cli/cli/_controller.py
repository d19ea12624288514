"""Options and inputs that ``compensate`` and ``export`` share: the controller's settings and the lines it drives."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

if TYPE_CHECKING:
    from sstl_cli.control.controller import Options
    from sstl_cli.steps.compensate import Case
    from sstl_cli.steps.compensate_source import Source

# None means "not given": then the value stored in a parameter file holds, or the default
TMax = Annotated[float | None, typer.Option(help="Largest command in N (default 80).")]
MaxRate = Annotated[float | None, typer.Option(help="Largest rate of the command in N/s (default none).")]
MaxJump = Annotated[float | None, typer.Option(help="Largest change of the command in one sample in N (default none).")]
Lead = Annotated[float | None, typer.Option(help="Lead for the lag of the tension loop in s, no more (default 0).")]
Reversal = Annotated[
    Literal["paper", "play"] | None, typer.Option(help="Reversals by Algorithm 1, or by the exact inverse of the play (default paper).")
]
Presliding = Annotated[float | None, typer.Option(help="With --reversal play: spread of presliding to follow, 0 to 1 (default 0).")]
Doubled = Annotated[bool | None, typer.Option("--doubled/--no-doubled", help="Doubled error term in backlash (default on).")]
Period = Annotated[float | None, typer.Option("--dt", help="Period of the controller in s (default 0.002).")]
ModelFile = Annotated[Path | None, typer.Option("--model", help="Mapping model (safetensors) for the method proposed.")]
BetaP = Annotated[float | None, typer.Option(help="Constant bias in pull in N (default: mean of what the mapping was trained on).")]
BetaR = Annotated[float | None, typer.Option(help="Constant bias in release in N (default: mean of what the mapping was trained on).")]
BiasTheta = Annotated[Path | None, typer.Option(help="Theta table whose mean biases are used instead.")]
ConfigId = Annotated[str | None, typer.Option(help="Only this configuration.")]

OF_BIASES = ("--beta-p", "--beta-r", "--bias-theta")
OF_SETTINGS = ("--t-max", "--max-rate", "--max-jump", "--lead", "--reversal", "--presliding", "--doubled", "--dt")


@dataclass(frozen=True, kw_only=True)
class Biases:
    """The biases that a mapping's slopes are driven with, where they are not those of its training data."""

    beta_p: BetaP = None
    beta_r: BetaR = None
    bias_theta: BiasTheta = None


@dataclass(frozen=True, kw_only=True)
class Settings:
    """How the controller acts, as far as a call says so."""

    t_max: TMax = None
    max_rate: MaxRate = None
    max_jump: MaxJump = None
    lead: Lead = None
    reversal: Reversal = None
    presliding: Presliding = None
    doubled: Doubled = None
    dt: Period = None


def stored_in(path: Path) -> Source | None:
    """Return what a parameter file holds; None of a table or a simulator, which has no options and is read when its lines are asked for."""
    from sstl_cli.steps.compensate_source import source_of

    return source_of(path) if path.suffix == ".json" else None


def controller_options(stored: Source | None, given: Settings) -> Options:
    """Return the options of the controller: as given, else as stored in a parameter file, else the defaults.

    Raises
    ------
    UsageError
        If a value does not fit.
    """
    from sstl_cli.cli.origin import refuse
    from sstl_cli.control.controller import Options
    from sstl_cli.core.config import parse
    from sstl_cli.core.errors import SstlError, UsageError

    named = {
        "t_max_n": given.t_max,
        "max_rate_n_s": given.max_rate,
        "max_jump_n": given.max_jump,
        "lead_s": given.lead,
        "reversal": given.reversal,
        "presliding": given.presliding,
        "doubled": given.doubled,
        "dt_s": given.dt,
    }
    values = {**(stored.options if stored is not None else Options()).model_dump(), **{k: v for k, v in named.items() if v is not None}}
    if values["reversal"] == "paper":
        refuse("--reversal paper", ("--presliding",), "add --reversal play, or leave it out")
    try:
        return parse(Options, values, "controller options")
    except SstlError as error:
        raise UsageError(error.what, where=error.where, code="E403") from None


def load_cases(
    path: Path, stored: Source | None, model: Path | None, biases: Biases, config_id: str | None
) -> tuple[list[Case], dict[str, str]]:
    """Return the configurations of a source (``stored``: as it was read already), mapped where a model is given, and what was set aside."""
    from sstl_cli.cli.origin import refuse
    from sstl_cli.core.parquet import open_table
    from sstl_cli.core.tables import THETA
    from sstl_cli.steps import compensate as step
    from sstl_cli.steps import compensate_setup as setup
    from sstl_cli.steps.compensate_source import source_of

    if model is None:
        refuse("a call without --model", OF_BIASES, "give the mapping, or leave it out: identified lines have biases of their own")
    source = source_of(path) if stored is None else stored
    mapping, known = None, None
    if model is not None and source.cases:
        from sstl_cli.mapping import load_model

        mapping = load_model(model)
        # biases are pre-calibrated: those of the training data, unless the user gives others
        known = step.mean_biases(step.cases_of(open_table(biases.bias_theta, THETA).table())[0]) if biases.bias_theta else None
    return setup.chosen(source.cases, source.aside, mapping, setup.Biases(biases.beta_p, biases.beta_r, known), config_id, str(path))
