"""Zeros, factors and exchanges that a file says of its forces, and multiples in their names: asked unless they are said to be done."""

from __future__ import annotations

from pathlib import Path

import h5py
import numpy as np
import pytest
from header_table import T, X, Y, rows

from sstl_cli.importers.guess import Guess, guess
from sstl_cli.importers.guess_corrections import open_correction
from sstl_cli.importers.guess_names import said

HEAD = "Time (s),Fin (N),Fout (N)"
BOTH = {"tension_in_n", "tension_out_n"}


def found(folder: Path, head: str, *columns: object) -> Guess:
    path = folder / "act_bend60.csv"
    path.write_text(f"{head}\n" + rows(T, X, Y, *columns))
    return guess([path])


@pytest.mark.parametrize(
    ("line", "targets"),
    [
        ("# Zero offset Fin: 0.35 N (not removed)", {"tension_in_n"}),
        ("Nullpunkt Fout;0,35 N;nicht abgezogen", {"tension_out_n"}),
        ("# Scale factor: 2.0", BOTH),
        ("# Fin and Fout were swapped in this file", BOTH),
        ("# Zero offset Fin: 0.35 N (removed)", set()),
    ],
)
def test_a_line_above_the_table_asks_the_side_that_it_speaks_of(line: str, targets: set[str], tmp_path: Path) -> None:
    proposal = found(tmp_path, f"{line}\n{HEAD}")
    assert {q.target for q in proposal.questions} == targets
    assert all(line.strip("# ") in q.text for q in proposal.questions)


@pytest.mark.parametrize(
    "line",
    [
        "Tare: 0.35 N not subtracted",
        "offset_in = 0.35",
        "Gain;2;1",
        "ScaleFactor,2,2",
        "calibration not applied",
        "gain 2 to be applied",
        "force channels: 5 N/V",
        "WARNING: channels mislabelled",
        "no corrections applied",
        "Tara 0,35 N noch abzuziehen",
        "Facteur 2 non applique",
        "Sampling: 100 Hz; Gain: 2.0; Offset: 0.0",
        "Offset correction: off",
        "1 V = 5 N",
        "multiply Fin by 2",
        "zero of 0.35 N will be subtracted later",
    ],
)
def test_what_is_not_said_to_be_done_is_asked(line: str) -> None:
    assert open_correction(line)


@pytest.mark.parametrize(
    "line",
    [
        "Tare: 0.35 N subtracted",
        "Offset: 0.0 N",
        "Gain,1,1",
        "Offset: none",
        "Calibrated 2024-05-01",
        "Calibration: LC100 of 3 May 2024",
        "Vertical Scale,2.0",
        "Zeroed before the test",
        "time offset 0.35 s",
        "encoder zero at 12.5 mm",
        "Full scale: 50 N",
        "load cell of 50 N, 2 mV/V",
        "channels checked, not swapped",
        "No. of samples 500",
        "Sampling: 100 Hz; Gain: 1.0; Offset: 0.0",
        "Amplifier: HX711, gain 128",
        "Zero drift < 0.1 N",
    ],
)
def test_what_is_done_or_of_something_else_is_no_question(line: str) -> None:
    assert not open_correction(line)


@pytest.mark.parametrize(
    ("name", "value", "targets"),
    [
        ("Fin_offset (N)", 0.35, {"tension_in_n"}),
        ("gain", 2.0, BOTH),
        ("Fin_offset (N)", 0.0, set()),
        ("gain", 1.0, set()),
        ("encoder offset (mm)", 0.35, set()),
    ],
)
def test_a_column_beside_that_is_a_zero_or_a_gain_is_asked(name: str, value: float, targets: set[str], tmp_path: Path) -> None:
    proposal = found(tmp_path, f"{HEAD},{name}", np.full(len(T), value))
    assert {q.target for q in proposal.questions} == targets


@pytest.mark.parametrize(
    ("name", "told"),
    [
        ("Fin_x2 (N)", "x2"),
        ("Fin_X10", "X10"),
        ("Fin (x2) (N)", "x2"),
        ("Fin_2x", "2x"),
        ("2xFin", "2x"),
        ("10*Fin (N)", "10"),
        ("Fin/10", "Fin/10"),
        ("F_in_doubled", "doubled"),
        ("F_in_half (N)", "half"),
        ("F_in_times2", "times2"),
        ("F_in per strand", "per strand"),
        ("F_in_total", "total"),
        ("F_in_scaled", "scaled"),
    ],
)
def test_a_multiple_in_a_name_is_told(name: str, told: str) -> None:
    assert said(name).multiple == told


@pytest.mark.parametrize(
    "name", ["Fin_2 (N)", "F2", "F_x1", "Fx2 (N)", "T_in_2", "/Force/2", "Fin half bridge (N)", "F_in_1", "LC2_in", "F_in (x10 N)"]
)
def test_a_number_that_counts_channels_is_no_multiple(name: str) -> None:
    assert not said(name).multiple


def test_a_multiple_in_the_name_of_a_force_is_asked(tmp_path: Path) -> None:
    [question] = found(tmp_path, "Time (s),Fin_x2 (N),Fout (N)").questions
    assert question.target == "tension_in_n" and "'x2' in its name" in question.text


@pytest.mark.parametrize(
    ("place", "name", "value", "asks"), [("", "offset_in", 0.35, True), ("Fin_N", "scale_factor", 2.0, True), ("", "gain", 1.0, False)]
)
def test_a_single_number_and_an_attribute_of_a_dataset_that_correct_are_asked(
    place: str, name: str, value: float, asks: bool, tmp_path: Path
) -> None:
    path = tmp_path / "act_bend60.h5"
    with h5py.File(path, "w") as file:
        file.update({"time_s": T, "Fin_N": X, "Fout_N": Y})
        (file[place].attrs if place else file)[name] = value
    assert {q.target for q in guess([path]).questions} == ({"tension_in_n"} if asks else set())
