"""The paper's tables from Python are those of the command."""

from __future__ import annotations

import json
from pathlib import Path

import pandas as pd
import pyarrow.parquet as pq
import pytest
from program import inside

import sstl_cli as sstl
from sstl_cli.core.errors import SstlError
from sstl_cli.paper import data_seeds


def test_tables_are_those_of_the_command(tmp_path: Path) -> None:
    found = sstl.reproduce(["I", "II"], workers=1)
    told = inside("reproduce", "--table", "I,II", "--out", tmp_path / "cli", "--json")
    assert told.returncode == 0, told.stderr
    document = json.loads(told.stdout)
    # what was written is what the call asked for, not what was found
    assert {**found.document.plain(), "written": document["written"]} == document
    pd.testing.assert_frame_equal(found.entries, pq.read_table(tmp_path / "cli/tables.parquet").to_pandas())
    assert list(found.data) == ["cp40_theta"]
    pd.testing.assert_frame_equal(found.data["cp40_theta"], pq.read_table(tmp_path / "cli/cp40_theta.parquet").to_pandas())
    assert found.verdicts == document["verdicts"] and found.facts == document["facts"] and found.outside == []
    first = next(iter(found.tables))
    assert first.startswith("Table I:") and len(found.tables[first])
    assert found.write(tmp_path / "own") == document["written"]
    assert (tmp_path / "own/tables.tex").read_bytes() == (tmp_path / "cli/tables.tex").read_bytes()
    with pytest.raises(SstlError, match="exists already"):
        found.write(tmp_path / "own")
    with pytest.raises(SstlError, match="Table IV"):
        found.gap_logs()
    with pytest.raises(SstlError, match="no table 'VI'"):
        sstl.reproduce("VI")


def test_a_spread_that_was_stopped_goes_on(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    drawn = []

    def draw(experiment: str, seed: int) -> data_seeds.Drawn:
        drawn.append(seed)
        if len(drawn) == 3:
            raise KeyboardInterrupt
        return data_seeds.Drawn(seed, {"stated": {("I", "pull", "R"): 0.9 + 0.01 * seed}})

    monkeypatch.setattr(data_seeds, "draw", draw)
    with pytest.raises(KeyboardInterrupt):
        sstl.measure_spread(tmp_path / "s", seed=4, seeds=4)
    made = sstl.measure_spread(tmp_path / "s", seed=4, seeds=4)
    assert drawn == [5, 6, 7, 7, 8] and made.spread == str(tmp_path / "s/spread.csv")
    assert (tmp_path / "s/spread.csv").is_file()
    with pytest.raises(SstlError, match="exists already"):
        sstl.measure_spread(tmp_path / "s", seed=4, seeds=4)
