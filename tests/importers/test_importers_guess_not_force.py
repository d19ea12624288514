"""Columns that are not the force itself by their names or units, and a second cell where the tendon comes back: asked."""

from __future__ import annotations

import tomllib
from pathlib import Path

import pytest
from header_table import T, X, Y, rows

from sstl_cli.importers.guess import Guess, guess


def proposed(folder: Path, *names: str) -> Guess:
    path = folder / "act.csv"
    path.write_text("t (s)," + ",".join(names) + "\n" + rows(T, X, *[Y] * (len(names) - 1)), encoding="utf-8")
    return guess([path])


@pytest.mark.parametrize("unit", ["10^-3 N", "10⁻³ N", "1e-3 N", "x10^3 N", "N·10⁻³", "10**-3 N", "10^3 N"])
def test_a_power_of_ten_in_the_unit_is_no_newton(unit: str, tmp_path: Path) -> None:
    found = proposed(tmp_path, f"Fin [{unit}]", f"Fout [{unit}]")
    assert [q.target for q in found.questions] == ["tension_in_n", "tension_out_n"]
    assert all(f"{unit} is no force: define it in [units]" in q.text for q in found.questions)


@pytest.mark.parametrize(
    ("first", "second"),
    [
        ("Fin RMS (N)", "Fout RMS (N)"),
        ("dFin (N)", "dFout (N)"),
        ("ΔFin (N)", "ΔFout (N)"),
        ("Fin_dot (N)", "Fout_dot (N)"),
        ("Force entrée crête (N)", "Force sortie crête (N)"),
        ("Fin 10^-3 (N)", "Fout 10^-3 (N)"),
        ("输入力峰值 (N)", "输出力峰值 (N)"),
    ],
)
def test_what_is_made_of_a_force_is_asked(first: str, second: str, tmp_path: Path) -> None:
    found = proposed(tmp_path, first, second)
    assert [q.target for q in found.questions] == ["tension_in_n", "tension_out_n"]
    assert all("was this measured?" in q.text for q in found.questions)
    beside = proposed(tmp_path, "Fin (N)", "Fout (N)", first)
    assert bool(beside.questions) == ("RMS" in first) and tomllib.loads(beside.toml)["columns"]["tension_in_n"]["column"] == "Fin (N)"


@pytest.mark.parametrize("name", ["设定输入力 (N)", "設定入力 (N)", "설정 입력 장력 (N)"])
def test_a_set_force_is_no_input(name: str, tmp_path: Path) -> None:
    out = {"设": "输出力 (N)", "設": "出力 荷重 (N)", "설": "출력 장력 (N)"}[name[0]]
    found = proposed(tmp_path, name, out)
    assert "where is the input?" in found.questions[0].text


@pytest.mark.parametrize("names", [("T_prox_in (N)", "T_prox_out (N)", "T_tip (N)"), ("Proximal (N)", "Distal (N)", "Proximal return (N)")])
def test_a_cell_where_the_tendon_comes_back_is_named(names: tuple[str, ...], tmp_path: Path) -> None:
    [question] = proposed(tmp_path, *names).questions
    assert question.target == "tension_out_n" and "comes back" in question.text and any(repr(n) in question.text for n in names)


def test_a_force_in_the_middle_is_no_question(tmp_path: Path) -> None:
    assert not proposed(tmp_path, "F_in (N)", "F_mid (N)", "F_out (N)").questions


@pytest.mark.parametrize("unit", ["(VDC)", "[V DC]", "_Vdc", "(V(DC))"])
def test_volts_of_a_direct_voltage_are_no_newtons(unit: str, tmp_path: Path) -> None:
    questions = proposed(tmp_path, f"Fin {unit}", f"Fout {unit}").questions
    assert [q.target for q in questions] == ["tension_in_n", "tension_out_n"]
    assert all('unit = "V"' in q.text and "gain = N per V" in q.text for q in questions)


@pytest.mark.parametrize("head", ["Time (s),Fin (mV/V),Fout (mV/V)\n", "Time,Fin,Fout\ns,mV/V,mV/V\n"])
def test_a_ratio_of_volts_needs_a_unit_of_its_own(head: str, tmp_path: Path) -> None:
    (tmp_path / "act.csv").write_text(head + rows(T, X, Y))
    questions = guess([tmp_path / "act.csv"]).questions
    assert all('unit = "mV/V"' in q.text and "define it in [units]" in q.text for q in questions) and len(questions) == 2
