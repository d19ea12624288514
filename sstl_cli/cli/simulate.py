"""``sstl simulate``: recordings of a scenario."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Annotated, Literal

import typer

from sstl_cli.cli._gathered import gathered
from sstl_cli.cli.options import Config, Force, Json, Out, Seed, usage
from sstl_cli.cli.render import Screen, many

EPILOG = "Example: sstl simulate --scenario default --effect pulley_friction:m_p=0.1,m_r=0.1 --seed 1 --out log.parquet"


def register(app: typer.Typer) -> None:
    """Add the subcommand."""
    app.command("simulate", epilog=EPILOG)(simulate)


@dataclass(frozen=True, kw_only=True)
class Asked:
    """What a call asks for."""

    out: Out
    scenario: Annotated[str, typer.Option(help="TOML file, or a built-in name such as default or paper-cp40.")] = "default"
    simulator: Annotated[
        Literal["transmission", "rig", "bristle", "variant"] | None,
        typer.Option(help="Fast model, elastic rig, bristle friction, or rig of law variants (default: as in the scenario)."),
    ] = None
    effect: Annotated[list[str] | None, typer.Option(metavar="ID[:param=value,...]", help="Effect to add (repeatable).")] = None
    noise_n: Annotated[float | None, typer.Option(min=0, max=5, help="White noise of each tension sensor in N.")] = None
    seed: Seed = 0
    force: Force = False
    as_json: Json = False
    config: Config = None


@gathered
def simulate(asked: Asked) -> None:
    """Simulate the recordings that a scenario describes and write them as a log."""
    from sstl_cli.cli.origin import files_among, provenance
    from sstl_cli.core.documents.logs import SimulateDocument
    from sstl_cli.core.files import require_writable
    from sstl_cli.core.runs import Run, write_runs
    from sstl_cli.physics.plan import plan
    from sstl_cli.physics.scenario import load
    from sstl_cli.steps import simulate as step

    screen, out, seed = Screen(asked.as_json), asked.out, asked.seed
    require_writable(out, asked.force)
    loaded = step.adjusted(load(asked.scenario), asked.simulator, asked.noise_n)
    screen.note_versions(loaded.package_version, "the scenario")
    with usage("--effect"):
        effects = step.effects_of(asked.effect or [])
    plans = plan(loaded, seed)
    total = len(plans)
    if loaded.output is not None and step.output_scale(loaded, systems := sorted({p.system for p in plans})) is None:
        without = ", ".join(s for s in systems if s not in loaded.output.per_n)
        screen.note(f"the output is in N: the scenario has no {loaded.output.unit} a newton of {without}")
    made = provenance(seed, files_among(asked.scenario))
    with screen.progress("simulating", total) as advance:

        def counted() -> Iterator[Run]:
            for run in step.run(loaded, effects, seed):
                yield run
                advance(1)

        samples = write_runs(out, counted(), made, asked.force, lambda: bool(loaded.tendons))
    screen.say(
        f"Simulated {many(total, 'run')} ({samples} samples) with the {_simulator(loaded.simulator, {**loaded.effects, **effects})} -> {out}"
    )
    document = SimulateDocument(
        schema="sstl.simulate/1",
        out=str(out),
        runs=total,
        samples=samples,
        simulator=loaded.simulator,
        effects={name: dict(values) for name, values in effects.items()},
        seed=seed,
    )
    screen.finish(document)


def _simulator(name: str, effects: Iterable[str]) -> str:
    """Return what simulated the runs, in words."""
    model = {"transmission": "fast model", "rig": "elastic rig"}.get(name, name)
    return f"{model} and {' + '.join(effects)}" if effects else model
