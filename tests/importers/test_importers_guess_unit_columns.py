"""Columns that hold the unit of the readings beside them: read, and asked where the name or the header says another one."""

from __future__ import annotations

import tomllib
from pathlib import Path

import pytest
from header_table import N, T, X, Y, rows

from sstl_cli.importers.guess import Guess, guess


def found(folder: Path, text: str, name: str = "act_bend60.csv") -> Guess:
    path = folder / name
    path.write_text(text)
    return guess([path])


def unit(proposal: Guess, target: str) -> str:
    return str(tomllib.loads(proposal.toml)["columns"][target]["unit"])


@pytest.mark.parametrize("head", ["Fin,Unit,Fout,Unit", "Force In,UnitIn,Force Out,UnitOut", "Kraft ein,Einheit ein,Kraft aus,Einheit aus"])
@pytest.mark.parametrize("said", ["gf", "lbF", "N"])
def test_units_in_columns_of_their_own_are_read(head: str, said: str, tmp_path: Path) -> None:
    proposal = found(tmp_path, f"Time (s),{head}\n" + rows(T, X, said, Y, said))
    assert not proposal.questions
    assert {unit(proposal, t) for t in ("tension_in_n", "tension_out_n")} == {said.lower() if said == "lbF" else said}


@pytest.mark.parametrize("columns", ["Fin,Fout,Unit", "Unit,Fin,Fout"])
def test_the_only_column_of_units_is_of_all_forces(columns: str, tmp_path: Path) -> None:
    cells = [{"Fin": X, "Fout": Y, "Unit": "gf"}[c] for c in columns.split(",")]
    proposal = found(tmp_path, f"Time (s),{columns}\n" + rows(T, *cells))
    assert unit(proposal, "tension_in_n") == unit(proposal, "tension_out_n") == "gf"


def test_a_column_of_units_against_the_name_is_asked(tmp_path: Path) -> None:
    proposal = found(tmp_path, "Time (s),Force In (N),UnitIn,Force Out (N),UnitOut\n" + rows(T, X, "lbf", Y, "N"))
    [question] = proposal.questions
    assert question.target == "tension_in_n" and "its name says N, the file lbf" in question.text


def test_a_column_of_units_against_the_row_of_units_is_asked(tmp_path: Path) -> None:
    proposal = found(tmp_path, "Time,Fin,UnitIn,Fout,UnitOut\ns,N,,N,\n" + rows(T, X, "lbf", Y, "N"))
    [question] = proposal.questions
    assert question.target == "tension_in_n" and "'UnitIn' says lbf, the header N" in question.text


def test_a_unit_that_changes_is_asked(tmp_path: Path) -> None:
    lines = [f"{T[i]:.3f},{X[i]:.3f},{'N' if i < N // 2 else 'lbf'},{Y[i]:.3f},N\n" for i in range(N)]
    proposal = found(tmp_path, "Time (s),Fin,UnitIn,Fout,UnitOut\n" + "".join(lines))
    [question] = proposal.questions
    assert question.target == "tension_in_n" and "N and lbf" in question.text


@pytest.mark.parametrize("cell", ["rig A", "degC", "unit 3"])
def test_a_column_that_holds_no_units_of_force_says_nothing(cell: str, tmp_path: Path) -> None:
    proposal = found(tmp_path, "Time (s),Fin (N),Unit,Fout (N)\n" + rows(T, X, cell, Y))
    assert not proposal.questions and unit(proposal, "tension_in_n") == "N"


@pytest.mark.parametrize("line", ["# Units: lb", "Force unit = lbf", "% Unit: lbf"])
def test_a_line_above_the_table_proposes_the_unit_of_forces_that_state_none(line: str, tmp_path: Path) -> None:
    proposal = found(tmp_path, f"{line}\nTime (s),Fin,Fout\n" + rows(T, X, Y))
    assert unit(proposal, "tension_in_n") == unit(proposal, "tension_out_n") == ("lb" if line.endswith("lb") else "lbf")
    assert all("a line above the table says" in q.text and "no unit is stated" not in q.text for q in proposal.questions)
    assert {q.target for q in proposal.questions} == {"tension_in_n", "tension_out_n"}


def test_such_a_line_is_of_columns_that_name_nothing_but_their_side_too(tmp_path: Path) -> None:
    proposal = found(tmp_path, "# units: lbf\nTime (s),proximal,distal,temperature\n" + rows(T, X, Y, X))
    assert unit(proposal, "tension_in_n") == unit(proposal, "tension_out_n") == "lbf"


@pytest.mark.parametrize(
    "line", ["# Units: N", "# Units: mm", "# unit 3, bench 2", "# time in ms", "# Force unit: lbf (converted to N)", "# Range: 50 lbf"]
)
def test_such_a_line_does_not_touch_forces_that_state_that_unit(line: str, tmp_path: Path) -> None:
    proposal = found(tmp_path, f"{line}\nTime (s),Fin (N),Fout (N)\n" + rows(T, X, Y))
    assert not proposal.questions and unit(proposal, "tension_in_n") == "N"


@pytest.mark.parametrize(
    ("line", "named"),
    [
        ("# Units: lbf", "lbf"),
        ("Force Units;mN", "mN"),
        ("Einheit: mN", "mN"),
        ("# note: all forces converted to pounds by a script", "lbf"),
        ("# values in V", "V"),
    ],
)
def test_a_line_that_states_another_unit_than_the_names_is_asked_with_both(line: str, named: str, tmp_path: Path) -> None:
    proposal = found(tmp_path, f"{line}\nTime (s),Fin (N),Fout (N)\n" + rows(T, X, Y))
    assert {q.target for q in proposal.questions} == {"tension_in_n", "tension_out_n"}
    assert all(f"its column says N, a line above the table {named}" in q.text for q in proposal.questions)


def test_a_line_of_one_side_against_its_name_asks_that_side(tmp_path: Path) -> None:
    proposal = found(tmp_path, "# Input unit: lbf\n# Supply in V\nTime (s),Fin (N),Fout (N),Supply (V)\n" + rows(T, X, Y, T))
    assert {q.target for q in proposal.questions} == {"tension_in_n"}
