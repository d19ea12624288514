"""Which columns in mm are the position of the input, which the lead of the screw, and which are asked or left out."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from header_table import N, T, X, Y, rows
from test_importers_guess import answered

from sstl_cli.importers.guess import Guess, guess
from sstl_cli.steps.import_ import run

STILL = np.full(N, 40.0)
HEAD = "Time (s),Fin (N),Fout (N),"


def proposed(folder: Path, head: str, *columns: object) -> tuple[dict[str, str], Guess]:
    """Return the lines of the proposal by what they give."""
    path = folder / "act.csv"
    path.write_text(head + "\n" + rows(T, X, Y, *columns))
    found = guess([path])
    return {line.split(" = ")[0]: line for line in found.toml.splitlines() if " = " in line}, found


@pytest.mark.parametrize("name", ["Bend radius (mm)", "Sheath length [mm]", "Wire diameter (mm)", "Motor position (mm)", "Abstand [mm]"])
def test_a_length_that_is_constant_is_no_position(name: str, tmp_path: Path) -> None:
    lines, found = proposed(tmp_path, HEAD + name, STILL)
    assert not [x for x in lines if "position_in_mm" in x or "lead_mm" in x] and not found.questions


@pytest.mark.parametrize(
    "name",
    [
        "Position (mm)",
        "Stroke (mm)",
        "Travel [mm]",
        "Motor (mm)",
        "Motorweg [mm]",
        "Weg [mm]",
        "Déplacement (mm)",
        "Carrera (mm)",
        "corsa (mm)",
        "变位[mm]",
        "位置[mm]",
        "ストローク[mm]",
        "위치(mm)",
        "Slider (mm)",
        "pos_mm",
    ],
)
def test_a_word_says_position(name: str, tmp_path: Path) -> None:
    lines, found = proposed(tmp_path, HEAD + name, 2 * X)
    assert lines["position_in_mm"] == f'position_in_mm = {{ column = "{name}", unit = "mm" }}' and not found.questions


@pytest.mark.parametrize("name", ["x (mm)", "Sheath length [mm]", "Bend radius (mm)", "Motor gap (mm)"])
def test_a_length_that_moves_is_asked(name: str, tmp_path: Path) -> None:
    _, found = proposed(tmp_path, HEAD + name, 2 * X)
    assert [q.target for q in found.questions] == ["position_in_mm"] and "another length" in found.questions[0].text


def test_of_several_lengths_the_one_that_says_position_is_taken(tmp_path: Path) -> None:
    lines, found = proposed(tmp_path, HEAD + "Gap (mm),Slider (mm)", 1 + 0.01 * X, X)
    assert '"Slider (mm)"' in lines["position_in_mm"] and "Gap" not in found.toml and not found.questions


@pytest.mark.parametrize(
    ("name", "question"),
    [
        ("Screw (mm)", ""),
        ("Leadscrew_mm", ""),
        ("Lead screw position [mm]", ""),
        ("Spindel / mm", ""),
        ("Screw diameter (mm)", "another length of it"),
        ("Lead", "in mm?"),
    ],
)
def test_a_constant_named_after_a_lead_screw_is_the_lead(name: str, question: str, tmp_path: Path) -> None:
    lines, found = proposed(tmp_path, HEAD + name, STILL)
    assert lines["lead_mm"].startswith(f'lead_mm = "{name}"') and question in lines["lead_mm"]
    assert len(found.questions) == bool(question) and "position_in_mm" not in lines
    [one] = run([tmp_path / "act.csv"], answered(found.toml.replace("(?)", ""), tmp_path)).runs
    assert one.lead_mm == 40.0 and one.position_in_mm is None


def test_a_row_of_units_says_that_the_lead_is_in_mm(tmp_path: Path) -> None:
    for unit, told in (("mm", True), ("cm", False)):
        lines, found = proposed(tmp_path, f"Time,Fin,Fout,Screw\ns,N,N,{unit}", STILL)
        assert ("lead_mm" in lines) == told and not found.questions


def test_a_screw_that_moves_is_no_lead(tmp_path: Path) -> None:
    lines, found = proposed(tmp_path, HEAD + "Screw (mm)", 2 * X)
    assert "lead_mm" not in lines and [q.target for q in found.questions] == ["position_in_mm"]
    lines, found = proposed(tmp_path, HEAD + "Screw", "M8")
    assert "lead_mm" not in lines


def test_a_position_that_rests_in_one_of_several_files_is_no_question(tmp_path: Path) -> None:
    files = [tmp_path / "act_bend20.csv", tmp_path / "act_bend40.csv"]
    for path, position in zip(files, (X, STILL), strict=True):
        path.write_text(HEAD + "Position (mm)\n" + rows(T, X, Y, position))
    found = guess(files)
    assert "\nposition_in_mm" in found.toml and not found.questions


@pytest.mark.parametrize("trial", [{}, {"trial": np.full(N, 3)}])
@pytest.mark.parametrize(("screw", "named"), [(np.array([40.0]), True), (STILL, True), (STILL[:9], False), (2 * X, False)])
def test_a_lead_may_stand_once_in_a_file_of_arrays(screw: np.ndarray, named: bool, trial: dict[str, np.ndarray], tmp_path: Path) -> None:
    path = tmp_path / "act.npz"
    np.savez(path, time_s=T, Fin_N=X, Fout_N=Y, screw_mm=screw, **trial)
    found = guess([path])
    assert ('lead_mm = "screw_mm"' in found.toml) == named and ('run_id = "trial"' in found.toml) == bool(trial)
    [one] = run([path], answered(found.toml.replace("(?)", ""), tmp_path)).runs
    assert one.lead_mm == (40.0 if named else None) and len(one) == N
