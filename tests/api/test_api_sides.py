"""Nothing is reachable from one side alone: every option of a command is a parameter in Python, or it says why not."""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any, get_args, get_type_hints

import pytest
import typer

import sstl_cli as sstl
from sstl_cli.cli import _blind_show
from sstl_cli.cli import app as program

ROOT = Path(__file__).parents[2]
# the functions of a command; an option that is not named below is the parameter of that name
SIDES = {
    "blind learn": ["blind_learn"],
    "blind library": ["blind_library"],
    "blind limit": ["BlindSet.limit"],
    "blind make": ["BlindSet.make"],
    "blind real": ["blind_real", "blind_inject"],
    "blind run": ["BlindSet.run"],
    "blind score": ["BlindSet.score"],
    "check": ["Log.check"],
    "compensate": ["compensate", "controller", "ControllerOptions", "Biases"],
    "diagnose": ["diagnose", "plan", "stages"],
    "doctor": ["doctor"],
    "effects list": ["effects"],
    "effects show": ["effects"],
    "evaluate": ["Mapping.evaluate", "Mapping.predictions", "relate"],
    "export": ["controllers", "Controllers.write_c", "Controllers.write", "Log.export", "Mapping.export", "ControllerOptions", "Biases"],
    "import": ["import_", "guess"],
    "info": ["Log.summary"],
    "plot": ["Log.plot", "Diagnosis.plot"],
    "report": ["Diagnosis.report"],
    "reproduce": ["reproduce", "measure_spread", "Reproduction.write", "Reproduction.gap_logs"],
    "schema": ["schema"],
    "segment": ["Log.segment", "Log.phases"],
    "simulate": ["simulate"],
    "train": ["train"],
    "watch": ["watch"],
}
# options of another name, or that are a function of their own
NAMED = {
    "blind real --inject": "blind_inject.sizes",
    "check --no-physics": "Log.check.physics",
    "compensate --sim": "compensate.theta",
    "compensate --model": "compensate.mapping",
    "compensate --reference": "compensate.references",
    "compensate --plant-sim": "compensate.plant",
    "compensate --bias-theta": "compensate.biases",
    "compensate --loop-tau": "compensate.loop_tau_s",
    "compensate --mape-floor": "compensate.mape_floor_n",
    "compensate --out": "compensate.commands",
    "compensate --stream": "controller",
    "compensate --t-max": "ControllerOptions.t_max_n",
    "compensate --max-rate": "ControllerOptions.max_rate_n_s",
    "compensate --max-jump": "ControllerOptions.max_jump_n",
    "compensate --lead": "ControllerOptions.lead_s",
    "compensate --dt": "ControllerOptions.dt_s",
    "diagnose --plan": "plan.scenario",
    "diagnose --save-sim": "Diagnosis.save_model.path",
    "diagnose --next-out": "Diagnosis.proposed",
    "diagnose --max-tension": "diagnose.max_tension_n",
    "diagnose --max-rate": "diagnose.max_rate_n_per_s",
    "diagnose --no-physics": "diagnose.physics",
    "evaluate --tables": "relate",
    "export --bias-theta": "controllers.biases",
    "export --dt": "ControllerOptions.dt_s",
    "export --format": "Controllers.write_c",
    "export --lead": "ControllerOptions.lead_s",
    "export --max-jump": "ControllerOptions.max_jump_n",
    "export --max-rate": "ControllerOptions.max_rate_n_s",
    "export --model": "controllers.mapping",
    "export --t-max": "ControllerOptions.t_max_n",
    "evaluate --all": "Mapping.evaluate.everything",
    "evaluate --predictions": "Mapping.predictions",
    "import --map": "import_.mapping",
    "import --guess": "guess",
    "plot --run": "Log.plot.run_id",
    "reproduce --gap-logs": "Reproduction.gap_logs",
    "reproduce --spread": "measure_spread",
    "reproduce --spread-seeds": "measure_spread.seeds",
    "reproduce --table": "reproduce.tables",
    "segment --phases": "Log.phases",
    "segment --no-physics": "Log.segment.physics",
    "simulate --effect": "simulate.effects",
    "train --lambda": "train.weight_inv",
    "train --history": "Mapping.history",
}
# what has no meaning where an object is returned
NEVER = {
    "json": "what is returned is the document, or a table of it",
    "force": "it is a parameter of what writes a file, such as log.write",
    "out": "what is returned is no file; log.write, mapping.save, found.report and to_parquet of a DataFrame make one",
}
A_GATE = "a gate ends the program with another exit code: compare the number"
ALONE = {
    **{f"blind score --{name.replace('_', '-')}": A_GATE for name in _blind_show.GATES},
    "compensate --max-rmse": A_GATE,
    "compensate --scores": "what is returned",
    "compensate --timeout": "a program of your own knows when a sample is late: Controller.step(nan, nan) holds, then ramps down",
    "diagnose --max-rmse": A_GATE,
    "diagnose --max-gap-pct": A_GATE,
    "diagnose --expect": A_GATE,
    "diagnose --junit": "gates as a file for a build server",
    "diagnose --summary": "a text for a build server; found.sentence and the tables are what it holds",
    "evaluate --max-rmse": A_GATE,
    "watch --fail-on-alarm": A_GATE,
}
# a command of its own kind; docs/python.md says why
COMMANDS_ALONE = {"batch"}
# parameters that stand for an argument of the command, or for nothing that it could take
ARGUMENTS = {
    "measure_spread.path", "measure_spread.table", "Reproduction.write.path",
    "blind_inject.logs", "blind_learn.libraries", "blind_library.path", "blind_real.log",
    "diagnose.log", "evaluate.theta", "import_.files", "guess.files", "Mapping.evaluate.theta", "Mapping.predictions.theta",
    "stages.commands", "train.theta", "Diagnosis.report.path", "controllers.theta", "Controllers.write.path", "Controllers.write_c.path",
    "Log.export.path", "Mapping.export.path",
    "schema.name", "watch.logs",
    # as an object: files and options of their own hold the same
    "compensate.options", "controller.options", "controllers.options", "controller.method", "Biases.known", "ControllerOptions.observer", "ControllerOptions.widths", "ControllerOptions.band_n",
    "ControllerOptions.deadband_n", "ControllerOptions.tolerance_n", "ControllerOptions.hold_s", "ControllerOptions.ramp_n_s",
}  # fmt: skip


def commands() -> Iterator[tuple[str, list[Any]]]:
    """Yield every command with its options, those apart that all have."""
    program._register()

    def walk(command: Any, words: tuple[str, ...]) -> Iterator[tuple[str, list[Any]]]:
        below = getattr(command, "commands", None)
        if below is None:
            yield (
                " ".join(words),
                [p for p in command.params if any(o.startswith("--") for o in p.opts) and p.name not in ("help", "config")],
            )
        for name, inner in (below or {}).items():
            yield from walk(inner, (*words, name))

    return walk(typer.main.get_command(program.app), ())


def word(option: Any) -> str:
    return next(o for o in option.opts if o.startswith("--"))


OPTIONS = {f"{name} {word(o)}": o for name, options in commands() if name in SIDES for o in options}


def there(path: str) -> Any:
    """Return a public function or class by its name."""
    found: Any = sstl
    for part in path.split("."):
        found = getattr(found, part, None) or found.__dataclass_fields__[part]
    return found


def parameters(path: str) -> dict[str, Any]:
    """Return the parameters of a function, or the fields of a class, with their defaults."""
    made = there(path)
    return {n: p.default for n, p in inspect.signature(made).parameters.items() if n != "self"}


def stands_for(name: str) -> str | None:
    """Return what an option is in Python: a function, or a function and its parameter."""
    if name in NAMED:
        return NAMED[name]
    command, _, option = name.rpartition(" --")
    own = option.replace("-", "_")
    return next((f"{f}.{own}" for f in SIDES[command] if own in parameters(f)), None)


def test_every_command_has_a_side_in_python_or_is_named_as_one_without() -> None:
    names = {name for name, _ in commands()}
    assert {n for n in names if n.split()[0] not in COMMANDS_ALONE} == set(SIDES)
    assert {n.split()[0] for n in names} >= COMMANDS_ALONE
    text = (ROOT / "docs/python.md").read_text(encoding="utf-8").split("On the command line alone:")[1].split("\n\n")[0]
    for name in COMMANDS_ALONE:
        assert f"`{name}`" in text, name


@pytest.mark.parametrize("name", OPTIONS)
def test_every_option_is_in_python_or_says_why_not(name: str) -> None:
    found = stands_for(name)
    if found is None:
        assert name in ALONE or name.rpartition("--")[2] in NEVER, f"{name} is on the command line alone"
        return
    assert name not in ALONE, f"{name} is {found}: it needs no reason"
    function, _, parameter = found.rpartition(".")
    if function and parameter in parameters(function):
        given, usual = OPTIONS[name].default, parameters(function)[parameter]
        if name not in NAMED and given is not None and not OPTIONS[name].multiple:
            assert given == usual, f"{name} has another default than {found}"
    else:
        assert there(found) is not None


def test_the_tables_name_options_that_there_are() -> None:
    assert set(NAMED) | set(ALONE) <= set(OPTIONS)
    assert {n.rpartition("--")[2] for n in OPTIONS} >= set(NEVER)


def test_every_parameter_is_an_option_or_an_argument() -> None:
    reached = {found for name in OPTIONS if (found := stands_for(name))}
    # a parameter of the same name in the other functions of the command
    alike = {
        (command, found.rpartition(".")[2]) for name in OPTIONS if (found := stands_for(name)) for command in [name.rpartition(" --")[0]]
    }
    for command, functions in SIDES.items():
        for function in functions:
            for parameter in parameters(function):
                path = f"{function}.{parameter}"
                known = path in reached or path in ARGUMENTS or (command, parameter) in alike
                written = parameter == "force" and "path" in parameters(function)
                assert known or written, f"{path} is in Python alone"


def test_what_stands_in_a_public_signature_is_public() -> None:
    functions = [getattr(sstl, n) for n in sstl.__all__ if inspect.isfunction(getattr(sstl, n))]
    methods = [m for c in (sstl.Log, sstl.Mapping) for n, m in inspect.getmembers(c, inspect.isfunction) if not n.startswith("_")]

    def classes(hint: Any) -> Iterator[type]:
        if inspect.isclass(hint):
            yield hint
        for part in get_args(hint):
            yield from classes(part)

    public = {getattr(sstl, n) for n in sstl.__all__}
    assert len(functions) >= 11
    for function in functions:
        for hint in get_type_hints(function).values():
            own = [c for c in classes(hint) if c.__module__.startswith("sstl_cli")]
            assert set(own) <= public, f"{function.__name__}: {own}"
    assert all(f.__doc__ for f in (*functions, *methods))


def test_positional_arguments_are_few() -> None:
    for name in sstl.__all__:
        function = getattr(sstl, name)
        if inspect.isfunction(function):
            kinds = [p.kind for p in inspect.signature(function).parameters.values()]
            assert sum(k is inspect.Parameter.POSITIONAL_OR_KEYWORD for k in kinds) <= 2, name


def test_every_public_function_has_an_example() -> None:
    for name in sstl.__all__:
        made = getattr(sstl, name)
        if inspect.isfunction(made):
            assert re.search(r"^ *(>>>|\.\.\.) .*\b" + name + r"\(", made.__doc__ or "", flags=re.MULTILINE), name
