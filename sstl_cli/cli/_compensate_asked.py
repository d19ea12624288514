"""What a call of ``sstl compensate`` asks for, as it was given and as it is run."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from sstl_cli.cli import _controller as shared
from sstl_cli.cli.options import Config, Force, Json, Seed

if TYPE_CHECKING:
    from sstl_cli.control.controller import Options
    from sstl_cli.steps.compensate_source import Source


@dataclass(frozen=True, kw_only=True)
class Asked:
    """What a call asks for."""

    theta: Annotated[Path | None, typer.Option(help="Theta table of sstl segment, or parameters of sstl export (JSON).")] = None
    sim: Annotated[
        Path | None, typer.Option(help="Instead of --theta: simulator (TOML, as diagnose --save-sim writes it) for lines and plant.")
    ] = None
    model: shared.ModelFile = None
    reference: Annotated[list[str] | None, typer.Option(help="sinusoid, random, trapezoid, or a Parquet or CSV file (repeatable).")] = None
    methods: Annotated[str | None, typer.Option(help="none,no-bias,proposed,DI or some of them.")] = None
    out: Annotated[Path | None, typer.Option("--out", "-o", help="Command stream (Parquet).")] = None
    scores: Annotated[Path | None, typer.Option(help="Scores (Parquet).")] = None
    plant: Annotated[Path | None, typer.Option(help="Theta table of the plant (default: act rows of --theta).")] = None
    plant_sim: Annotated[str | None, typer.Option(help="Scenario (TOML or built-in) simulated as the plant.")] = None
    recorded: Annotated[Path | None, typer.Option(help="Log whose measured input drives the controller.")] = None
    config_id: shared.ConfigId = None
    biases: shared.Biases
    cycles: Annotated[int, typer.Option(min=1, max=10_000, help="Cycles of the sinusoid and the trapezoid.")] = 2
    loop_tau: Annotated[float | None, typer.Option(min=0, max=10, help="Lag of the plant's tension loop in s.")] = None
    mape_floor: Annotated[float, typer.Option(min=1e-6, help="References below this (N) are left out of MAPE.")] = 0.5
    settings: shared.Settings
    max_rmse: Annotated[float | None, typer.Option(min=0, help="Exit 4 if proposed or DI is worse (N).")] = None
    stream: Annotated[bool, typer.Option("--stream", help="Answer lines t_ref,t_in (CSV or JSON) on stdin.")] = False
    timeout: Annotated[float, typer.Option(min=0, help="With --stream: silence (s) that is a loss; 0 is never.")] = 0.0
    seed: Seed = 0
    force: Force = False
    as_json: Json = False
    config: Config = None


@dataclass(frozen=True)
class Job:
    """The same with what follows from it: where the lines come from, the methods, and how the controller acts."""

    asked: Asked
    source: Path
    methods: list[str]
    stored: Source | None
    options: Options

    @property
    def insist(self) -> bool:
        """Whether the methods were named, so that none may be left out."""
        return self.asked.methods is not None

    @property
    def references(self) -> list[str]:
        """The references to follow."""
        return self.asked.reference or ["sinusoid"]

    @property
    def plant_sim(self) -> str | None:
        """The simulated plant; a simulator that the lines come from is one too, where no plant was given."""
        own = str(self.asked.sim) if self.asked.sim is not None and self.asked.plant is None else None
        return self.asked.plant_sim if self.asked.plant_sim is not None else own
