"""Bends that stand in no file's name, but beside the table or in the name of a folder: asked, never lost."""

from __future__ import annotations

import tomllib
from pathlib import Path

import h5py
import numpy as np
import pytest
from header_table import T, X, Y, rows
from proposals import proposed

from sstl_cli.importers.guess import Guess, guess
from sstl_cli.importers.guess_files import name_pattern
from sstl_cli.importers.mapping import mapping_of
from sstl_cli.importers.pattern import search
from sstl_cli.steps.import_ import run

TABLE = "time_s,Fin_N,Fout_N\n" + rows(T, X, Y)


def asked(found: Guess, target: str) -> str:
    return "; ".join(q.text for q in found.questions if q.target == target)


@pytest.mark.parametrize(
    ("line", "bend"), [("# bend angle: 45 deg", "45"), ("Biegung (Grad),22.5", "22.5"), ("Config ID,CP-040", "CP-040"), ("Bend,60", "60")]
)
def test_a_bend_above_the_table_is_asked(line: str, bend: str, tmp_path: Path) -> None:
    _, found = proposed(tmp_path / "act.csv", f"{line}\n{TABLE}")
    assert tomllib.loads(found.toml)["constants"] == {"config_id": bend} and line in asked(found, "config_id")


def test_a_bend_that_the_name_tells_otherwise_is_asked_and_the_same_is_not(tmp_path: Path) -> None:
    _, found = proposed(tmp_path / "act_bend30.csv", f"# bend = 45 deg\n{TABLE}")
    assert "this or the name" in asked(found, "file_name")
    assert not proposed(tmp_path / "act_bend045.csv", f"# bend = 45 deg\n{TABLE}")[1].questions


def test_files_that_tell_several_bends_need_a_manifest(tmp_path: Path) -> None:
    for k in (1, 2):
        (tmp_path / f"act_run{k}.csv").write_text(f"# bend = {30 * k} deg\n{TABLE}")
    found = guess(sorted(tmp_path.glob("*.csv")))
    assert "'# bend = 30 deg' in 'act_run1.csv' and '# bend = 60 deg'" in asked(found, "config_id") and '"..."' in asked(found, "config_id")


def test_attributes_tell_bend_and_system(tmp_path: Path) -> None:
    with h5py.File(tmp_path / "rec.h5", "w") as file:
        file.attrs["bend_deg"], file.attrs["system"] = 60, "sstl"
        for name, values in (("t", T), ("Fin_N", X), ("Fout_N", Y)):
            file[name] = values
    found = guess([tmp_path / "rec.h5"])
    assert tomllib.loads(found.toml)["constants"] == {"config_id": "60", "system": "sstl"} and len(found.questions) == 2


def test_a_folder_tells_what_the_name_does_not(tmp_path: Path) -> None:
    folder = tmp_path / "sstl_bend30"
    folder.mkdir()
    _, found = proposed(folder / "log.csv", TABLE)
    assert tomllib.loads(found.toml)["constants"] == {"system": "sstl", "config_id": "30"} and "folder 'sstl_bend30'" in asked(
        found, "system"
    )
    assert not proposed(folder / "act_60deg.csv", TABLE)[1].questions
    deep = folder / "run1"
    deep.mkdir()
    assert tomllib.loads(proposed(deep / "log.csv", TABLE)[1].toml)["constants"]["config_id"] == "30"


def test_pairs_in_a_folder_each_belong_together(tmp_path: Path) -> None:
    for bend, shift in (("bend30", 0.0), ("bend60", 1.0)):
        (tmp_path / bend).mkdir()
        for side, values in (("in", X), ("out", Y + shift)):
            (tmp_path / bend / f"force_{side}.csv").write_text("t_s,F_N\n" + rows(T, values))
    files = sorted(tmp_path.rglob("*.csv"))
    found = guess(files)
    assert "does the folder (bend30, bend60)" in asked(found, "config_id")
    runs = list(run(files, mapping_of(tomllib.loads(found.toml), "m.toml")).runs)
    assert [r.config_id for r in runs] == ["bend30", "bend60"]
    assert [r.tension_out_n[0] - Y[0] for r in runs] == pytest.approx([0.0, 1.0], abs=1e-3)


def test_an_r_behind_a_bend_of_its_own_counts_repeats_and_one_in_mm_is_a_radius() -> None:
    beside = name_pattern(["act_bend22.5_r1", "act_bend45_r1"])
    assert beside.labels == ("system", "config_id") and not beside.question
    assert not name_pattern(["sstl_R50mm_03", "sstl_R100mm_03"]).question
    assert "config_id too" in name_pattern(["act_bend30_r50", "act_bend30_r100"]).question


def test_unix_time_called_ts_is_the_clock(tmp_path: Path) -> None:
    stamps = 1_714_745_000_000 + np.round(1e3 * T)
    columns, found = proposed(tmp_path / "act.csv", "ts,Fin_N,Fout_N\n" + rows(stamps, X, Y))
    assert columns["time_s"] == {"column": "ts", "unit": "ms"} and not found.questions


@pytest.mark.parametrize(
    ("stem", "bend"),
    [
        ("act 45 deg", "45"),
        ("rig act 45 degrees", "45"),
        ("act_45_deg", "45"),
        ("45 deg act", "45"),
        ("act 45°", "45"),
        ("act_90 Grad", "90"),
        ("act_30 degrés", "30"),
        ("act_45_deg_2", "45"),
        ("act_run_2_deg45", "45"),
        ("act-45deg", "45"),
        ("act_22.5_deg", "22.5"),
    ],
)
def test_an_angle_over_a_blank_or_with_a_sign_is_read(stem: str, bend: str) -> None:
    found = name_pattern([stem])
    told = search(found.pattern, [stem])[0]
    assert told == {"system": "act", "config_id": bend} and not found.question


@pytest.mark.parametrize(
    ("stem", "question"),
    [
        ("act_theta1.57", "behind 'theta'"),
        ("act_bend_0.5pi", "bend in pi"),
        ("act_1.57_rad", "bend in rad"),
        ("act_bend45_90", "45_90 one bend"),
        ("act_bend30-60", "30-60 one bend"),
        ("act_bend30_60_90_120", "30_60 one bend"),
        ("act_22,5deg", "22,5 one number"),
        ("act_20 deg C", "a temperature"),
        ("act_20°C", "a temperature"),
        ("act_1_deg_45", "or 45 behind it"),
        ("act_45_bend", "in front of 'bend'"),
        ("act_-45_deg", "its sign"),
        ("act_bend-45", "its sign"),
    ],
)
def test_an_angle_that_may_be_another_is_asked(stem: str, question: str) -> None:
    found = name_pattern([stem])
    assert "config_id" in found.labels and question in found.question


@pytest.mark.parametrize(
    "stem",
    [
        "act_bend45_1",
        "act_bend45_003",
        "act_bend45_20240514",
        "act_bend45_14_05_2024",
        "act_45_deg_2024-05-14",
        "act_bend45_run90",
        "act_bend45_20C",
    ],
)
def test_what_counts_behind_a_bend_is_not_asked(stem: str) -> None:
    assert not name_pattern([stem]).question


def test_a_folder_tells_an_angle_over_a_blank(tmp_path: Path) -> None:
    folder = tmp_path / "90_deg"
    folder.mkdir()
    _, found = proposed(folder / "act_1.csv", TABLE)
    assert tomllib.loads(found.toml)["constants"] == {"config_id": "90"} and "'90_deg'" in asked(found, "file_name")


@pytest.mark.parametrize(("stem", "other"), [("pi4_act_bend45", "4"), ("act_20°C_45deg", "20"), ("act_theta90_bend45", "90")])
def test_a_sure_bend_goes_before_one_in_doubt(stem: str, other: str) -> None:
    found = name_pattern([stem])
    assert search(found.pattern, [stem])[0] == {"system": "act", "config_id": "45"}
    assert f"{other} may be the config_id too" in found.question


def test_a_dash_behind_a_letter_is_a_hyphen() -> None:
    assert "sign" not in name_pattern(["act_CP-040_0003"]).question


@pytest.mark.parametrize("stem", ["22_5deg", "act_22-5deg", "act_bend22_5", "sstl22_5deg_run1", "act_67_25deg"])
def test_a_bend_that_may_have_its_decimals_behind_a_mark_is_asked(stem: str) -> None:
    assert "one number" in name_pattern([stem]).question


@pytest.mark.parametrize("stem", ["act_bend30_5", "act_12_60deg", "act_run2_5deg", "act_03_5deg"])
def test_what_counts_beside_a_bend_is_no_part_of_it(stem: str) -> None:
    assert not name_pattern([stem]).question


@pytest.mark.parametrize(("stem", "system"), [("ACT45", "ACT"), ("SSTL45", "SSTL"), ("act_45", "act"), ("45_sstl_run1", "sstl")])
def test_a_number_beside_a_system_is_asked_as_a_bend(stem: str, system: str) -> None:
    named = name_pattern([stem])
    [told] = search(named.pattern, [stem])
    assert told == {"system": system, "config_id": "45"} and "tell the bending configuration?" in named.question
    assert not name_pattern(["act1"]).labels and name_pattern(["act_20240503"]).labels == name_pattern(["act_3"]).labels == ("system",)


@pytest.mark.parametrize(
    ("stem", "system"), [("loop_75deg", "sstl"), ("double_30deg", "sstl"), ("single_30deg", "act"), ("log_30deg", "act")]
)
def test_a_word_for_the_tendons_way_in_a_name_is_proposed_and_asked(stem: str, system: str, tmp_path: Path) -> None:
    _, found = proposed(tmp_path / f"{stem}.csv", TABLE)
    assert tomllib.loads(found.toml)["constants"]["system"] == system and asked(found, "system")


def test_words_for_both_ways_in_names_are_the_system(tmp_path: Path) -> None:
    named = name_pattern(["loop_75deg", "single_75deg"])
    assert [m["system"] for m in search(named.pattern, ["loop_75deg", "single_75deg"]) if m] == ["loop", "single"] and named.question


@pytest.mark.parametrize(("line", "system"), [("System;Doppelt", "sstl"), ("System: einfach", "act"), ("System,doble", "sstl")])
def test_a_system_in_other_languages_above_the_table_is_read(line: str, system: str, tmp_path: Path) -> None:
    _, found = proposed(tmp_path / "log.csv", f"{line}\n{TABLE}")
    assert tomllib.loads(found.toml)["constants"]["system"] == system and "the file says" in asked(found, "system")


@pytest.mark.parametrize("stem", ["essai_coude_45", "prueba_codo_45", "test_bocht30", "essai_pliage_22.5", "essai_coude_45_rep2"])
def test_a_usual_bend_behind_an_unknown_word_is_asked_without_a_system(stem: str) -> None:
    named = name_pattern([stem])
    assert named.labels == ("config_id",) and "tell the bending configuration" in named.question


@pytest.mark.parametrize(
    "stem", ["essai_45", "log_2024", "run_45", "messung_30", "capture_100", "rope12_test", "loadcell_100N", "keithley_07"]
)
def test_a_number_that_counts_recordings_is_no_bend(stem: str) -> None:
    assert not name_pattern([stem]).labels


@pytest.mark.parametrize("stem", ["act_straight", "gerade_sstl", "act_curved_run2"])
def test_a_word_for_a_straight_sheath_beside_the_system_is_asked(stem: str) -> None:
    named = name_pattern([stem])
    assert set(named.labels) == {"system", "config_id"} and "the bending configuration" in named.question
