"""Clocks that are written as text: dates of either order, times since the start, and midnight."""

from __future__ import annotations

import tomllib
from datetime import datetime, timedelta
from pathlib import Path

import pytest
from header_table import T, X, Y, rows

from sstl_cli.importers.guess import Guess, guess

START = datetime(2024, 5, 2, 9, 15, 3)
MIDNIGHT = datetime(2024, 5, 2, 23, 59, 59)
STEP = 0.02


def proposed(folder: Path, stamps: list[str], sep: str = ",") -> tuple[dict[str, object], Guess]:
    path = folder / "act.csv"
    path.write_text(sep.join(("Timestamp", "Fin (N)", "Fout (N)")) + "\n" + rows(stamps.__getitem__, X, Y, sep=sep))
    found = guess([path])
    return tomllib.loads(found.toml)["columns"]["time_s"], found


def written(start: datetime, form: str) -> list[str]:
    return [(start + timedelta(seconds=STEP * i)).strftime(form) for i in range(len(T))]


@pytest.mark.parametrize("start", [START, MIDNIGHT])
@pytest.mark.parametrize(
    "form", ["%m/%d/%Y %H:%M:%S.%f", "%d/%m/%Y %H:%M:%S.%f", "%d.%m.%Y %H:%M:%S.%f", "%m/%d/%y %I:%M:%S.%f %p", "%Y/%m/%d %H:%M:%S.%f"]
)
def test_dates_with_a_time_of_day_tell_the_rate(form: str, start: datetime, tmp_path: Path) -> None:
    line, found = proposed(tmp_path, written(start, form))
    assert line == {"rate_hz": 50}
    [question] = found.questions
    # from 2 to 3 May is a day, and from 5 February to 5 March a month
    assert ("which number is the day" in question.text) == (start is MIDNIGHT and "/%" in form and not form.startswith("%Y"))
    assert "holds dates as text" in question.text


def test_an_order_in_which_a_date_does_not_exist_is_not_asked(tmp_path: Path) -> None:
    _, found = proposed(tmp_path, written(datetime(2024, 5, 30, 23, 59, 59), "%m/%d/%Y %H:%M:%S.%f"))
    assert "which number is the day" not in found.toml and "rate_hz = 50" in found.toml


def test_a_month_between_two_stamps_is_a_gap(tmp_path: Path) -> None:
    stamps = written(START, "%d.%m.%Y %H:%M:%S.%f")
    line, found = proposed(tmp_path, stamps[:200] + [s.replace("02.05", "02.06") for s in stamps[200:]])
    assert line == {"rate_hz": 0} and "1 gap of up to" in found.questions[0].text


@pytest.mark.parametrize(("start_s", "decimal"), [(0.0, "."), (3590.0, "."), (0.0, ","), (90_000.0, ".")])
def test_hours_since_the_start_need_not_have_two_places(start_s: float, decimal: str, tmp_path: Path) -> None:
    at = [start_s + STEP * i for i in range(len(T))]
    stamps = [f"{int(t // 3600)}:{int(t // 60 % 60):02d}:{t % 60:06.3f}".replace(".", decimal) for t in at]
    line, found = proposed(tmp_path, stamps, ";")
    assert line == {"rate_hz": 50} and "holds times as text" in found.questions[0].text


@pytest.mark.parametrize("stamp", ["05/02/2024", "9.15", "12:3", "1:2:3", "99/99/2024 9:15:03 xm"])
def test_what_is_no_time_of_day_is_no_clock(stamp: str, tmp_path: Path) -> None:
    line, _ = proposed(tmp_path, [f"{stamp} {i}" for i in range(len(T))])
    assert line == {"rate_hz": 0}
