"""Cells that are no numbers, and tables that are none: what a proposal says of them."""

from __future__ import annotations

import tomllib
from pathlib import Path

import numpy as np
import pytest
from header_table import T, X, Y, rows
from proposals import proposed

from sstl_cli.core.errors import SstlError
from sstl_cli.importers.guess import guess
from sstl_cli.importers.guess_names import said
from sstl_cli.importers.guess_roles import guess_roles
from sstl_cli.importers.mapping import mapping_of
from sstl_cli.steps.import_ import run

HEAD = "Time (s),Fin (N),Fout (N)\n"


def refused(path: Path, text: str | bytes) -> SstlError:
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    with pytest.raises(SstlError) as raised:
        guess([path])
    return raised.value


def test_a_word_among_the_readings_of_a_tension_is_named_with_its_line(tmp_path: Path) -> None:
    lines = rows(T, X, Y).splitlines()
    lines[50] = f"{T[50]:.3f},{X[50]:.3f},OVLD"
    error = refused(tmp_path / "a.csv", HEAD + "\n".join(lines) + "\n")
    assert error.code == "E328" and "line 52: column 'Fout (N)' holds 'OVLD'" in error.line()


def test_a_word_in_another_column_leaves_it_out_with_a_reason(tmp_path: Path) -> None:
    lines = rows(T, X, Y, 30 * X).splitlines()
    lines[50] = lines[50].rpartition(",")[0] + ",ERR"
    (tmp_path / "a.csv").write_text(HEAD.replace("\n", ",Motor (mm)\n") + "\n".join(lines) + "\n")
    found = guess([tmp_path / "a.csv"])
    assert any("'Motor (mm)' is left out" in r and "line 52" in r and "'ERR'" in r for r in found.reasons)


def test_one_row_a_value_is_told_by_compound_names(tmp_path: Path) -> None:
    lines = (f'"{n}";{v:.4f};1;{1000 * t:.3f}\n' for i, t in enumerate(T) for n, v in (("F_ein", X[i]), ("F_aus", Y[i])))
    error = refused(tmp_path / "a.csv", '"VarName";"VarValue";"Validity";"Time_ms"\n' + "".join(lines))
    assert "pivot it first" in error.fix and "'VarName' says which" in error.what


def test_a_blank_between_thousands_is_told_where_blanks_cut_columns(tmp_path: Path) -> None:
    # two recordings behind one another, most of whose times are over a thousand
    t, x, y = np.arange(2 * len(T)) * 0.004, np.tile(X, 2), np.tile(Y, 2)
    lines = (f"{1000 * t:.0f} {x:,.1f} {y:,.1f}\n" for t, x, y in zip(t, 100 * x, 100 * y, strict=True))
    body = "".join(lines).replace(",", "\u00a0").replace(".", ",")
    error = refused(tmp_path / "a.csv", ("Temps_ms Entrée_mN Sortie_mN\n" + body).encode("cp1252"))
    assert "without marks between thousands" in error.fix and "\\x" not in error.line()


def test_a_typographic_minus_is_a_minus(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    place = X - X[0] - 1.0
    path.write_text((HEAD.replace("\n", ",Motor position (mm)\n") + rows(T, X, Y, place)).replace(",-", ",\u2212"), encoding="utf-8")
    columns = tomllib.loads(guess([path]).toml)["columns"]
    assert columns["position_in_mm"] == {"column": "Motor position (mm)", "unit": "mm"}
    [one] = run([path], mapping_of({"columns": columns, "constants": {"system": "act"}}, "m.toml")).runs
    assert one.position_in_mm is not None and one.position_in_mm == pytest.approx(place, abs=1e-3)


@pytest.mark.parametrize("many", [10, 4])
def test_a_rounded_clock_is_asked_with_its_rate(many: int, tmp_path: Path) -> None:
    clock = np.floor(np.arange(len(T)) / many) * 0.1
    (tmp_path / "a.csv").write_text(HEAD + rows(clock, X, Y))
    found = guess([tmp_path / "a.csv"])
    assert tomllib.loads(found.toml)["columns"]["time_s"] == {"rate_hz": 10 * many}
    assert any(q.target == "time_s" and "is rounded" in q.text for q in found.questions)


def test_rows_written_again_are_no_rounded_clock(tmp_path: Path) -> None:
    again = [np.repeat(v[:100], 4) for v in (0.1 * np.arange(len(T)), X, Y)]
    (tmp_path / "a.csv").write_text(HEAD + rows(*again))
    assert 'time_s = { column = "Time (s)", unit = "s" }\n' in guess([tmp_path / "a.csv"]).toml


def test_a_position_is_no_tension_beside_two_that_may_be() -> None:
    # it moves with the first more than the second does
    data = {"a": X, "b": Y + np.random.default_rng(2).normal(0, 1, len(X)), "motor position": 3.0 * X + 0.01 * Y}
    roles = guess_roles([said(n) for n in data], data)
    assert {roles.first[0].name, roles.second[0].name} == {"a", "b"}


def test_a_clock_of_the_position_is_no_position(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text("Time (s),Fin (N),Fout (N),Encoder (mm),Encoder time (s),Encoder@time (s)\n" + rows(T, X, Y, X, T, T))
    assert 'unit = "s" }' not in "".join(x for x in guess([tmp_path / "a.csv"]).toml.splitlines() if "position_in_mm" in x)


@pytest.mark.parametrize("sep", [";", ","])
def test_numbers_with_both_marks_tell_which_is_the_decimal_one(sep: str, tmp_path: Path) -> None:
    # at the end of the sample all readings are in thousands; 980 ms at its beginning shows what 2,990 ms is
    lines = (sep.join(f'"{c}"' for c in (f"{10 * i:,}", f"{900 + 10 * i:,.1f}", f"{800 + 9 * i:,.1f}")) for i in range(300))
    path = tmp_path / "act_bend30.csv"
    _, found = proposed(path, sep.join(("Time (ms)", "Fin (mN)", "Fout (mN)")) + "\n" + "\n".join(lines) + "\n")
    [log] = run([path], mapping_of(tomllib.loads(found.toml), "test")).runs
    assert (
        "thousands" not in found.toml and np.allclose(log.time_s, 0.01 * np.arange(300)) and np.allclose(log.tension_in_n, 0.9 + log.time_s)
    )


def test_a_table_behind_a_line_of_words_is_to_be_split_off(tmp_path: Path) -> None:
    error = refused(tmp_path / "a.csv", HEAD + rows(T, X, Y) + "\nTest: sstl\n" + HEAD.replace("Fout (N)", "Fout") + rows(T, X, Y))
    assert error.code == "E327" and "another table begins, split the file there" in error.fix
