"""What `sstl export` writes, from Python: the same bytes, and the same errors."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest
from program import inside as called

import sstl_cli as sstl


@pytest.fixture(scope="module")
def log() -> sstl.Log:
    return sstl.simulate("sample", seed=1)


@pytest.mark.parametrize("ending", ["csv", "mat", "mcap"])
def test_a_log_is_written_as_the_command_writes_it(log: sstl.Log, tmp_path: Path, ending: str) -> None:
    log.write(tmp_path / "log.parquet")
    assert called("export", tmp_path / "log.parquet", "--format", ending, "--out", tmp_path / f"a.{ending}").returncode == 0
    log.export(tmp_path / f"b.{ending}")
    assert (tmp_path / f"a.{ending}").read_bytes() == (tmp_path / f"b.{ending}").read_bytes()
    with pytest.raises(sstl.SstlError, match="E101|exists"):
        log.export(tmp_path / f"b.{ending}")


def test_a_log_of_no_run_or_for_no_known_program_is_refused(log: sstl.Log, tmp_path: Path) -> None:
    with pytest.raises(sstl.SstlError, match="unknown format 'xlsx'"):
        log.export(tmp_path / "log.xlsx")
    with pytest.raises(sstl.SstlError, match="no run to write"):
        sstl.Log(()).export(tmp_path / "log.csv")
    other = (log.runs[0], replace(log.runs[1], unit_out="mm"))
    with pytest.raises(sstl.SstlError, match="E128|is in N and mm"):
        sstl.Log(other).export(tmp_path / "log.csv")
    assert not list(tmp_path.iterdir())


def test_controllers_are_those_of_the_command(log: sstl.Log, tmp_path: Path) -> None:
    log.write(tmp_path / "log.parquet")
    assert called("segment", tmp_path / "log.parquet", "--out", tmp_path / "theta.parquet").returncode == 0
    asked = ("export", tmp_path / "theta.parquet", "--t-max", "60")
    assert called(*asked, "--out", tmp_path / "a.json").returncode == 0
    assert called(*asked, "--format", "c", "--config-id", "CP-080", "--out", tmp_path / "a.c").returncode == 0
    found = sstl.controllers(log.segment(), options=sstl.ControllerOptions(t_max_n=60.0))
    found.write(tmp_path / "b.json")
    assert json.loads((tmp_path / "b.json").read_text()) == json.loads((tmp_path / "a.json").read_text())
    written = found.write_c(tmp_path / "b", config_id="CP-080")
    assert written == (tmp_path / "b.h", tmp_path / "b.c")
    for end in ("h", "c"):
        assert (tmp_path / f"b.{end}").read_text() == (tmp_path / f"a.{end}").read_text().replace('"a.h"', '"b.h"')
    # the parameters come back as they were written
    again = sstl.controllers(tmp_path / "b.json")
    assert again.lines == found.lines and again.options == found.options
    with pytest.raises(sstl.SstlError, match="2 configurations"):
        found.write_c(tmp_path / "c")
    for name in ("c.v2", "d e.c"):
        with pytest.raises(sstl.SstlError, match="E412"):
            found.write_c(tmp_path / name, config_id="CP-080")
    with pytest.raises(sstl.SstlError, match="no method 'PI'"):
        sstl.controllers(log.segment(), method="PI")


def test_a_mapping_is_written_as_the_command_writes_it(tmp_path: Path) -> None:
    pytest.importorskip("onnx")
    theta = sstl.simulate("sample-40", seed=1).segment()
    mapping = sstl.train(theta, variants="linear", seeds=2)
    mapping.save(tmp_path / "m.safetensors")
    assert called("export", tmp_path / "m.safetensors", "--format", "onnx", "--out", tmp_path / "a.onnx").returncode == 0
    mapping.export(tmp_path / "b.onnx")
    assert (tmp_path / "a.onnx").read_bytes() == (tmp_path / "b.onnx").read_bytes()
    # its slopes drive a controller, and what cannot be driven says why
    found = sstl.controllers(theta, mapping, config_id=str(theta["config_id"].iloc[0]))
    assert found.method == "proposed" and len(found.lines) == 1
