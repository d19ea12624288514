"""``sstl compensate``: the feedforward controller, offline against a plant or on a stream of lines."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from sstl_cli.cli import _compensate_offline as offline
from sstl_cli.cli import _controller as shared
from sstl_cli.cli.options import Config, Force, Json, Seed
from sstl_cli.cli.render import Screen

if TYPE_CHECKING:
    from sstl_cli.control.controller import Options
    from sstl_cli.steps.compensate import Case

EPILOG = (
    "Example: sstl compensate --theta theta.parquet --model mapping.safetensors --reference sinusoid "
    "--out commands.parquet --scores scores.parquet. "
    "Stream: sstl compensate --stream --theta theta.parquet --config-id CP-040"
)


def register(app: typer.Typer) -> None:
    """Add the subcommand."""
    app.command("compensate", epilog=EPILOG)(compensate)


def compensate(
    theta: Annotated[
        Path | None, typer.Option(help="Theta table of sstl segment, or parameters of sstl export (JSON).")
    ] = None,
    sim: Annotated[
        Path | None,
        typer.Option(help="Instead of --theta: simulator (TOML, as diagnose --save-sim writes it) for lines and plant."),
    ] = None,
    model: shared.ModelFile = None,
    reference: Annotated[
        list[str] | None, typer.Option(help="sinusoid, random, trapezoid, or a Parquet or CSV file (repeatable).")
    ] = None,
    methods: Annotated[str | None, typer.Option(help="none,no-bias,proposed,DI or some of them.")] = None,
    out: Annotated[Path | None, typer.Option("--out", "-o", help="Command stream (Parquet).")] = None,
    scores: Annotated[Path | None, typer.Option(help="Scores (Parquet).")] = None,
    plant: Annotated[Path | None, typer.Option(help="Theta table of the plant (default: act rows of --theta).")] = None,
    plant_sim: Annotated[str | None, typer.Option(help="Scenario (TOML or built-in) simulated as the plant.")] = None,
    recorded: Annotated[Path | None, typer.Option(help="Log whose measured input drives the controller.")] = None,
    config_id: shared.ConfigId = None,
    beta_p: shared.BetaP = None,
    beta_r: shared.BetaR = None,
    bias_theta: shared.BiasTheta = None,
    cycles: Annotated[int, typer.Option(min=1, max=10_000, help="Cycles of the sinusoid and the trapezoid.")] = 2,
    loop_tau: Annotated[float | None, typer.Option(min=0, max=10, help="Lag of the plant's tension loop in s.")] = None,
    mape_floor: Annotated[float, typer.Option(min=1e-6, help="References below this (N) are left out of MAPE.")] = 0.5,
    t_max: shared.TMax = None,
    max_rate: shared.MaxRate = None,
    max_jump: shared.MaxJump = None,
    lead: shared.Lead = None,
    reversal: shared.Reversal = None,
    presliding: shared.Presliding = None,
    doubled: shared.Doubled = None,
    dt: shared.Period = None,
    max_rmse: Annotated[float | None, typer.Option(min=0, help="Exit 4 if proposed or DI is worse (N).")] = None,
    stream: Annotated[bool, typer.Option("--stream", help="Answer lines t_ref,t_in (CSV or JSON) on stdin.")] = False,
    timeout: Annotated[float, typer.Option(min=0, help="With --stream: silence (s) that is a loss; 0 is never.")] = 0.0,
    seed: Seed = 0,
    force: Force = False,
    as_json: Json = False,
    config: Config = None,
) -> None:
    """Compensate the hysteresis along a reference (Algorithm 1) and score it, or control a live stream."""
    from sstl_cli.control.controller import METHODS
    from sstl_cli.control.references import NAMES
    from sstl_cli.core.errors import UsageError, nearest

    asked = [m.strip() for m in methods.split(",") if m.strip()] if methods is not None else list(METHODS)
    for name in asked:
        if name not in METHODS:
            raise UsageError(f"no method '{name}' ({nearest(name, METHODS)})", where="--methods", code="E404")
    if not asked:
        raise UsageError("no method given", where="--methods", fix=f"use some of {','.join(METHODS)}", code="E404")
    for given in reference or []:
        if given not in NAMES and not Path(given).exists():
            hint = nearest(given, NAMES)
            raise UsageError(f"'{given}' is neither a reference ({hint}) nor a file", where="--reference", code="E407")
    source = _source(theta, sim)
    options = shared.controller_options(source, t_max, max_rate, max_jump, lead, reversal, presliding, doubled, dt)
    if stream:
        forbid_with_stream(
            out=out,
            scores=scores,
            recorded=recorded,
            plant=plant,
            plant_sim=plant_sim,
            reference=reference,
            max_rmse=max_rmse,
            json=as_json,
        )
        _stream(source, model, asked if methods else None, config_id, (beta_p, beta_r, bias_theta), options, timeout)
        return
    chosen = [x for x in (plant, plant_sim) if x is not None]
    if len(chosen) > 1 or (recorded is not None and reference):
        what = "--plant and --plant-sim" if len(chosen) > 1 else "--recorded and --reference"
        raise UsageError(f"{what} exclude one another", fix="give one", code="E413")
    if sim is not None and not chosen:
        plant_sim = str(sim)
    asked_for = offline.Asked(
        source, model, reference or ["sinusoid"], asked, methods is not None, out, scores, plant, plant_sim, recorded,
        config_id, (beta_p, beta_r, bias_theta), cycles, loop_tau, mape_floor, options, max_rmse, seed, force,
    )  # fmt: skip
    offline.run(Screen(as_json), asked_for)


def _source(theta: Path | None, sim: Path | None) -> Path:
    """Return where the lines come from."""
    from sstl_cli.core.errors import UsageError

    if theta is not None and sim is None:
        return theta
    if sim is None:
        raise UsageError("no lines to drive with", fix="give --theta, or --sim with a saved model", code="E413")
    if theta is not None:
        raise UsageError("--theta and --sim exclude one another", fix="give one", code="E413")
    if sim.suffix != ".toml":
        raise UsageError("is not a simulator", where=str(sim), fix="give a TOML file, as diagnose --save-sim writes it", code="E413")
    return sim


def forbid_with_stream(**given: object) -> None:
    """Raise UsageError for the options that mean nothing on a stream."""
    from sstl_cli.core.errors import UsageError

    for name, value in given.items():
        if value:
            option = f"--{name.replace('_', '-')}"
            raise UsageError(f"{option} has no meaning with --stream", fix="leave it out", code="E413")


def _stream(
    theta: Path,
    model: Path | None,
    methods: list[str] | None,
    config_id: str | None,
    biases: shared.Biases,
    options: Options,
    timeout_s: float,
) -> None:
    import sys

    from sstl_cli.control.controller import IDENTITY, Controller
    from sstl_cli.control.streaming import LineServer, read_lines
    from sstl_cli.core.errors import UsageError, printable

    cases, _ = shared.load_cases(theta, model, biases, config_id)
    case = cases[parameters_index(cases, config_id)]
    if methods is not None and len(methods) != 1:
        raise UsageError("a stream runs one method", where="--methods", fix="give one", code="E413")
    method = methods[0] if methods else case.usual_method()
    lines = case.lines(method)
    if lines is None and method != "none":
        raise UsageError(f"method '{method}' is not possible for {case.config_id}", where=str(theta), code="E405")
    controller = Controller(lines or IDENTITY, options, method != "none")
    # the first call loads compiled code: not while the rig waits for its answer
    controller.step(0.0, 0.0)
    controller.reset()

    def log(text: str) -> None:
        print(printable(text), file=sys.stderr, flush=True)

    log(f"{method} on {case.config_id}, {options.dt_s:g} s a line, command 0..{options.t_max_n:g} N")
    server = LineServer(controller, log)
    for line in read_lines(sys.stdin.fileno(), timeout_s or None):
        answer = server.silence(timeout_s) if line is None else server.answer(line)
        sys.stdout.write(answer + "\n")
        sys.stdout.flush()
    log(f"end of input: {server.lines} lines, {server.faulty_samples} without sound input")


def parameters_index(cases: list[Case], config_id: str | None) -> int:
    """Return the position of the configuration a stream drives."""
    from sstl_cli.control.parameters import index_of

    return index_of([c.config_id for c in cases], config_id)
