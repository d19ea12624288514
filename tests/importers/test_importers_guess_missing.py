"""Codes for missing readings, serial numbers and references in other languages."""

from __future__ import annotations

import tomllib
from pathlib import Path

import numpy as np
import pytest
from header_table import N, T, X, Y, rows

from sstl_cli.importers.guess import Guess, guess
from sstl_cli.importers.guess_names import said


def proposed(folder: Path, head: str, *cells: object) -> Guess:
    path = folder / "act_bend60.csv"
    path.write_text(head + "\n" + rows(T, *cells))
    return guess([path])


@pytest.mark.parametrize("code", [-9999.0, 99999.0, -999.0])
def test_a_code_for_missing_readings_is_asked_and_is_no_sign(code: float, tmp_path: Path) -> None:
    held = np.where(np.isin(np.arange(N), (40, 80, 81)), code, X)
    [question] = proposed(tmp_path, "Time (s),Fin (N),Fout (N)", held, Y).questions
    assert question.target == "tension_in_n" and f"3 samples hold {code:g}" in question.text
    assert "sign = -1" not in question.text and "unit right" not in question.text


def test_clipped_readings_and_real_negative_ones_are_no_codes(tmp_path: Path) -> None:
    clipped = np.minimum(X, float(round(np.quantile(X, 0.9))))
    assert not proposed(tmp_path, "Time (s),Fin (N),Fout (N)", clipped, Y).questions
    [question] = proposed(tmp_path, "Time (s),Fin (N),Fout (N)", -X, Y).questions
    assert "sign = -1" in question.text and "missing" not in question.text


def test_a_serial_number_counts_nothing(tmp_path: Path) -> None:
    found = proposed(tmp_path, "Time (s),CH1: S/N 712345 Input (lbf),CH2: S/N 712346 Output (lbf)", X, Y)
    assert not found.questions and tomllib.loads(found.toml)["columns"]["tension_out_n"]["unit"] == "lbf"
    assert said("Load cell SN:A123 in (N)").side == "in" and said("S/N ratio").quantity == "index"


@pytest.mark.parametrize(
    "names",
    [
        ("Tijd (s)", "Kracht ingang gewenst (N)", "Kracht ingang (N)", "Kracht uitgang (N)"),
        ("Tempo (s)", "Forza ingresso desiderata (N)", "Forza motore (N)", "Forza uscita (N)"),
        ("Tempo (s)", "Forza richiesta (N)", "Forza ingresso (N)", "Forza uscita (N)"),
        ("Tiempo (s)", "Fuerza entrada objetivo (N)", "Fuerza entrada (N)", "Fuerza salida (N)"),
        ("Temps (s)", "Force amont demandée (N)", "Force moteur (N)", "Force aval (N)"),
    ],
)
def test_a_reference_in_other_languages_is_no_second_input(names: tuple[str, ...], tmp_path: Path) -> None:
    found = proposed(tmp_path, ",".join(names), X + 0.5, X, Y)
    columns = tomllib.loads(found.toml)["columns"]
    assert not found.questions
    assert [columns[t]["column"] for t in ("tension_ref_n", "tension_in_n", "tension_out_n")] == list(names[1:])
