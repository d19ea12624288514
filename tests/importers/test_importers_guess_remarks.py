"""A system that the file tells beside its table: proposed where its name says none, asked where that says the other one."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from header_table import T, X, Y, rows
from nptdms import ChannelObject, GroupObject, RootObject, TdmsWriter
from scipy.io import savemat

from sstl_cli.importers.guess import Guess, guess

HEAD = "Time (s),Fin (N),Fout (N)\n"


def asked(found: Guess, target: str = "system") -> str:
    return next((q.text for q in found.questions if q.target == target), "")


def text(folder: Path, name: str, above: str) -> Path:
    path = folder / name
    path.write_text(above + HEAD + rows(T, X, Y))
    return path


@pytest.mark.parametrize("above", ["# system: sstl (double pass), bend 60 deg\n", "Test,SSTL\nBend,60\n\n", "% System = double pass\n"])
def test_a_line_above_the_table_that_says_another_system_is_asked(above: str, tmp_path: Path) -> None:
    found = guess([text(tmp_path, "act_bend60.csv", above)])
    assert "says act, the file itself sstl" in asked(found)
    assert not guess([text(tmp_path, "sstl_bend60.csv", above)]).questions
    assert 'system = "sstl"' in guess([text(tmp_path, "bend60.csv", above)]).toml


@pytest.mark.parametrize(
    "above", ["# act then sstl\n", "# T_act measured, /data/sstl/run1\n", "# Act. force in N, sstl_rig.vi\n", "# bench 2\n"]
)
def test_lines_that_name_no_single_system_are_no_question(above: str, tmp_path: Path) -> None:
    for name in ("act_bend60.csv", "sstl_bend60.csv"):
        assert not guess([text(tmp_path, name, above)]).questions


def test_of_several_files_the_one_that_says_another_system_is_named(tmp_path: Path) -> None:
    files = [text(tmp_path, "act_bend20.csv", "# system: act\n"), text(tmp_path, "act_bend40.csv", "# system: sstl\n")]
    assert "'act_bend40.csv' says act, the file itself sstl" in asked(guess(files), "file_name")


@pytest.mark.parametrize(("name", "asks"), [("act_bend60", "says act"), ("sstl_bend60", ""), ("log_20261120", "")])
def test_a_text_in_a_struct_gives_the_system(name: str, asks: str, tmp_path: Path) -> None:
    path = tmp_path / f"{name}.mat"
    savemat(path, {"log": {"time_s": T, "Fin_N": X, "Fout_N": Y, "system": "sstl"}})
    found = guess([path])
    assert 'system = "log.system"' in found.toml and asks in asked(found) and bool(asked(found)) == bool(asks)


@pytest.mark.parametrize(("group", "properties"), [("sstl", {}), ("Log", {"system": "sstl"}), ("Log", {"Description": "SSTL, 2nd rig"})])
def test_groups_and_properties_of_tdms_give_the_system(group: str, properties: dict[str, str], tmp_path: Path) -> None:
    for name, asks in (("act_bend60", "the file itself sstl"), ("sstl_bend60", "")):
        path = tmp_path / f"{name}.tdms"
        timed = {"wf_increment": 0.01, "wf_start_offset": 0.0, "unit_string": "N"}
        channels = [ChannelObject(group, n, np.asarray(v, float), timed) for n, v in (("F_in", X), ("F_out", Y))]
        with TdmsWriter(str(path)) as writer:
            writer.write_segment([RootObject(properties), GroupObject(group), *channels])
        found = guess([path])
        assert asks in asked(found) and bool(asked(found)) == bool(asks)
