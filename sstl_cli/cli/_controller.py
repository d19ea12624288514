"""Options and inputs that ``compensate`` and ``export`` share: the controller's settings and the lines it drives."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

if TYPE_CHECKING:
    from collections.abc import Callable

    from sstl_cli.control.controller import Options
    from sstl_cli.control.plant import Plant, TensionLoop
    from sstl_cli.steps.compensate import Case

# None means "not given": then the value stored in a parameter file holds, or the default
TMax = Annotated[float | None, typer.Option(help="Largest command in N (default 80).")]
MaxRate = Annotated[float | None, typer.Option(help="Largest rate of the command in N/s (default none).")]
MaxJump = Annotated[float | None, typer.Option(help="Largest change of the command in one sample in N (default none).")]
Lead = Annotated[float | None, typer.Option(help="Lead for the lag of the tension loop in s, no more (default 0).")]
Reversal = Annotated[
    Literal["paper", "play"] | None,
    typer.Option(help="Reversals by Algorithm 1, or by the exact inverse of the play (default paper)."),
]
Presliding = Annotated[
    float | None, typer.Option(help="With --reversal play: spread of presliding to follow, 0 to 1 (default 0).")
]
Doubled = Annotated[
    bool | None, typer.Option("--doubled/--no-doubled", help="Doubled error term in backlash (default on).")
]
Period = Annotated[float | None, typer.Option("--dt", help="Period of the controller in s (default 0.002).")]
ModelFile = Annotated[Path | None, typer.Option("--model", help="Mapping model (safetensors) for the method proposed.")]
BetaP = Annotated[float | None, typer.Option(help="Constant bias in pull in N (default: mean of the Theta table).")]
BetaR = Annotated[float | None, typer.Option(help="Constant bias in release in N (default: mean of the Theta table).")]
BiasTheta = Annotated[Path | None, typer.Option(help="Theta table whose mean biases are used instead.")]
ConfigId = Annotated[str | None, typer.Option(help="Only this configuration.")]

Biases = tuple[float | None, float | None, Path | None]


def controller_options(
    source: Path,
    t_max: float | None,
    max_rate: float | None,
    max_jump: float | None,
    lead: float | None,
    reversal: str | None,
    presliding: float | None,
    doubled: bool | None,
    dt: float | None,
) -> Options:
    """Return the options of the controller: as given, else as stored in a parameter file, else the defaults.

    Raises
    ------
    UsageError
        If a value does not fit.
    """
    from sstl_cli.control import parameters
    from sstl_cli.control.controller import Options
    from sstl_cli.core.config import parse
    from sstl_cli.core.errors import SstlError, UsageError
    from sstl_cli.core.files import read_json

    stored = Options()
    if source.suffix == ".json":
        stored = parameters.read(read_json(source, parameters.SCHEMA), str(source)).options
    given = {
        "t_max_n": t_max,
        "max_rate_n_s": max_rate,
        "max_jump_n": max_jump,
        "lead_s": lead,
        "reversal": reversal,
        "presliding": presliding,
        "doubled": doubled,
        "dt_s": dt,
    }
    values = {**stored.model_dump(), **{k: v for k, v in given.items() if v is not None}}
    try:
        return parse(Options, values, "controller options")
    except SstlError as error:
        raise UsageError(error.what, where=error.where, code="E403") from None


def load_cases(
    path: Path, model: Path | None, biases: Biases, config_id: str | None
) -> tuple[list[Case], dict[str, str]]:
    """Return the configurations of a Theta table, mapped where a model is given, and what was set aside."""
    from sstl_cli.control import parameters
    from sstl_cli.core.errors import SstlError, UsageError
    from sstl_cli.core.files import read_json
    from sstl_cli.core.parquet import open_table
    from sstl_cli.core.tables import THETA
    from sstl_cli.steps import compensate as step

    aside: dict[str, str] = {}
    if path.suffix == ".json":
        entries = parameters.read(read_json(path, parameters.SCHEMA), str(path)).configurations
        # lines that came from a mapping are still driven as such, not as identified ones
        cases = [
            step.Case(e.config_id, mapped=e.lines(), made_for=e.method)
            if e.method == "proposed"
            else step.Case(e.config_id, act=e.lines(), made_for=e.method)
            for e in entries
        ]
    else:
        cases, aside = step.cases_of(open_table(path, THETA).table())
    if not cases:
        reasons = "; ".join(sorted(set(aside.values()))[:3])
        raise SstlError("no usable configuration" + (f" ({reasons})" if reasons else ""), where=str(path), code="E405")
    beta_p, beta_r, bias_theta = biases
    if model is not None:
        from functools import partial

        from sstl_cli.mapping import load_model

        mapping = load_model(model)
        # biases are pre-calibrated: those of the training data, unless the user gives others
        known = step.mean_biases(step.cases_of(open_table(bias_theta, THETA).table())[0]) if bias_theta else None
        names: list[str | None] = [*mapping.header.tendons] or [None]
        done, unmapped = list(cases), {}
        for tendon in names:
            own = known or mapping.beta_act_of(tendon)
            if own is None and (beta_p is None or beta_r is None):
                raise UsageError(
                    "the biases of the actuation tendon are not known", where=str(path),
                    fix="give --beta-p and --beta-r, or --bias-theta", code="E405",
                )
            pair = (own[0] if beta_p is None else beta_p, own[1] if beta_r is None else beta_r)
            chosen = [i for i, c in enumerate(cases) if tendon is None or c.config_id.endswith(f"/{tendon}")]
            predict = partial(mapping.predict, tendon=tendon) if tendon is not None else mapping.predict
            mapped, missing = step.with_mapping([cases[i] for i in chosen], predict, pair, mapping.outside)
            for i, case in zip(chosen, mapped, strict=True):
                done[i] = case
            unmapped.update(missing)
        cases = done
        aside.update(unmapped)
    if config_id is not None:
        cases = [cases[parameters.index_of([c.config_id for c in cases], config_id)]]
        aside = {name: why for name, why in aside.items() if name == config_id}
    return cases, aside


def plants(
    cases: list[Case], plant: Path | None, plant_sim: str | None, loop: TensionLoop | None
) -> Callable[[Case], Plant | None]:
    """Return a function that gives the plant of a configuration, None where it has none."""
    from sstl_cli.control.plant import Plant, PlayTendon, TensionLoop
    from sstl_cli.core.parquet import open_table
    from sstl_cli.core.tables import THETA
    from sstl_cli.steps import compensate as step

    if plant_sim is not None:
        from sstl_cli.control.sim_plant import plant_of
        from sstl_cli.physics.scenario import load

        scenario = load(plant_sim)
        known = {c.id for c in scenario.configurations}
        return lambda case: plant_of(scenario, case.config_id, loop) if case.config_id in known else None
    truth = {c.config_id: c.act for c in cases}
    if plant is not None:
        truth = {c.config_id: c.act for c in step.cases_of(open_table(plant, THETA).table())[0]}

    def found(case: Case) -> Plant | None:
        lines = truth.get(case.config_id)
        return Plant(PlayTendon(lines), loop or TensionLoop()) if lines is not None else None

    return found
