"""``info`` and ``check`` of the program's own CSV, JSON, JSON Lines and models."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from program import inside as sstl

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
        Run(name, "act", t, x + rng.normal(0, 0.01, len(t)), 0.7 * x + rng.normal(0, 0.01, len(t)), config_id="a")
        for name in ("r1", "r2")
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
        package_version="0", default="linear", seed=0, seeds=(0,), split_seed=0, per_seed_split=False, left_out="",
        variants=(VariantHeader(name="linear", alpha=None, weight_inv=0.0, rmse_validation=None),), test_share=0.2,
        configs=("a", "b"), roles=("fh",), data_sha256="0", pairs=2, tendons=(), strategy="single", strategy_rmse={},
        input_low=(0.0, 0.0), input_high=(1.0, 1.0), centre=(0.5, 0.5), precision=((1.0, 0.0), (0.0, 1.0)), reach=1.0,
        beta_act=None, beta_by_tendon={}, epochs=1, learning_rate=1.0, weight_decay=0.0,
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
