"""The public face for Python: its names stay, importing it is cheap, and it agrees with the program."""

from __future__ import annotations

import doctest
import inspect
import json
import operator
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pandas as pd
import pyarrow.parquet as pq
import pytest
from program import inside
from short_sample import SAMPLE, write

import sstl_cli as sstl
from sstl_cli.api import (
    blinded,
    catalogue,
    control,
    diagnosis,
    exporting,
    installed,
    log,
    mapping,
    planning,
    recordings,
    reproducing,
    watching,
)
from sstl_cli.cli import app as program
from sstl_cli.core import sound
from sstl_cli.core.errors import SstlError
from sstl_cli.core.runs import Run
from sstl_cli.steps import diagnose_tendons
from sstl_cli.steps.diagnose import DiagnoseOptions

ROOT = Path(__file__).parents[2]
NAMES = [
    "AlarmDocument", "Biases", "BlindInjectDocument", "BlindLearnDocument", "BlindLibraryDocument", "BlindLimitDocument",
    "BlindMakeDocument", "BlindRealDocument", "BlindRunDocument", "BlindScoreDocument", "BlindSet", "Controller", "ControllerOptions",
    "Controllers", "Diagnosis", "DoctorDocument", "Guess", "Log", "LoopDocument", "Mapping", "PlanDocument", "ReproduceDocument",
    "Reproduction", "Scenario", "SstlError", "StagesDocument", "WatchDocument", "blind_inject", "blind_learn", "blind_library",
    "blind_real", "compensate", "controller", "controllers", "diagnose", "doctor", "effects", "guess", "import_", "measure_spread",
    "plan", "read", "relate", "reproduce", "schema", "simulate", "stages", "train", "watch",
]  # fmt: skip
MEMBERS = {
    "Log": ["check", "export", "from_frame", "frame", "inputs", "phases", "plot", "runs", "segment", "summary", "write"],
    "Mapping": ["evaluate", "export", "history", "load", "model", "predict", "predictions", "save", "variants"],
    "BlindSet": ["cases", "limit", "make", "path", "run", "score"],
    "Controller": ["fault", "replay", "reset", "rest_tension", "step"],
    "Controllers": ["lines", "method", "options", "set_aside", "write", "write_c"],
    "Reproduction": ["data", "document", "entries", "facts", "gap_logs", "outside", "tables", "verdicts", "write"],
    "Diagnosis": [
        "candidates",
        "gap",
        "model",
        "parameters",
        "plot",
        "proposed",
        "proposed_tensions",
        "report",
        "save_model",
        "sentence",
        "to_dict",
        "verdict",
        "where",
    ],
}
# what a call without names relies on: arguments are added behind these, or by name
POSITIONS = {
    "blind_inject": "logs sizes", "blind_library": "path", "blind_real": "log", "compensate": "theta mapping", "controller": "theta mapping", "controllers": "theta mapping", "diagnose": "log sim", "measure_spread": "path table", "plan": "scenario effects", "relate": "theta", "reproduce": "tables",
    "schema": "name", "simulate": "scenario", "stages": "commands", "train": "theta",
    "Log.export": "path force", "Log.from_frame": "frame", "Log.plot": "kind run_id", "Log.write": "path force",
    "Mapping.evaluate": "theta everything", "Mapping.export": "path force", "Mapping.load": "path", "Mapping.predict": "gamma_sstl tendon variant",
    "Mapping.predictions": "theta everything", "Mapping.save": "path force",
    "Controllers.write": "path force", "Controllers.write_c": "path config_id real force",
    "Diagnosis.plot": "kind tendon", "Diagnosis.report": "path title force", "Diagnosis.save_model": "path force", "Reproduction.write": "path force",
}  # fmt: skip
# paths, or names alone
BY_NAME = {"blind_learn", "doctor", "effects", "guess", "import_", "read", "watch"}
FEW = {"effects": ["pulley_friction", "const_friction"], "max_effects": 1}


@pytest.fixture(scope="module", autouse=True)
def remembered() -> Iterator[None]:
    """Examples that ask for the same are answered once: of the same runs and options the diagnosis is the same."""
    made: dict[tuple[bytes, str], Any] = {}
    real = diagnose_tendons.run

    def run(runs: list[Run], options: DiagnoseOptions, earlier: None = None) -> Any:
        samples = pd.util.hash_pandas_object(sstl.Log(tuple(runs)).frame())
        key = (samples.to_numpy().tobytes(), repr(options))
        if key not in made:
            made[key] = real(runs, options, earlier=earlier)
        return made[key]

    with pytest.MonkeyPatch.context() as patch:
        # the functions alone: the command goes its own way
        patch.setattr(diagnosis, "diagnose_tendons", SimpleNamespace(run=run))
        yield


@pytest.fixture(scope="module")
def recorded() -> sstl.Log:
    return sstl.read(SAMPLE)


@pytest.fixture(scope="module")
def brief(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write(tmp_path_factory.mktemp("brief") / "log.parquet")


@pytest.fixture(scope="module")
def found(brief: Path) -> sstl.Diagnosis:
    return sstl.diagnose(sstl.read(brief), **FEW)


def test_public_names_stay() -> None:
    # names are added to, never renamed: what stands here may only grow
    assert set(NAMES) <= set(sstl.__all__) <= set(dir(sstl))
    for name, members in MEMBERS.items():
        kind = getattr(sstl, name)
        known = {*dir(kind), *getattr(kind, "__dataclass_fields__", {})}
        assert set(members) <= known, name


def test_arguments_that_may_be_given_by_position_keep_it() -> None:
    assert {name for name in sstl.__all__ if inspect.isfunction(getattr(sstl, name))} <= POSITIONS.keys() | BY_NAME
    for path, names in POSITIONS.items():
        own = inspect.signature(operator.attrgetter(path)(sstl)).parameters.values()
        given = [p.name for p in own if p.kind is p.POSITIONAL_OR_KEYWORD and p.name != "self"]
        assert " ".join(given).startswith(names), path


def test_every_public_name_has_a_docstring_and_an_unknown_one_says_so() -> None:
    assert all(getattr(sstl, name).__doc__ for name in sstl.__all__)
    with pytest.raises(AttributeError, match="public names"):
        sstl.no_such_thing  # noqa: B018


def test_importing_is_cheap_and_loads_nothing_heavy() -> None:
    code = (
        "import time; t = time.process_time(); import sys, sstl_cli; took = time.process_time() - t\n"
        "heavy = {'numpy', 'pandas', 'pyarrow', 'torch', 'numba', 'scipy', 'matplotlib'} & set(sys.modules)\n"
        "print(took, sorted(heavy))"
    )
    done = [subprocess.run([sys.executable, "-c", code], capture_output=True, text=True).stdout for _ in range(3)]
    assert all(text.strip().endswith("[]") for text in done)
    assert min(float(text.split()[0]) for text in done) < 0.2


@pytest.mark.parametrize(
    "module",
    [
        sstl,
        log,
        mapping,
        pytest.param(diagnosis, marks=pytest.mark.slow),
        control,
        blinded,
        catalogue,
        exporting,
        installed,
        planning,
        recordings,
        reproducing,
        watching,
    ],
    ids=lambda m: m.__name__,
)
def test_doctests(module) -> None:
    tried = doctest.testmod(module)
    assert tried.failed == 0
    assert tried.attempted


def test_the_example_in_readme_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys) -> None:
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    example = re.search(r"## From Python\n.*?```python\n(.*?)```", text, flags=re.S)
    assert example is not None
    write(tmp_path / "log.parquet")
    monkeypatch.chdir(tmp_path)
    exec(compile(example[1], "README.md", "exec"), {})
    assert "pulley_friction" in capsys.readouterr().out
    assert (tmp_path / "page.html").stat().st_size > 10_000


def test_the_page_names_everything_public_and_its_examples_run(capsys, monkeypatch: pytest.MonkeyPatch) -> None:
    text = (ROOT / "docs/python.md").read_text(encoding="utf-8")
    for name in (*NAMES, *(m for members in MEMBERS.values() for m in members)):
        assert re.search(rf"\b{name}\b", text), name
    # two runs of the eight show it
    whole = sstl.simulate
    monkeypatch.setattr(sstl, "simulate", lambda *a, **k: sstl.Log(whole(*a, **k).runs[:2]))
    space: dict = {}
    for example in re.findall(r"```python\n(.*?)```", text, flags=re.DOTALL):
        exec(compile(example, "docs/python.md", "exec"), space)
    assert capsys.readouterr().out.splitlines()[-1] == "Diagnosis(none)"


def test_a_frame_comes_back_as_the_same_log(recorded: sstl.Log) -> None:
    again = sstl.Log.from_frame(recorded.frame())
    pd.testing.assert_frame_equal(again.frame(), recorded.frame())
    assert [r.run_id for r in again.runs] == [r.run_id for r in recorded.runs]


def test_a_bad_sample_is_set_aside_aloud_and_no_position_stays_none(monkeypatch) -> None:
    t = np.arange(0.0, 1.0, 0.01)
    frame = pd.DataFrame({"run_id": "a", "system": "act", "time_s": t, "tension_in_n": t, "tension_out_n": t})
    frame.loc[3, "tension_out_n"] = np.nan
    # a command that ran before in this process may have left its ledger open
    monkeypatch.setattr(sound, "ledger", lambda: None)
    with pytest.warns(UserWarning, match="run a: 1 of 100 samples: 1 not a number in tension_out_n"):
        run = sstl.Log.from_frame(frame).runs[0]
    assert len(run) == 99 and np.isfinite(run.tension_out_n).all() and 0.03 not in run.time_s
    assert run.position_in_mm is None and run.config_id is None


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (lambda f: f.drop(columns="tension_out_n"), "tension_out_n"),
        (lambda f: f.assign(system="loop"), "'act' or 'sstl'"),
        (lambda f: f.assign(time_s="now"), "time_s"),
        (lambda f: pd.concat([f, f.assign(run_id="b"), f]), "two pieces"),
    ],
)
def test_a_frame_that_is_no_log_says_why(change, says: str) -> None:
    t = np.arange(0.0, 1.0, 0.1)
    frame = pd.DataFrame({"run_id": "a", "system": "act", "time_s": t, "tension_in_n": t, "tension_out_n": t})
    with pytest.raises(SstlError, match=says):
        sstl.Log.from_frame(change(frame))


def test_segment_gives_the_table_of_the_command(recorded: sstl.Log, tmp_path: Path, monkeypatch) -> None:
    out = tmp_path / "theta.parquet"
    assert _run(monkeypatch, "segment", SAMPLE, "--out", out) == 0
    pd.testing.assert_frame_equal(recorded.segment(), pq.read_table(out).to_pandas())


def test_diagnose_gives_the_document_of_the_command(found: sstl.Diagnosis, brief: Path, monkeypatch, capsys) -> None:
    assert _run(monkeypatch, "diagnose", brief, "--effects", ",".join(FEW["effects"]), "--max-effects", 1, "--json") == 0
    assert json.loads(capsys.readouterr().out) == found.to_dict()


def test_a_diagnosis_shows_its_parts(found: sstl.Diagnosis) -> None:
    document = found.to_dict()
    assert found.verdict.status == document["verdict"]["status"] == "identified"
    assert found.gap.rmse_retuned_n == document["gap"]["rmse_retuned_n"]
    assert found.where["share_pct"].sum() == pytest.approx(100)
    assert found.candidates["id"].tolist() == [c["id"] for c in document["candidates"]]
    first = found.parameters.iloc[0]
    # numbers of other samples do not compare, and an interval that is missing has a reason
    assert set(found.candidates["samples"]) == {"analysed"}
    assert (found.parameters["why"].isna() == found.parameters["ci95_low"].notna()).all()
    assert [first["ci95_low"], first["ci95_high"]] == document["candidates"][0]["parameters"][0]["ci95"]
    assert found.model().effects["pulley_friction"]["m_p"] == pytest.approx(first["estimate"])
    document["verdict"]["status"] = "none"
    assert found.verdict.status == "identified", "to_dict is a copy"


def test_pictures_page_and_notebook(found: sstl.Diagnosis, recorded: sstl.Log, tmp_path: Path) -> None:
    found.plot().savefig(tmp_path / "gap.png")
    assert (tmp_path / "gap.png").read_bytes().startswith(b"\x89PNG")
    assert found.plot("where").axes
    with pytest.raises(SstlError, match="unknown figure"):
        found.plot("nothing")
    found.report(tmp_path / "page.html")
    page = (tmp_path / "page.html").read_text(encoding="utf-8")
    assert "pulley" in page and recorded.runs[0].run_id in page
    with pytest.raises(SstlError, match="exists already"):
        found.report(tmp_path / "page.html")
    shown = found._repr_html_()
    assert "pulley_friction" in shown and "data:image/png" in shown
    assert recorded.runs[0].run_id in recorded._repr_html_()


def test_simulate_takes_what_the_program_takes(tmp_path: Path, monkeypatch) -> None:
    out = tmp_path / "log.parquet"
    text = "pulley_friction:m_p=0.1"
    words = ("--scenario", "two-tendons", "--effect", text, "--noise-n", "0.05", "--seed", "3")
    assert _run(monkeypatch, "simulate", *words, "--out", out) == 0
    made = sstl.simulate("two-tendons", effects=[text], noise_n=0.05, seed=3)
    same = sstl.simulate("two-tendons", effects={"pulley_friction": {"m_p": 0.1}}, noise_n=0.05, seed=3)
    pd.testing.assert_frame_equal(made.frame(), sstl.read(out).frame())
    pd.testing.assert_frame_equal(made.frame(), same.frame())
    made.write(tmp_path / "again.parquet")
    pd.testing.assert_frame_equal(sstl.read(tmp_path / "again.parquet").frame(), made.frame())
    for wrong in ({"simulator": "none-such"}, {"noise_n": -1.0}, {"effects": ["pulley_frictoin"]}):
        with pytest.raises(SstlError):
            sstl.simulate("two-tendons", **wrong)


def test_train_predict_and_keep(tmp_path: Path) -> None:
    theta = sstl.simulate("sample-40", seed=1).segment()
    made = sstl.train(theta, variants="linear", seeds=2)
    slopes = theta[theta["system"] == "sstl"][["gamma_p", "gamma_r"]].head(5)
    made.save(tmp_path / "m.safetensors")
    again = sstl.Mapping.load(tmp_path / "m.safetensors")
    np.testing.assert_array_equal(again.predict(slopes), made.predict(slopes))
    assert made.predict(slopes).shape == (5, 2)
    assert set(made.evaluate(theta)["variant"]) >= {"linear"} and made.history is not None
    assert made.variants["name"].tolist() == ["linear"]


def test_check_says_what_the_program_says(recorded: sstl.Log, tmp_path: Path) -> None:
    frame = recorded.frame()
    first = frame["run_id"] == recorded.runs[0].run_id
    # one stuck stretch, and an output that is too large to be passed on by friction
    frame.loc[frame.index[first][300:340], "tension_out_n"] = frame.loc[frame.index[first][300], "tension_out_n"]
    frame.loc[~first & (frame["system"] == "sstl"), "tension_out_n"] *= -1.0
    wrong = sstl.Log.from_frame(frame)
    wrong.write(tmp_path / "wrong.parquet")
    told = json.loads(inside("check", tmp_path / "wrong.parquet", "--json").stdout)["findings"]
    found = wrong.check()
    assert found.to_dict("records") == [{k: f[k] for k in found.columns} for f in told]
    assert set(found["level"]) >= {"failure"} and found["what"].str.startswith("physics").any()
    assert not wrong.check(physics=False)["what"].str.startswith("physics").any()
    assert not (recorded.check()["level"] == "failure").any()


def test_import_takes_what_the_program_takes(recorded: sstl.Log, tmp_path: Path) -> None:
    run = recorded.runs[0]
    table = pd.DataFrame({"t": 1000.0 * run.time_s, "T1": run.tension_in_n, "T2": run.tension_out_n})
    table.loc[40, "T2"] = np.nan
    table.to_csv(tmp_path / "bend.csv", index=False)
    short = "time_s=t:ms,tension_in_n=T1:N,tension_out_n=T2:N,system=act"
    assert inside("import", tmp_path / "bend.csv", "--map", short, "--out", tmp_path / "log.parquet").returncode == 3
    with pytest.warns(UserWarning, match="set aside: 1 samples"):
        made = sstl.import_(tmp_path / "bend.csv", mapping=short)
    pd.testing.assert_frame_equal(made.frame(), sstl.read(tmp_path / "log.parquet").frame())
    assert set(made.inputs) == {"bend.csv"}
    with pytest.raises(SstlError, match="T3"):
        sstl.import_(tmp_path / "bend.csv", mapping=short.replace("T2", "T3"))
    with pytest.raises(SstlError, match="No such file"):
        sstl.import_(tmp_path / "bend.csv", mapping=tmp_path / "none.toml")


def test_compensate_scores_as_the_program_does(recorded: sstl.Log, tmp_path: Path) -> None:
    theta = recorded.segment()
    recorded.write(tmp_path / "log.parquet")
    assert inside("segment", tmp_path / "log.parquet", "--out", tmp_path / "theta.parquet").returncode == 0
    words = ("--theta", tmp_path / "theta.parquet", "--methods", "none,DI", "--cycles", 1, "--scores", tmp_path / "s.parquet")
    assert inside("compensate", *words, "--reference", "sinusoid", "--reference", "trapezoid").returncode == 0
    made = sstl.compensate(theta, references=["sinusoid", "trapezoid"], methods=["none", "DI"], cycles=1)
    pd.testing.assert_frame_equal(made, pq.read_table(tmp_path / "s.parquet").to_pandas())
    for wrong, code in (({"references": ["sinus"]}, "E407"), ({"methods": ["best"]}, "E404"), ({"methods": ["proposed"]}, "E405")):
        with pytest.raises(SstlError) as said:
            sstl.compensate(theta, **wrong)
        assert said.value.code == code


def test_effects_are_those_that_the_program_lists() -> None:
    told = json.loads(inside("effects", "list", "--json").stdout)["effects"]
    made = sstl.effects()
    assert list(dict.fromkeys(made["id"])) == [e["id"] for e in told]
    keys = ["name", "unit", "neutral", "low", "high", "meaning"]
    assert made[keys].to_dict("records") == [{k: p[k] for k in keys} for e in told for p in e["parameters"]]


def test_the_page_says_of_every_command_where_it_is(capsys) -> None:
    """Nothing is reachable from one side alone without a word why."""
    text = (ROOT / "docs/python.md").read_text(encoding="utf-8")
    commands = re.findall(r"^  ([a-z]+) ", inside("--help").stdout.split("Commands:")[1], flags=re.MULTILINE)
    assert len(commands) > 15
    for name in commands:
        assert f"`{name}`" in text, name


def _run(monkeypatch: pytest.MonkeyPatch, *words: object) -> int:
    monkeypatch.setattr(sys, "argv", ["sstl", *map(str, words)])
    with pytest.raises(SystemExit) as end:
        program.main()
    return int(end.value.code or 0)
