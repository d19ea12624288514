"""``sstl compensate``: the feedforward controller, offline against a plant or on a stream of lines."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from sstl_cli.cli import _controller as shared
from sstl_cli.cli.options import Config, Force, Json, Seed
from sstl_cli.cli.render import Screen, cell

if TYPE_CHECKING:
    from sstl_cli.control.controller import Options
    from sstl_cli.control.references import Reference
    from sstl_cli.steps.compensate import Case, Result

EPILOG = (
    "Example: sstl compensate --theta theta.parquet --model mapping.safetensors --reference sinusoid "
    "--out commands.parquet --scores scores.parquet. "
    "Stream: sstl compensate --stream --theta theta.parquet --config-id CP-040"
)


def register(app: typer.Typer) -> None:
    """Add the subcommand."""
    app.command("compensate", epilog=EPILOG)(compensate)


def compensate(
    theta: Annotated[Path, typer.Option(help="Theta table of sstl segment, or parameters of sstl export (JSON).")],
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
    options = shared.controller_options(theta, t_max, max_rate, max_jump, lead, reversal, presliding, doubled, dt)
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
        _stream(theta, model, asked if methods else None, config_id, (beta_p, beta_r, bias_theta), options, timeout)
        return
    chosen = [x for x in (plant, plant_sim) if x is not None]
    if len(chosen) > 1 or (recorded is not None and reference):
        what = "--plant and --plant-sim" if len(chosen) > 1 else "--recorded and --reference"
        raise UsageError(f"{what} exclude one another", fix="give one", code="E413")
    _offline(
        Screen(as_json),
        theta,
        model,
        reference or ["sinusoid"],
        asked,
        methods is not None,
        out,
        scores,
        plant,
        plant_sim,
        recorded,
        config_id,
        (beta_p, beta_r, bias_theta),
        cycles,
        loop_tau,
        mape_floor,
        options,
        max_rmse,
        seed,
        force,
    )


def forbid_with_stream(**given: object) -> None:
    """Raise UsageError for the options that mean nothing on a stream."""
    from sstl_cli.core.errors import UsageError

    for name, value in given.items():
        if value:
            option = f"--{name.replace('_', '-')}"
            raise UsageError(f"{option} has no meaning with --stream", fix="leave it out", code="E413")


def _offline(
    screen: Screen,
    theta: Path,
    model: Path | None,
    names: list[str],
    methods: list[str],
    explicit: bool,
    out: Path | None,
    scores: Path | None,
    plant: Path | None,
    plant_sim: str | None,
    recorded: Path | None,
    config_id: str | None,
    biases: shared.Biases,
    cycles: int,
    loop_tau: float | None,
    floor: float,
    options: Options,
    max_rmse: float | None,
    seed: int,
    force: bool,
) -> None:
    from contextlib import ExitStack

    from sstl_cli.cli.origin import files_among, provenance
    from sstl_cli.control import reference_file, references
    from sstl_cli.control.plant import TensionLoop
    from sstl_cli.core.errors import EXIT_SET_ASIDE, GateError, SstlError, UsageError
    from sstl_cli.core.files import require_writable
    from sstl_cli.core.parquet import TableWriter, write_table
    from sstl_cli.core.rng import stream
    from sstl_cli.core.runs import read_runs
    from sstl_cli.core.tables import COMMAND, SCORE
    from sstl_cli.steps import compensate as step

    for path in (out, scores):
        if path is not None:
            require_writable(path, force)
    cases, aside = shared.load_cases(theta, model, biases, config_id)
    why = step.possible_methods(cases)
    impossible = {m: why[m] for m in methods if why[m]}
    if impossible and explicit:
        name, reason = next(iter(impossible.items()))
        raise UsageError(f"method '{name}' is not possible: {reason}", where=str(theta), code="E405")
    for name, reason in impossible.items():
        screen.note(f"left out method '{name}': {reason}")
    methods = [m for m in methods if m not in impossible]
    plant_of = shared.plants(cases, plant, plant_sim, TensionLoop(loop_tau or 0.0) if loop_tau is not None else None)
    plantless = [c.config_id for c in cases if plant_of(c) is None]
    aside.update({name: "no plant: no usable act row for this configuration" for name in plantless})
    for case in cases:
        for name in methods:
            if name != "none" and case.lines(name) is None:
                aside[f"{case.config_id} ({name})"] = "no usable row to drive this method"
    if len(plantless) == len(cases):
        raise SstlError(
            "no configuration has a plant to be scored on",
            where=str(theta),
            fix="give --plant or --plant-sim, or a Theta table with act rows",
            code="E405",
        )
    made = provenance(seed, files_among(theta, model, plant, recorded, biases[2], *names, plant_sim))
    loaded = {n: reference_file.read(Path(n), options.dt_s) for n in names if n not in references.NAMES}

    def references_of(case: Case) -> list[Reference]:
        # three distinct random references, one a location, as in Section V
        return [
            loaded.get(n) or references.make(n, stream(seed, "reference", n, case.location or ""), options.dt_s, cycles)
            for n in names
        ]

    if recorded is not None:
        results = step.run_recorded(cases, read_runs(recorded), methods, options, floor, plant_of)
        total = None
    else:
        results = step.run(cases, references_of, plant_of, methods, options, seed, floor)
        total = len(cases) * len(names) * len(methods)
    rows: list[dict[str, object]] = []
    extras: list[dict[str, object]] = []
    with ExitStack() as stack:
        advance = stack.enter_context(screen.progress("compensating", total))
        writer = stack.enter_context(TableWriter(out, COMMAND, made, force)) if out is not None else None
        for result in results:
            rows += step.score_rows(result)
            extras.append(_extra(result))
            if writer is not None:
                writer.write(step.command_table(result))
            advance(1)
    if scores is not None:
        write_table(scores, step.score_table(rows), SCORE, made, force)
    summary: list[dict[str, Any]] = _summary(rows)
    shown = ("trajectory", "location", "method", "n", "rmse_n", "std_n", "mape_pct", "reduction_pct")
    screen.say(_sentence(summary))
    screen.table(
        "Tension tracking",
        ["reference", "place", "method", "n", "RMSE N", "STD N", "MAPE %", "less %"],
        # an exact inverse leaves rounding errors: 1e-10 N is zero to a reader
        [[round(v, 5) if isinstance(v, float) else v for v in (s[k] for k in shown)] for s in summary],
        notes=f"Means over n configurations; window: {summary[0]['window']}; MAPE above a reference of {floor:g} N.",
    )
    costs = [e["bound_cost_n"] for e in extras if e["bound_cost_n"] is not None]
    if costs:
        screen.line(f"Bounds on rate and jump cost {max(costs):.3g} N of RMSE at most.")  # type: ignore[type-var]
    outside = sorted(c.config_id for c in cases if c.outside)
    if outside:
        screen.note(f"{len(outside)} configurations outside the trained range of the mapping: {', '.join(outside[:8])}")
    if aside:
        screen.note(f"set aside {len(aside)}: " + "; ".join(f"{k}: {v}" for k, v in list(aside.items())[:5]))
    worst = _gate_value(rows)
    document: dict[str, Any] = {
        "schema": "sstl.compensate/1",
        "seed": seed,
        "out": str(out) if out else None,
        "scores_file": str(scores) if scores else None,
        "options": options.model_dump(mode="json"),
        "methods": methods,
        "left_out_methods": impossible,
        "summary": summary,
        "scores": rows,
        "runs": extras,
        "set_aside": aside,
        "outside_trained_range": outside,
        "worst_rmse_n": worst,
        "max_rmse_n": max_rmse,
    }
    if max_rmse is not None and worst > max_rmse:
        screen.document(document)
        raise GateError(f"RMSE {worst:.4g} N is above --max-rmse {max_rmse:g} N", code="E411")
    screen.finish(document, EXIT_SET_ASIDE if aside else 0)


def _extra(result: Result) -> dict[str, object]:
    lines = result.case.lines(result.method) if result.method not in ("none", "recorded") else None
    return {
        "run_id": result.run_id,
        "config_id": result.case.config_id,
        "trajectory": result.trajectory,
        "method": result.method,
        "theta": None if lines is None else [lines.gamma_p, lines.beta_p, lines.gamma_r, lines.beta_r],
        "slopes_from": None if lines is None else "mapping" if lines.gamma_p == _mapped(result) else "identified",
        "outside_trained_range": result.case.outside,
        "bound_cost_n": result.bound_cost_n,
        "mape_bound_pct": {w: s.mape_bound_pct for w, s in result.scores.items()},
    }


def _mapped(result: Result) -> float | None:
    return None if result.case.mapped is None or result.method == "DI" else result.case.mapped.gamma_p


def _summary(rows: list[dict[str, object]]) -> list[dict[str, object]]:
    """Return means over configurations in the steadiest window, by trajectory, location and method."""
    steady = [r for r in rows if r["window"] != "all"] or rows
    groups: dict[tuple[object, ...], list[dict[str, object]]] = {}
    for row in steady:
        groups.setdefault((row["trajectory"], row["location"], row["method"]), []).append(row)
    found = []
    for (trajectory, location, method), members in groups.items():
        entry: dict[str, object] = {"trajectory": trajectory, "location": location, "method": method, "n": len(members)}
        for name in ("rmse_n", "std_n", "mape_pct", "reduction_pct"):
            values = [float(r[name]) for r in members if r[name] is not None]  # type: ignore[arg-type]
            entry[name] = sum(values) / len(values) if values else None
        entry["window"] = steady[0]["window"]
        found.append(entry)
    return found


def _sentence(summary: list[dict[str, Any]]) -> str:
    """Return what the compensation gained, over all references and places."""

    def mean(method: str) -> float | None:
        values = [s["rmse_n"] for s in summary if s["method"] == method and s["rmse_n"] is not None]
        return sum(values) / len(values) if values else None

    method = next((m for m in ("proposed", "DI", "no-bias") if mean(m) is not None), summary[0]["method"])
    before, after = mean("none"), mean(method)
    if before is None or after is None or method == "none" or before <= 0:
        return f"{method}: tracking error {cell(after)} N (RMSE)."
    change = 100 * (1 - after / before)
    word = "less" if change >= 0 else "MORE"
    share = f"{abs(change):.1f}" if abs(change) > 99 else f"{abs(change):.0f}"
    return f"{method} tracks with an error of {after:.2g} N instead of {before:.2g} N: {share} % {word} (RMSE)."


def _gate_value(rows: list[dict[str, object]]) -> float:
    """Return the largest RMSE of the complete methods (of all compensating ones where neither was run)."""
    steady = [r for r in rows if r["window"] != "all"] or rows
    for group in (("proposed", "DI"), ("no-bias",), ("none",)):
        values = [float(r["rmse_n"]) for r in steady if r["method"] in group]  # type: ignore[arg-type]
        if values:
            return max(values)
    return float("nan")


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
