"""What the physics gate sets aside is the same from Python as in the program."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pandas as pd
import pyarrow.parquet as pq
import pytest
from program import inside

import sstl_cli as sstl
from sstl_cli.core.errors import SstlError
from sstl_cli.core.runs import Run

SAMPLE = Path(__file__).parents[2] / "data/samples/log.parquet"
BAD = "CP-080-0-trapezoid-act"


def changed(change: Callable[[Run], Run]) -> sstl.Log:
    return sstl.Log(tuple(change(run) for run in sstl.read(SAMPLE).runs))


def five_times(run: Run) -> Run:
    return replace(run, tension_out_n=5.0 * run.tension_out_n)


@pytest.fixture
def wrong(tmp_path: Path) -> tuple[sstl.Log, Path]:
    log = changed(lambda run: five_times(run) if run.run_id == BAD else run)
    log.write(tmp_path / "log.parquet")
    return log, tmp_path


def test_segment_sets_the_same_runs_aside(wrong: tuple[sstl.Log, Path]) -> None:
    log, folder = wrong
    words = ("segment", folder / "log.parquet", "--out", folder / "theta.parquet", "--phases", folder / "phases.parquet")
    assert inside(*words).returncode == 3
    with pytest.warns(UserWarning, match="set aside: 1 of 8 runs"):
        theta = log.segment()
    pd.testing.assert_frame_equal(theta, pq.read_table(folder / "theta.parquet").to_pandas())
    (row,) = theta[theta["status"] != "ok"].to_dict("records")
    assert row["run_id"] == BAD and "gain" in row["status"] and row["gamma_p"] != row["gamma_p"]
    with pytest.warns(UserWarning, match="set aside"):
        phases = log.phases()
    pd.testing.assert_frame_equal(phases, pq.read_table(folder / "phases.parquet").to_pandas())


def test_segment_without_physics_keeps_it(wrong: tuple[sstl.Log, Path], recwarn: pytest.WarningsRecorder) -> None:
    log, folder = wrong
    assert inside("segment", folder / "log.parquet", "--out", folder / "theta.parquet", "--no-physics").returncode == 0
    theta = log.segment(physics=False)
    pd.testing.assert_frame_equal(theta, pq.read_table(folder / "theta.parquet").to_pandas())
    assert (theta["status"] == "ok").all() and not recwarn.list


def test_segment_ends_alike_where_nothing_is_left() -> None:
    empty = sstl.Log(())
    none_right = changed(lambda run: replace(run, tension_in_n=1000.0 * run.tension_in_n, tension_out_n=1000.0 * run.tension_out_n))
    for log, code in ((empty, "E221"), (none_right, "E223")):
        with pytest.raises(SstlError) as said:
            log.segment()
        assert said.value.code == code


def test_segment_remarks_on_what_check_remarks_on(tmp_path: Path) -> None:
    # the clock of one bend is slow, and it takes the movements to see that in both of them
    log = changed(lambda run: replace(run, time_s=2.0 * run.time_s) if run.config_id == "CP-020" else run)
    log.write(tmp_path / "log.parquet")
    checked = json.loads(inside("check", tmp_path / "log.parquet", "--json").stdout)["physics"]
    segmented = json.loads(inside("segment", tmp_path / "log.parquet", "--out", tmp_path / "t.parquet", "--json").stdout)["remarks"]
    assert len(checked) == 2 and segmented == checked


@pytest.mark.slow
@pytest.mark.parametrize(("physics", "words", "code"), [(True, (), 3), pytest.param(False, ("--no-physics",), 0, id="no physics")])
def test_diagnose_sets_the_same_runs_aside(wrong: tuple[sstl.Log, Path], physics: bool, words: tuple[str, ...], code: int) -> None:
    log, folder = wrong
    done = inside("diagnose", folder / "log.parquet", "--effects", "zero_offset", "--max-effects", 1, *words, "--json")
    found = sstl.diagnose(log, effects=["zero_offset"], max_effects=1, physics=physics).to_dict()
    told = json.loads(done.stdout)
    assert done.returncode == code and (BAD in told["analysis"]["set_aside"]) == physics
    assert found["verdict"] == told["verdict"] and found["analysis"] == told["analysis"] and found["remarks"] == told["remarks"]
