"""Bends and systems that only a letter, a count of passes or a constant column tells: proposed, and asked."""

from __future__ import annotations

import time
import tomllib
from pathlib import Path

import pytest
from header_table import T, X, Y, rows

from sstl_cli.importers.guess import Guess, guess

HEAD = "Time (s),Fin (N),Fout (N)"


def with_line(folder: Path, line: str, name: str = "log.csv") -> Guess:
    (folder / name).write_text(f"{line}\n{HEAD}\n" + rows(T, X, Y), encoding="utf-8")
    return guess([folder / name])


def with_column(folder: Path, name: str, *values: str) -> Guess:
    size = len(T) // len(values)
    held = [values[min(i // size, len(values) - 1)] for i in range(len(T))]
    lines = rows(T, X, Y).splitlines()
    text = "".join(f"{line},{v}\n" for line, v in zip(lines, held, strict=True))
    (folder / "log.csv").write_text(f"{HEAD},{name}\n{text}", encoding="utf-8")
    return guess([folder / "log.csv"])


def proposed(found: Guess, target: str) -> object:
    """Return what a target is proposed to be, which must be asked."""
    toml = tomllib.loads(found.toml)
    assert target in {q.target for q in found.questions}
    return {**toml["columns"], **toml["constants"]}[target]


@pytest.mark.parametrize(
    ("line", "label"),
    [
        ("# theta = 20 deg", "20"),
        ("theta = 20 deg", "20"),
        ("θ: 20°", "20"),
        ("phi (deg): 45", "45"),
        ("R = 50 mm", "50"),
        ("Radius,50 mm", ""),
        ("Radius (mm),50", "50"),
        ("# Biegeradius: 50 mm", "50"),
        ("# Krümmungsradius = 50 mm", "50"),
        ("# Curvature 1/R = 0.02 1/mm", "0.02"),
        ("# Wrap angle: 180°", "180"),
        ("# Angle: 45 deg", "45"),
        ("# Bending: none", "none"),
        ("# double pass, 30 deg", "30"),
        ("# 30 deg sstl", "30"),
        ("# theta: 20", "20"),
        # of something else
        ("# Motor angle: 20 deg", ""),
        ("# phase 90 deg", ""),
        ("# Temperature: 23 °C", ""),
        ("# Position 52° N", ""),
        ("# R2 = 0.98", ""),
        ("# FIR = 50 mm", ""),
    ],
)
def test_a_bend_by_its_letter_is_asked(line: str, label: str, tmp_path: Path) -> None:
    found = with_line(tmp_path, line)
    assert proposed(found, "config_id") == label if label else "config_id" not in found.toml


def test_a_radius_is_none_beside_a_bend_in_the_name_and_an_angle_is_asked(tmp_path: Path) -> None:
    assert {q.target for q in with_line(tmp_path, "# R = 8.5 mm", "act_bend60.csv").questions} == set()
    found = with_line(tmp_path, "# theta = 20 deg", "act_bend60.csv")
    assert any("which tells the configuration" in q.text for q in found.questions)


@pytest.mark.parametrize(
    ("line", "system"),
    [
        ("# Configuration: act", "act"),
        ("Configuration: act", "act"),
        ("# Passes: 2", "sstl"),
        ("n_pass = 1", "act"),
        ('"Number of passes","2"', "sstl"),
        ("# Two-pass test", "sstl"),
        ("# pass: double", "sstl"),
    ],
)
def test_a_system_by_its_passes_is_proposed(line: str, system: str, tmp_path: Path) -> None:
    found = with_line(tmp_path, line)
    assert proposed(found, "system") == system and f"the file says {system} itself" in found.toml


@pytest.mark.parametrize("line", ["# Passes: 12", "# low-pass: 2 Hz", "# pass rate: 2.5"])
def test_what_counts_no_passes_of_a_tendon_is_no_system(line: str, tmp_path: Path) -> None:
    assert "the file says" not in with_line(tmp_path, line).toml


@pytest.mark.parametrize("name", ["angle_deg", "theta", "theta_deg", "R_mm", "radius_mm", "Winkel [deg]", "wrap"])
def test_a_constant_angle_or_radius_is_asked_for_the_bend(name: str, tmp_path: Path) -> None:
    assert proposed(with_column(tmp_path, name, "30"), "config_id") == name
    assert "config_id" not in with_column(tmp_path, name, *(str(v) for v in range(20))).toml


def test_an_angle_beside_a_column_of_the_bend_raises_no_question(tmp_path: Path) -> None:
    found = with_column(tmp_path, "bend_deg,R_mm", "30,50")
    assert {q.target for q in found.questions} == {"system"} and 'config_id = "bend_deg"' in found.toml


@pytest.mark.parametrize(
    ("name", "value", "system"), [("passes", "2", "sstl"), ("n_pass", "1", "act"), ("pass", "double", "sstl"), ("config", "act", "act")]
)
def test_a_constant_column_that_says_the_system_is_asked(name: str, value: str, system: str, tmp_path: Path) -> None:
    found = with_column(tmp_path, name, value)
    assert proposed(found, "system") == (name if name == "config" else system)


def test_a_word_that_stands_throughout_a_column_tells_the_bend(tmp_path: Path) -> None:
    assert proposed(with_column(tmp_path, "test", "bend90"), "config_id") == "90"


def test_passes_that_change_within_a_file_are_asked(tmp_path: Path) -> None:
    found = with_column(tmp_path, "passes", "1", "2")
    assert "both act and sstl" in next(q.text for q in found.questions if q.target == "system")


@pytest.mark.parametrize("filled", [" ", "-", "bend ", "\t", '"', "1 "])
def test_a_long_line_above_the_table_takes_no_time(filled: str, tmp_path: Path) -> None:
    before = time.perf_counter()
    with_line(tmp_path, "# rig 1\n#" + filled * (500_000 // len(filled)))
    assert time.perf_counter() - before < 10.0
