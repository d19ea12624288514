"""``info`` and ``check`` of the program's own CSV, JSON, JSON Lines and models."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest
from program import inside as sstl

import sstl_cli
from sstl_cli.control import parameters
from sstl_cli.control.controller import Controller, Options, Theta
from sstl_cli.control.streaming import LineServer
from sstl_cli.core.errors import SstlError
from sstl_cli.core.provenance import Provenance
from sstl_cli.core.runs import Run, write_runs
from sstl_cli.mapping.header import Header, VariantHeader, weight_shapes
from sstl_cli.mapping.inference import SCALING, Group, MappingModel
from sstl_cli.mapping.weights import to_bytes
from sstl_cli.physics.effects import get


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a log, its CSV, and documents of several commands."""
    place = tmp_path_factory.mktemp("own")
    t = np.arange(2000) * 0.01
    rng = np.random.default_rng(4)
    x = 10 - 8 * np.cos(2 * np.pi * t / 5)
    runs = [
        Run(name, "act", t, x + rng.normal(0, 0.01, len(t)), 0.7 * x + rng.normal(0, 0.01, len(t)), config_id="a") for name in ("r1", "r2")
    ]
    write_runs(place / "log.parquet", runs, Provenance("test"))
    assert sstl("export", place / "log.parquet", "--format", "csv", "--out", place / "log.csv").returncode == 0
    done = sstl("segment", place / "log.parquet", "--out", place / "theta.parquet", "--json")
    (place / "segment.json").write_text(done.stdout)
    return place


def test_info_of_a_csv_says_what_info_of_the_log_says(folder: Path) -> None:
    files = [json.loads(sstl("info", folder / n, "--json").stdout)["files"][0] for n in ("log.csv", "log.parquet")]
    assert files[0]["runs"] == files[1]["runs"] and files[0]["rows"] == files[1]["rows"] == 4000


def test_check_of_a_csv_sees_what_is_wrong_with_it(folder: Path) -> None:
    levels = [
        {(f["run_id"], f["what"]) for f in json.loads(sstl("check", folder / n, "--json").stdout)["findings"]}
        for n in ("log.csv", "log.parquet")
    ]
    assert levels[0] == levels[1]
    lines = (folder / "log.csv").read_text().splitlines()
    cells = lines[50].split(",")
    cells[lines[0].split(",").index("tension_in_n")] = "nan"
    (folder / "bad.csv").write_text("\n".join([*lines[:50], ",".join(cells), *lines[51:100], *lines[99:]]) + "\n")
    done = sstl("check", folder / "bad.csv", "--json")
    found = {(f["run_id"], f["what"]) for f in json.loads(done.stdout)["findings"]}
    assert done.returncode == 1 and {("r1", "not a number"), ("r1", "time repeats")} <= found


def test_documents_are_described_and_checked(folder: Path) -> None:
    shown = sstl("info", folder / "segment.json")
    assert shown.returncode == 0 and "sstl.segment/1" in shown.stdout
    assert sstl("check", folder / "segment.json").returncode == 0
    document = json.loads((folder / "segment.json").read_text())
    document["runs"] = "two"
    (folder / "wrong.json").write_text(json.dumps(document))
    wrong = sstl("check", folder / "wrong.json", "--json")
    (finding,) = json.loads(wrong.stdout)["findings"]
    assert wrong.returncode == 1 and (finding["column"], finding["fix"]) == ("runs", "compare with: sstl schema segment")
    lines = [json.dumps(document | {"runs": n}) for n in (1, 2)]
    (folder / "two.jsonl").write_text("\n".join(lines) + "\n")
    assert sstl("check", folder / "two.jsonl").returncode == 0
    (folder / "cut.json").write_text('{"schema": "sstl.segm')
    assert sstl("check", folder / "cut.json").returncode == 1 and sstl("info", folder / "cut.json").returncode == 1


def model_bytes() -> bytes:
    """Return a small linear model that says the identity."""
    shapes = weight_shapes(None, 1, 2)
    header = Header(
        package_version="0",
        default="linear",
        seed=0,
        seeds=(0,),
        split_seed=0,
        per_seed_split=False,
        left_out="",
        variants=(VariantHeader(name="linear", alpha=None, weight_inv=0.0, rmse_validation=None),),
        test_share=0.2,
        configs=("a", "b"),
        roles=("fh",),
        data_sha256="0",
        pairs=2,
        tendons=(),
        strategy="single",
        strategy_rmse={},
        input_low=(0.0, 0.0),
        input_high=(1.0, 1.0),
        centre=(0.5, 0.5),
        precision=((1.0, 0.0), (0.0, 1.0)),
        reach=1.0,
        beta_act=None,
        beta_by_tendon={},
        epochs=1,
        learning_rate=1.0,
        weight_decay=0.0,
    )
    scaling = {k: np.ones((1, 2)) for k in SCALING}
    weights = {k: np.zeros(s, np.float32) for k, s in shapes.items()}
    return to_bytes(MappingModel(header, (Group(scaling, {"linear": weights}),)))


def test_a_model_is_described_and_checked(folder: Path) -> None:
    (folder / "m.safetensors").write_bytes(model_bytes())
    shown = sstl("info", folder / "m.safetensors")
    assert shown.returncode == 0 and "mapping model" in shown.stdout, shown.stderr
    assert sstl("check", folder / "m.safetensors").returncode == 0
    (folder / "n.safetensors").write_bytes(model_bytes()[:-8])
    damaged = sstl("check", folder / "n.safetensors")
    assert damaged.returncode == 1 and "Traceback" not in damaged.stderr


def test_a_parameter_out_of_range_names_the_nearest_allowed() -> None:
    effect = get("pulley_friction")
    name = effect.parameters[0].name
    with pytest.raises(SstlError, match=r"\[E702\].*nearest allowed is .*sstl effects show pulley_friction"):
        effect.complete({name: 1e9})


def found_in(path: Path) -> tuple[int, list[tuple[str, str]]]:
    """Return the exit code of ``check`` of a file, and level and kind of what it found."""
    done = sstl("check", path, "--json")
    return done.returncode, [(f["level"], f["what"]) for f in json.loads(done.stdout)["findings"]]


def test_a_log_as_csv_is_judged_by_physics(folder: Path) -> None:
    whole = (folder / "log.csv").read_text()
    assert found_in(folder / "log.csv") == found_in(folder / "log.parquet")
    assert json.loads(sstl("check", folder / "log.csv", "--json").stdout)["sensors"]
    rows = [line.split(",") for line in whole.splitlines()]
    at = [rows[0].index(n) for n in ("tension_in_n", "tension_out_n")]
    for row in rows[1:]:
        for i in at:
            row[i] = str(round(300 * float(row[i])))
    (folder / "counts.csv").write_text("\n".join(",".join(r) for r in rows) + "\n")
    code, found = found_in(folder / "counts.csv")
    assert code == 1 and ("failure", "physics: counts") in found


def test_the_unit_of_an_output_that_is_no_tension_is_read_from_the_csv(folder: Path) -> None:
    t = np.arange(500) * 0.01
    x = 10 - 8 * np.cos(2 * np.pi * t / 5)
    write_runs(folder / "deg.parquet", [Run("r", "act", t, x, 0.7 * x, unit_out="deg")], Provenance("test"))
    assert sstl("export", folder / "deg.parquet", "--format", "csv", "--out", folder / "deg.csv").returncode == 0
    assert "T_out deg" in sstl("info", folder / "deg.csv").stdout
    assert found_in(folder / "deg.csv") == found_in(folder / "deg.parquet")


def controller_file(path: Path, **lines: float) -> Path:
    """Write parameters of a controller for two configurations, the lines of the second changed."""
    sound = {"gamma_p": 0.7, "beta_p": 0.1, "gamma_r": 1.3, "beta_r": -0.1}
    document = parameters.document({"a": Theta(**sound), "b": Theta(**sound)}, Options(), "DI").plain()
    document["configurations"][1]["theta"].update(lines)
    path.write_text(json.dumps(document))
    return path


def test_parameters_of_the_controller_are_described_and_checked(folder: Path) -> None:
    sound = controller_file(folder / "controller.json")
    assert found_in(sound) == (0, [])
    shown = sstl("info", sound)
    assert shown.returncode == 0 and "sstl.controller/1" in shown.stdout and "1.3" in shown.stdout
    assert found_in(controller_file(folder / "crossed.json", gamma_p=1.4)) == (1, [("failure", "no such controller")])
    nan = controller_file(folder / "nan.json", beta_r=float("nan"))
    assert found_in(nan)[0] == 1
    document = json.loads(sound.read_text())
    document["configurations"][1]["config_id"] = "a"
    (folder / "twice.json").write_text(json.dumps(document))
    assert found_in(folder / "twice.json") == (1, [("failure", "configuration comes twice")])
    del document["configurations"][0]["theta"]["beta_p"]
    (folder / "lacks.json").write_text(json.dumps(document))
    assert found_in(folder / "lacks.json") == (1, [("failure", "does not fit its schema")])
    assert sstl("info", folder / "lacks.json").returncode == 1


@pytest.mark.parametrize("form", ["csv", "jsonl"])
def test_answers_of_a_stream_are_described_and_checked(folder: Path, form: str) -> None:
    server = LineServer(Controller(Theta(0.7, 0.1, 1.3, -0.1), Options()), lambda said: None)
    asked = ["t_ref,t_in", "1,0", "2,1"] if form == "csv" else ['{"t_ref": 1, "t_in": 0}', '{"t_ref": 2, "t_in": 1}']
    path = folder / f"answers.{form}"
    path.write_text("\n".join(map(server.answer, asked)) + "\n")
    assert found_in(path) == (0, [])
    assert "2 answers of compensate --stream" in sstl("info", path).stdout
    path.write_text(path.read_text() + server.answer("nonsense") + "\n")
    assert found_in(path) == (0, [("remark", "safe command")])
    path.write_text(path.read_text() + "1.5,P\n")
    assert found_in(path) == (1, [("failure", "no answer"), ("remark", "safe command")])


def test_scenarios_and_mappings_are_described_and_checked(folder: Path) -> None:
    (folder / "rig.toml").write_text(
        'schema = "sstl.scenario/1"\n[[configurations]]\nid = "a"\ntheta = 0.5\n'
        '[[trajectories]]\nkind = "trapezoid"\nlabel = "slow"\nduration_s = 12.0\n'
    )
    (folder / "map.toml").write_text('[columns]\ntime_s = 1\n[constants]\nsystem = "act"\n')
    for name, words in (("rig.toml", "is a scenario sstl.scenario/1"), ("map.toml", "is a mapping")):
        assert found_in(folder / name) == (0, []) and words in sstl("info", folder / name).stdout
    (folder / "asks.toml").write_text("[columns]\ntime_s = 1  # (?) which is it\n")
    assert found_in(folder / "asks.toml") == (1, [("failure", "open question")])
    (folder / "bad.toml").write_text((folder / "rig.toml").read_text().replace("duration_s", "duration"))
    assert found_in(folder / "bad.toml")[0] == 1


def test_check_knows_every_document_that_the_program_writes(folder: Path) -> None:
    source = "".join(p.read_text() for p in sorted(Path(sstl_cli.__file__).parent.rglob("*.py")))
    for schema in sorted(set(re.findall(r'"(sstl\.[a-z.-]+/1)"', source)) - {"sstl.scenario/1"}):
        (folder / "any.json").write_text(json.dumps({"schema": schema}))
        assert not any(what == "unknown document" for _, what in found_in(folder / "any.json")[1]), schema
    (folder / "schema.json").write_text(sstl("schema", "diagnosis").stdout)
    assert found_in(folder / "schema.json") == (0, [])
