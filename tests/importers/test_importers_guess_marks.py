"""Marks between thousands, units and clocks that a file states in two ways: asked, never taken."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from header_table import T, X, Y

from sstl_cli.core.errors import SstlError
from sstl_cli.importers.guess import guess


def questions(path: Path, text: str) -> dict[str, str]:
    path.write_text(text)
    return {q.target: q.text for q in guess([path]).questions}


def table(head: str, *columns: list[str], separator: str = ";") -> str:
    return head + "\n" + "".join(separator.join(row) + "\n" for row in zip(*columns, strict=True))


def plain(values: np.ndarray, digits: int = 3) -> list[str]:
    return [f"{v:.{digits}f}" for v in values]


def grouped(values: np.ndarray, mark: str) -> list[str]:
    return [f"{v:,.0f}".replace(",", mark) for v in values]


MS = [f"{v:.0f}" for v in 1000 * T]
BOTH = {"tension_in_n", "tension_out_n"}


@pytest.mark.parametrize("mark", [".", ","])
@pytest.mark.parametrize("unit", ["mN", "g", "counts"])
def test_three_digits_behind_every_mark_are_asked_in_small_units(unit: str, mark: str, tmp_path: Path) -> None:
    columns = (grouped(1000 * X, mark), grouped(1000 * Y, mark))
    asked = questions(tmp_path / "a.csv", table(f"Time (ms);Fin ({unit});Fout ({unit})", MS, *columns))
    assert asked.keys() >= BOTH and all("three digits behind it" in asked[t] and "marks between thousands" in asked[t] for t in BOTH)


def test_the_other_mark_in_another_column_tells_that_one_is_between_thousands(tmp_path: Path) -> None:
    place = [f"{v:.2f}".replace(".", ",") for v in 0.01 * X]
    text = table("Zeit [ms];Kraft ein [N];Kraft aus [N];Weg [mm]", MS, grouped(1000 * X, "."), grouped(1000 * Y, "."), place)
    asked = questions(tmp_path / "a.csv", text)
    assert asked.keys() >= BOTH and all("in the same file" in asked[t] for t in BOTH)


def test_newtons_with_three_digits_are_what_they_say(tmp_path: Path) -> None:
    assert not BOTH & set(questions(tmp_path / "a.csv", table("Time (ms);Fin (N);Fout (N)", MS, plain(2 + X), plain(2 + Y))))
    # a digit more, or a zero in front of the mark, is no mark between thousands
    for columns in ((plain(1000 * X, 4), plain(1000 * Y, 4)), (plain(1000 * X), ["0.125", *plain(1000 * Y)[1:]])):
        asked = questions(tmp_path / "a.csv", table("Time (ms);Fin (mN);Fout (mN)", MS, *columns))
        assert "three digits" not in asked.get("tension_out_n", "")


def test_millinewtons_in_all_are_asked_as_too_many_newtons_are(tmp_path: Path) -> None:
    asked = questions(tmp_path / "a.csv", table("Time (ms);Fin (N);Fout (N)", MS, plain(X / 1000, 6), plain(Y / 1000, 6)))
    assert all("less than a tendon's" in asked[t] for t in BOTH)


@pytest.mark.parametrize(("name", "row", "said"), [("F{}_lbf", "N", "lbf"), ("F{} [lbf]", "(N)", "lbf"), ("F{} [%]", "N", "%")])
def test_a_unit_in_the_name_against_the_row_of_units_is_asked(name: str, row: str, said: str, tmp_path: Path) -> None:
    head = f"t [s],{name.format('in')},{name.format('out')}\ns,{row},{row}"
    asked = questions(tmp_path / "a.csv", table(head, plain(T), plain(X, 4), plain(Y, 4), separator=","))
    assert all(f"its name says {said}, the file N" in asked[t] for t in BOTH)


def test_a_unit_in_the_name_as_in_the_row_of_units_is_sure(tmp_path: Path) -> None:
    head = "t [s],Fin [lb],Force (in)\ns,lbf,N"
    assert "tension_in_n" not in questions(
        tmp_path / "a.csv", table(head.replace("Force (in)", "Fout_N"), plain(T), plain(X), plain(Y), separator=",")
    )
    clocks = questions(tmp_path / "a.csv", table("time_ms,Fin,Fout\ns,N,N", plain(T), plain(X), plain(Y), separator=","))
    assert "its name says ms, the file s" in clocks["time_s"]


CLOCK = np.arange(len(T))


@pytest.mark.parametrize("step", [0.05, 0.1])
def test_a_clock_that_is_as_round_in_ms_is_asked(step: float, tmp_path: Path) -> None:
    # long enough to be a recording in ms, too
    clock = np.arange(4 * len(T)) * step
    x, y = np.tile(X, 4), np.tile(Y, 4)
    asked = questions(tmp_path / "a.csv", table("Time;Fin (N);Fout (N)", plain(clock, 2), plain(x), plain(y)))
    assert f"s ({1 / step:g} Hz), or ms ({1 / step:g} kHz)?" in asked["time_s"]


@pytest.mark.parametrize(("rate", "unit"), [("10 Hz", "s"), ("10 kHz", "ms")])
def test_a_rate_in_the_header_tells_the_unit_of_the_clock(rate: str, unit: str, tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    clock = np.arange(4 * len(T)) * 0.1
    head = f"# sampling rate: {rate}\nTime;Fin (N);Fout (N)"
    assert "time_s" not in questions(path, table(head, plain(clock, 1), plain(np.tile(X, 4)), plain(np.tile(Y, 4))))
    assert f'time_s = {{ column = "Time", unit = "{unit}" }}\n' in guess([path]).toml


def test_what_is_too_short_or_too_fast_in_ms_is_in_s(tmp_path: Path) -> None:
    clock = plain(CLOCK * 0.1, 1)
    assert "time_s" not in questions(tmp_path / "a.csv", table("Time;Fin (N);Fout (N)", clock, plain(X), plain(Y)))
    clock, place = plain(np.arange(4 * len(T)) * 0.1, 1), plain(np.tile(20 * X, 4))
    text = table("Time;Fin (N);Fout (N);Motor position (mm)", clock, plain(np.tile(X, 4)), plain(np.tile(Y, 4)), place)
    assert "time_s" not in questions(tmp_path / "a.csv", text)


def test_the_column_with_the_thousands_is_blamed_and_not_the_one_with_a_decimal_comma(tmp_path: Path) -> None:
    """Writing 6589 for 6,589 N, as the line said, makes it a thousand times too large."""
    path = tmp_path / "e.csv"
    body = [f"{f'{10 * i:,}'.replace(',', '.')};6,{589 + i % 300};5,{560 + i % 300}" for i in range(200)]
    path.write_text("Tiempo (ms);Fuerza entrada (N);Fuerza salida (N)\n" + "\n".join(body) + "\n")
    with pytest.raises(SstlError, match=r"E328.*'Tiempo \(ms\)' holds '1.000' beside numbers without a mark") as told:
        guess([path])
    assert "Fuerza" not in told.value.line()
