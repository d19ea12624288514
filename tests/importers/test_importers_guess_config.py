"""Columns and single values that tell the bending configuration, whatever else stands in their names."""

from __future__ import annotations

import tomllib
from collections.abc import Sequence
from pathlib import Path

import pytest
from scipy.io import savemat

from sstl_cli.importers.guess import Guess, guess
from sstl_cli.importers.mapping import mapping_of
from sstl_cli.steps.import_ import run

N = 60


def table(path: Path, names: str, *labels: Sequence[str]) -> Guess:
    """Return the proposal for runs of N rows, of which each has one of the labels of each column."""
    rows = [f"{0.01 * i:.2f},{3 + i % 20:.2f},{2 + i % 20:.2f}," + ",".join(told) for told in zip(*labels, strict=True) for i in range(N)]
    path.write_text("time (s),F_in (N),F_out (N)," + names + "\n" + "\n".join(rows) + "\n")
    return guess([path])


@pytest.mark.parametrize(
    "name", ["bend_angle_deg", "bend angle [deg]", "bending_deg", "bending", "sheath_bend", "bend radius [mm]", "config_name"]
)
def test_a_bend_of_one_run_is_taken_by_its_name(name: str, tmp_path: Path) -> None:
    found = table(tmp_path / "sstl.csv", name, ["65"])
    assert tomllib.loads(found.toml)["columns"]["config_id"] == name and not found.questions


@pytest.mark.parametrize("name", ["bend_angle_deg", "curvature_1/m", "sheath_bend"])
def test_one_that_changes_may_be_measured(name: str, tmp_path: Path) -> None:
    found = table(tmp_path / "sstl.csv", name, ["20", "65"])
    assert [q.target for q in found.questions] == ["config_id"] and "or is it measured" in found.questions[0].text


@pytest.mark.parametrize(("name", "values"), [("bend_stiffness", ["3.5"]), ("sheath_angle_deg", ["20"])])
def test_one_that_may_be_something_else_is_asked(name: str, values: list[str], tmp_path: Path) -> None:
    found = table(tmp_path / "sstl.csv", name, values)
    assert [q.target for q in found.questions] == ["config_id"] and "If not, take this line out" in found.questions[0].text


def test_of_two_it_is_asked_which(tmp_path: Path) -> None:
    found = table(tmp_path / "sstl.csv", "bend1_deg,bend2_deg", ["30", "30"], ["20", "65"])
    assert "'bend2_deg' or 'bend1_deg': which" in found.questions[0].text


def test_a_configuration_that_tells_the_bend_too_is_taken(tmp_path: Path) -> None:
    found = table(tmp_path / "sstl.csv", "bend_deg,config_id", ["20", "65"], ["A", "B"])
    assert tomllib.loads(found.toml)["columns"]["config_id"] == "config_id" and not found.questions


def test_a_configuration_of_systems_is_the_system(tmp_path: Path) -> None:
    found = table(tmp_path / "log.csv", "config,bend_deg", ["act", "sstl"], ["20", "20"])
    columns = tomllib.loads(found.toml)["columns"]
    assert (columns["system"], columns["config_id"]) == ("config", "bend_deg") and not found.questions


def test_a_column_against_the_name_is_asked(tmp_path: Path) -> None:
    found = table(tmp_path / "sstl_bend30.csv", "bend_deg", ["65"])
    assert "says 30, this column 65" in found.questions[0].text
    assert not table(tmp_path / "sstl_bend65.csv", "bend_deg", ["65.0"]).questions


def test_a_single_value_of_a_struct_is_taken(tmp_path: Path) -> None:
    path = tmp_path / "sstl.mat"
    time = [0.01 * i for i in range(N)]
    savemat(
        path,
        {
            "log": {
                "time_s": time,
                "Fin_N": [3.0 + i % 20 for i in range(N)],
                "Fout_N": [2.0 + i % 20 for i in range(N)],
                "bend_angle_deg": 65.0,
            }
        },
    )
    assert tomllib.loads(guess([path]).toml)["columns"]["config_id"] == "log.bend_angle_deg"


def log(path: Path, head: str) -> Path:
    path.write_text(
        head + "time (s),F_in (N),F_out (N)\n" + "".join(f"{0.01 * i:.2f},{3 + i % 20:.2f},{2 + i % 20:.2f}\n" for i in range(N))
    )
    return path


@pytest.mark.parametrize(
    "head",
    [
        "Configuration: single pass\nBend: 20\n",
        "# Bend: 20\n# Configuration: act\n",
        '# {"system": "act", "bend_deg": 20}\n',
        "# 20 deg bend, single pass\n",
        "# sheath bent by 20 deg\n# mode: single pass\n",
    ],
)
def test_a_configuration_that_is_a_system_hides_no_bend(head: str, tmp_path: Path) -> None:
    found = guess([log(tmp_path / "log001.csv", head)])
    constants = tomllib.loads(found.toml)["constants"]
    assert constants == {"config_id": "20", "system": "act"} and "the file says act" in found.toml


def test_two_statements_that_differ_are_both_asked(tmp_path: Path) -> None:
    found = guess([log(tmp_path / "act.csv", "# bend1: 20 deg\n# bend2: 40 deg\n")])
    assert [q.target for q in found.questions] == ["config_id"]
    assert "'# bend1: 20 deg' and '# bend2: 40 deg'" in found.questions[0].text


def test_files_that_state_both_systems_are_named(tmp_path: Path) -> None:
    files = [log(tmp_path / f"log00{i}.csv", f"# system: {s}\n") for i, s in enumerate(("act", "sstl"))]
    assert "'log000.csv' says act and 'log001.csv' says sstl" in guess(files).toml


def test_folders_whose_names_say_both_systems_are_named(tmp_path: Path) -> None:
    folders = [tmp_path / "act_bend20", tmp_path / "sstl_bend20"]
    for folder in folders:
        folder.mkdir()
    found = guess([log(folder / "data.csv", "") for folder in folders])
    assert "folders say both systems" in found.toml


def test_bends_that_names_of_structs_tell_are_labels_of_their_runs(tmp_path: Path) -> None:
    path = tmp_path / "all.mat"
    clock, fin = [0.01 * i for i in range(N)], [3.0 + i % 20 for i in range(N)]
    savemat(path, {f"act_bend{bend}": {"time_s": clock, "F_in_N": fin, "F_out_N": fin[::-1]} for bend in (20, 65)})
    found = guess([path])
    runs = run([path], mapping_of(tomllib.loads(found.toml), "m.toml")).runs
    assert not found.questions and {(r.system, r.config_id) for r in runs} == {("act", "20"), ("act", "65")}


def test_sides_in_mv_are_no_newtons(tmp_path: Path) -> None:
    path = log(tmp_path / "act_bend20.csv", "")
    path.write_text(path.read_text().replace("F_in (N),F_out (N)", "A_prox_mV,B_dist_mV"))
    columns = tomllib.loads(guess([path]).toml)["columns"]
    assert [columns[c]["unit"] for c in ("tension_in_n", "tension_out_n")] == ["mV", "mV"]
