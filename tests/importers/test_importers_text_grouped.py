"""Numbers with marks between thousands: read where a cell shows which mark is which, else asked."""

from __future__ import annotations

import tomllib
from pathlib import Path

import numpy as np
import pytest
from header_table import T, X, Y, rows

from sstl_cli.core.errors import SstlError
from sstl_cli.importers.guess import guess
from sstl_cli.importers.mapping import mapping_of
from sstl_cli.steps.import_ import run

BOTH = {"tension_in_n", "tension_out_n"}
# from zero to 2.1 s, and tensions from below to far above a thousand mN
MS, IN, OUT = 1000 * T, 1000 * X, 1000 * Y


def grouped(values: np.ndarray, mark: str, decimal: str, digits: int = 1) -> list[str]:
    return [f"{v:,.{digits}f}".replace(",", "#").replace(".", decimal).replace("#", mark) for v in values]


def written(path: Path, head: str, *columns: list[str], by: str = ";", encoding: str = "utf-8") -> Path:
    path.write_text(head + "\n" + "".join(by.join(row) + "\n" for row in zip(*columns, strict=True)), encoding)
    return path


def read_as(path: Path, *, but: str = "system") -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    found = guess([path])
    assert {q.target for q in found.questions} == {but}
    columns = tomllib.loads(found.toml)["columns"]
    [one] = run([path], mapping_of({"columns": columns, "constants": {"system": "act"}}, "m.toml")).runs
    return one.time_s, one.tension_in_n, one.tension_out_n


@pytest.mark.parametrize(
    ("mark", "decimal", "by", "encoding"),
    [
        (".", ",", ";", "utf-8"),
        (",", ".", ";", "utf-8"),
        (",", ".", "\t", "utf-8"),
        (" ", ",", ";", "utf-8"),
        ("'", ".", ";", "utf-8"),
        ("'", ".", ",", "utf-8"),
        ("\u2019", ".", ";", "utf-8"),
        ("\u2019", ".", ";", "cp1252"),
        ("\u00a0", ",", ";", "cp1252"),
        ("\u00a0", ",", "\t", "utf-8"),
        ("\u202f", ",", ";", "utf-8"),
        ("\u2009", ",", "\t", "utf-8"),
        (".", ",", "\t", "utf-16"),
    ],
)
def test_thousands_are_read_where_a_cell_shows_the_mark(mark: str, decimal: str, by: str, encoding: str, tmp_path: Path) -> None:
    columns = (grouped(v, mark, decimal) for v in (MS, IN, OUT))
    path = written(tmp_path / "a.csv", by.join(("Time (ms)", "Fin (mN)", "Fout (mN)")), *columns, by=by, encoding=encoding)
    time, first, second = read_as(path)
    assert time == pytest.approx(T - T[0], abs=1e-3) or time == pytest.approx(T, abs=1e-3)
    assert first == pytest.approx(X, abs=1e-4) and second == pytest.approx(Y, abs=1e-4)


def test_a_comma_in_quotes_is_no_delimiter(tmp_path: Path) -> None:
    columns = ([f'"{c}"' for c in grouped(v, ",", ".")] for v in (MS, IN, OUT))
    _, first, second = read_as(written(tmp_path / "a.csv", "Time (ms),Fin (mN),Fout (mN)", *columns, by=","))
    assert first == pytest.approx(X, abs=1e-4) and second == pytest.approx(Y, abs=1e-4)


def test_blanks_in_whole_numbers_do_not_cut_a_table_at_tabs(tmp_path: Path) -> None:
    columns = (grouped(v, " ", ",", 0) for v in (MS, IN, OUT))
    path = written(tmp_path / "a.csv", "Time (ms)\tFin (mN)\tFout (mN)", *columns, by="\t")
    [one] = run(
        [path], mapping_of({"columns": tomllib.loads(guess([path]).toml)["columns"], "constants": {"system": "act"}}, "m.toml")
    ).runs
    assert one.tension_in_n == pytest.approx(X, abs=1e-3)


def test_two_marks_of_one_kind_are_of_thousands(tmp_path: Path) -> None:
    columns = (grouped(5e6 + 1e6 * T, ",", ".", 0), grouped(X, ",", ".", 4), grouped(Y, ",", ".", 4))
    _, first, _ = read_as(written(tmp_path / "a.csv", "Time (us);Fin (N);Fout (N)", *columns))
    assert first == pytest.approx(X, abs=1e-4)


def test_a_lone_mark_is_refused_beside_the_other_as_decimal_sign(tmp_path: Path) -> None:
    """1,234 of a column without smaller numbers is left as it is also where another column shows that commas stand between thousands."""
    columns = (grouped(1000 + np.arange(len(T)), ",", ".", 0), grouped(IN, ",", "."), grouped(OUT, ",", "."))
    with pytest.raises(SstlError, match=r"E328.*'Time \(ms\)' holds '1,\d\d\d'.*without marks between thousands"):
        guess([written(tmp_path / "a.csv", "Time (ms);Fin (mN);Fout (mN)", *columns)])


def asked(path: Path) -> dict[str, str]:
    return {q.target: q.text for q in guess([path]).questions}


def test_a_lone_mark_beside_whole_numbers_is_asked_in_any_unit(tmp_path: Path) -> None:
    # a decimal comma in the clock: 1,003 would be read as about one newton
    clock = [f"{t:.2f}".replace(".", ",") for t in T]
    first = grouped(990 + np.arange(len(T)) % 14, ",", ".", 0)
    found = asked(written(tmp_path / "a.csv", "Time (s);Fin (N);Fout (N)", clock, first, grouped(Y, ".", ",", 2)))
    assert "'1,000' beside '990': is it 1000?" in found["tension_in_n"] and "tension_out_n" not in found


def test_three_digits_throughout_are_asked_where_no_cell_of_the_file_shows_a_decimal_mark(tmp_path: Path) -> None:
    clock = grouped(1000 + 10 * np.arange(len(T)), ",", ".", 0)
    columns = (grouped(1000 + 40 * X, ",", ".", 0), grouped(1000 + 40 * Y, ",", ".", 0))
    found = asked(written(tmp_path / "a.csv", "Time (ms);Fin (N);Fout (N)", clock, *columns))
    assert all("every mark has three digits behind it" in found[t] for t in BOTH)
    # 0,010 is no number with thousands: the mark is the decimal one in this file
    decimal = [f"{0.01 * k:.3f}".replace(".", ",") for k in range(len(T))]
    assert not BOTH & set(asked(written(tmp_path / "b.csv", "Time (s);Fin (N);Fout (N)", decimal, *columns)))
    # no tendon holds 10 kN
    columns = (grouped(10_000 + 40 * X, ",", ".", 0), grouped(10_000 + 40 * Y, ",", ".", 0))
    assert not BOTH & set(asked(written(tmp_path / "c.csv", "Time (ms);Fin (N);Fout (N)", clock, *columns)))


@pytest.mark.parametrize("row", ["double,float,single", "[DateTime],[DBL],[SGL]", "datetime64[ns],f8,f4"])
@pytest.mark.parametrize("below", [True, False])
def test_a_row_of_types_is_no_data_and_no_names(row: str, below: bool, tmp_path: Path) -> None:
    head = ["Time,Fin,Fout", *(["s,N,N", row] if below else [row, "s,N,N"])]
    (tmp_path / "a.csv").write_text("\n".join(head) + "\n" + rows(T, X, Y))
    columns = tomllib.loads(guess([tmp_path / "a.csv"]).toml)["columns"]
    assert columns["tension_in_n"] == {"column": "Fin", "unit": "N"} and columns["time_s"] == {"column": "Time", "unit": "s"}
