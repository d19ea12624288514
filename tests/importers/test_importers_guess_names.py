"""What names of files tell of systems and configurations, however they are written."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from header_table import T, X, Y, rows

from sstl_cli.core.errors import SstlError
from sstl_cli.importers.guess import guess
from sstl_cli.importers.guess_files import name_pattern
from sstl_cli.importers.mapping import mapping_of, read_mapping
from sstl_cli.steps.import_ import run

HEAD = "Time (s),Fin (N),Fout (N)\n"


def written(folder: Path, stems: list[str], head: str = HEAD) -> list[Path]:
    files = [folder / f"{stem}.csv" for stem in stems]
    for path in files:
        path.write_text(head + rows(T, X, Y))
    return files


@pytest.mark.parametrize(
    ("stems", "systems"),
    [
        (["ACT_bend20", "SSTL_bend20"], ["act", "sstl"]),
        (["Act-bend20", "Sstl-bend20"], ["act", "sstl"]),
        (["actuation_bend20", "sensing_bend20"], ["act", "sstl"]),
        (["bend20_SSTL"], ["sstl"]),
    ],
)
def test_a_system_may_be_written_in_capitals_and_in_full(stems: list[str], systems: list[str], tmp_path: Path) -> None:
    files = written(tmp_path, stems)
    found = guess(files)
    assert not found.questions
    (tmp_path / "rig.toml").write_text(found.toml)
    assert [(r.system, r.config_id) for r in run(files, read_mapping(tmp_path / "rig.toml")).runs] == [(s, "20") for s in systems]


@pytest.mark.parametrize(
    "stems", [["sensing_bend20"], ["actuation_bend20", "actuation_bend30"], ["SSTL_vs_ACT_bend30"], ["DES_ACT_bend30"]]
)
def test_one_long_word_may_be_the_subject_and_is_asked(stems: list[str]) -> None:
    assert name_pattern(stems).labels == ("config_id",)


@pytest.mark.parametrize("label", ["ACT", "SSTL", "Sensing", "actuation"])
def test_a_system_in_other_letters_is_read(label: str, tmp_path: Path) -> None:
    known = "act" if label.lower().startswith("act") else "sstl"
    named = {"time_s": "Time (s)", "tension_in_n": "Fin (N)", "tension_out_n": "Fout (N)"}
    [one] = run(written(tmp_path, ["a"]), mapping_of({"columns": named, "constants": {"system": label}}, "m.toml")).runs
    assert one.system == known
    path = tmp_path / "b.csv"
    path.write_text("System," + HEAD + rows(label, T, X, Y))
    found = guess([path])
    assert 'system = "System"' in found.toml and not found.questions
    (tmp_path / "rig.toml").write_text(found.toml)
    assert [r.system for r in run([path], read_mapping(tmp_path / "rig.toml")).runs] == [known]
    with pytest.raises(SstlError, match="E334.*system is 'tip'"):
        list(run([path], mapping_of({"columns": named, "constants": {"system": "tip"}}, "m.toml")).runs)


def test_location_and_lead_are_the_configuration(tmp_path: Path) -> None:
    """Without one nothing is paired: ``train`` had 0 configurations of both systems."""
    files = written(tmp_path, [f"NP_lead{lead}_{system}_run1" for lead in (10, 20) for system in ("act", "sstl")])
    found = guess(files)
    assert not found.questions and any("config_id = {location}-{lead_mm}" in r for r in found.reasons)
    (tmp_path / "rig.toml").write_text(found.toml)
    runs = list(run(files, read_mapping(tmp_path / "rig.toml")).runs)
    assert [(r.config_id, r.lead_mm, r.system) for r in runs] == [
        ("NP-10", 10.0, "act"),
        ("NP-10", 10.0, "sstl"),
        ("NP-20", 20.0, "act"),
        ("NP-20", 20.0, "sstl"),
    ]


def test_a_bend_in_the_name_or_a_column_of_configurations_goes_before_the_lead(tmp_path: Path) -> None:
    assert dict(name_pattern(["NP_lead10_bend30_act"]).constants) == {"config_id": "{location}-{bend}"}
    assert not name_pattern(["lead10_act"]).constants
    [path] = written(tmp_path, ["NP_lead10_act"])
    path.write_text("config," + HEAD + rows("C7", T, X, Y))
    found = guess([path])
    assert 'config_id = "config"' in found.toml and "{lead_mm}" not in found.toml


@pytest.mark.parametrize(
    "stem",
    [
        "no_sstl_bend30",
        "bend30_without_sstl",
        "bend30_sstl_off",
        "non-sstl_bend30",
        "sstl_removed_bend30",
        "Biegung30_ohne_sstl",
        "bend30_sans_act",
    ],
)
def test_a_label_that_its_neighbour_denies_is_asked(stem: str) -> None:
    found = name_pattern([stem])
    assert "system" in found.labels and "does it hold here?" in found.question


@pytest.mark.parametrize("stem", ["bend30_sstl_on", "bend30_sstl_no_2", "bend30_sstl_no_load"])
def test_a_word_that_denies_something_else_raises_no_question(stem: str) -> None:
    found = name_pattern([stem])
    assert "system" in found.labels and not found.question


def test_of_several_names_one_that_denies_the_label_is_enough() -> None:
    assert "'off' stands beside 'sstl'" in name_pattern(["bend30_sstl_on", "bend60_sstl_off"]).question


@pytest.mark.parametrize(
    "stems",
    [
        ["sstl_CP_1", "sstl_CP_2"],
        ["ND_5mms_act", "ND_10mms_act"],
        ["CP_5N_act"],
        ["CP_1Hz_act"],
        ["NP_02May_act"],
        ["CP_R50_act"],
        ["CP1_act"],
    ],
)
def test_a_number_beside_a_location_is_asked(stems: list[str]) -> None:
    found = name_pattern(stems)
    assert "config_id" in found.labels and ("bending configuration" in found.question or "repeat" in found.question)


@pytest.mark.parametrize("stems", [("act", "sstl"), ("log",)])
def test_folders_of_files_of_one_name_may_tell_the_configuration(stems: tuple[str, ...], tmp_path: Path) -> None:
    files = []
    for bend in ("bend30", "bend60"):
        (tmp_path / bend).mkdir()
        files += written(tmp_path / bend, list(stems))
    found = guess(files)
    assert any("does the folder (bend30, bend60) tell the bending configuration" in q.text for q in found.questions)
    mapping = tmp_path / "m.toml"
    mapping.write_text(re.sub(r"  # \(\?\).*", "", found.toml), encoding="utf-8")
    runs = list(run(files, read_mapping(mapping)).runs)
    assert sorted(r.config_id for r in runs) == sorted(["bend30", "bend60"] * len(stems))
    assert any("folder 'bend30' says so" in q.text for q in guess(files[: len(stems)]).questions)


def test_what_counts_behind_an_r_beside_a_number_of_its_own_are_repeats() -> None:
    found = name_pattern([f"act_{bend}_r{k}" for bend in (30, 60) for k in (1, 2)])
    assert "(?P<config_id>\\d+)_" in found.pattern and "r(?P" not in found.pattern and "bending configuration" in found.question
    # a radius does not count
    assert "r(?P<config_id>" in name_pattern([f"act_{k}_r{bend}" for bend in (30, 60) for k in (1, 2)]).pattern


@pytest.mark.parametrize(
    "stem", ["CP_40deg_act", "CP_bend40_act", "CP_cfg2_act", "CP_040_act_run1", "CP_run1_act", "NP_act_2024-05-02_140311"]
)
def test_a_number_beside_a_location_whose_word_is_known_is_no_question(stem: str) -> None:
    assert not name_pattern([stem]).question


@pytest.mark.parametrize(
    ("stem", "question"),
    [
        ("NP_lead2p5_sstl", "2p5 one number"),
        ("NP_lead2d5_sstl", "2d5 one number"),
        ("NP_lead2,5_sstl", "2,5 one number"),
        ("NP_lead2-5_sstl", "2-5 one number"),
        ("NP_lead2_5_sstl", "2_5 one number"),
        ("NP_lead2_5mm_sstl", "2_5 one number"),
        ("NP_lead1in_act", "1in in mm?"),
        ("NP_lead1_inch_act", "1inch in mm?"),
        ("NP_lead-5_act", "its sign"),
        ("NP_bend2,5_sstl", "2,5 one number"),
        ("NP_lead10_act", ""),
        ("NP_lead10mm_act", ""),
        ("NP_lead10act", ""),
        ("NP-lead-10-act", ""),
        ("NP_lead10_20240502_act", ""),
        ("NP_lead10_30deg_act", ""),
        ("NP_lead2.5_act_1", ""),
    ],
)
def test_a_lead_that_goes_on_or_has_a_unit_or_a_sign_is_asked(stem: str, question: str) -> None:
    found = name_pattern([stem])
    assert question in found.question and bool(question) == bool(found.question)


def test_an_angle_per_second_with_a_number_behind_is_asked() -> None:
    assert "a speed per s" in name_pattern(["sstl_10deg_s_1"]).question


@pytest.mark.parametrize("last", [("1", "2"), ("slow", "fast")])
def test_what_varies_behind_a_location_and_a_lead_is_asked_and_is_no_bend(last: tuple[str, str]) -> None:
    """Deleting the mark made one configuration of a lead of 10 mm and one of 20 mm."""
    found = name_pattern([f"P3_NP_lead{lead}_{system}_{n}" for lead, system, n in (("10", "sstl", last[0]), ("20", "act", last[1]))])
    assert dict(found.constants) == {"config_id": "{location}-{lead_mm}"} and "<bend>" not in found.pattern
    assert "no label" in found.question


@pytest.mark.parametrize(
    "stems",
    [
        ["essai4_courbure30_act"],
        ["prova2_piega30_sstl"],
        ["曲げ30_sstl_1回目"],
        ["act_굽힘30"],
        ["ensaio_curva30_sstl"],
        ["Versuch3_Bieg30_act"],
        ["courbure30_act", "courbure30_sstl"],
        ["essai_courbure_30_act"],
    ],
)
def test_a_word_for_a_bend_in_other_languages_gives_the_label(stems: list[str]) -> None:
    found = name_pattern(stems)
    assert set(found.labels) == {"system", "config_id"} and not found.question and "config_id from '30'" in found.reason


@pytest.mark.parametrize(
    ("stems", "number"),
    [
        (["meting5_bocht30_act"], "30 behind 'bocht' or 5 behind 'meting'"),
        (["b30_sstl_1"], "30 behind 'b'"),
        (["rig_tofile_sstl_b45"], "45 behind 'b'"),
        (["изгиб30_act"], "30 behind 'изгиб'"),
        (["b30_act", "b30_sstl"], "30 behind 'b'"),
    ],
)
def test_a_number_behind_a_word_that_may_call_a_bend_is_asked(stems: list[str], number: str) -> None:
    found = name_pattern(stems)
    assert f"does {number} tell the bending configuration?" in found.question and "config_id" in found.labels


@pytest.mark.parametrize(
    "stem",
    [
        "act_run1",
        "sstl_1",
        "act_5N",
        "act_f0p2Hz",
        "sstl_v20",
        "tek0007_act",
        "exp07_sstl",
        "sheath2_act",
        "sstl_T2",
        "2024-05-02_act",
        "b30",
    ],
)
def test_a_number_that_counts_or_measures_something_else_raises_no_question(stem: str) -> None:
    assert not name_pattern([stem]).question and "config_id" not in name_pattern([stem]).labels


def test_the_bend_of_one_file_is_written(tmp_path: Path) -> None:
    """It stood in the pattern as a literal, and act never met sstl."""
    files = written(tmp_path, ["曲げ30_act", "曲げ30_sstl"])
    (tmp_path / "rig.toml").write_text(guess(files[:1]).toml, encoding="utf-8")
    assert [(r.system, r.config_id) for r in run(files, read_mapping(tmp_path / "rig.toml")).runs] == [("act", "30"), ("sstl", "30")]


@pytest.mark.parametrize(
    "stem",
    [
        "loop_act_motor",
        "double_pass_bend20_act",
        "doublepass_act_tendon",
        "two-pass_act_run1",
        "act_2pass_1",
        "act_roundtrip_3",
        "single_pass_sstl_rig_1",
        "SSTL_rig_single_bend20",
        "20240514_act1_sensor2",
        "actLoopBend30",
        "hin_rueck_schleife_act",
    ],
)
def test_a_system_beside_words_for_the_other_is_asked(stem: str, tmp_path: Path) -> None:
    found = guess(written(tmp_path, [stem]))
    assert "system" in {q.target for q in found.questions} and "(?P<system>" not in found.toml


@pytest.mark.parametrize(
    "stems",
    [
        ["single_pass_act_bend20"],
        ["sstl_loop_bend20", "sstl_loop_bend40"],
        ["act_1"],
        ["act_one_bend20"],
        ["sstl2_bend20"],
        # what differs between the names tells them apart
        ["loop_rig_act_bend20", "loop_rig_sstl_bend20"],
    ],
)
def test_words_for_the_same_system_and_numbers_apart_are_no_question(stems: list[str], tmp_path: Path) -> None:
    assert "system" in name_pattern(stems).labels
    assert "system" not in {q.target for q in guess(written(tmp_path, stems)).questions}
