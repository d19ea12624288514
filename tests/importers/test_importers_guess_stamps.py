"""Clocks that are written as text, read as they stand: dates of either order, times since the start, and midnight."""

from __future__ import annotations

import tomllib
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from pathlib import Path

import numpy as np
import pytest
from header_table import T, X, Y, rows

from sstl_cli.core.errors import SstlError
from sstl_cli.importers.guess import Guess, guess
from sstl_cli.importers.mapping import read_mapping
from sstl_cli.steps.import_ import run

START = datetime(2024, 5, 2, 9, 15, 3)
MIDNIGHT = datetime(2024, 5, 2, 23, 59, 59)
STEP = 0.02


def proposed(folder: Path, stamps: list[str], sep: str = ",") -> tuple[dict[str, object], Guess]:
    path = folder / "act.csv"
    path.write_text(sep.join(("Timestamp", "Fin (N)", "Fout (N)")) + "\n" + rows(stamps.__getitem__, X, Y, sep=sep))
    found = guess([path])
    return tomllib.loads(found.toml)["columns"]["time_s"], found


def imported(folder: Path, found: Guess) -> np.ndarray:
    """Return the times (s) that an import gives."""
    (folder / "rig.toml").write_text(found.toml.replace("(?)", "") + "\n[time]\ngap_s = 1e9\n")
    [one] = run([folder / "act.csv"], read_mapping(folder / "rig.toml")).runs
    return one.time_s


def written(start: datetime, form: str) -> list[str]:
    return [(start + timedelta(seconds=STEP * i)).strftime(form) for i in range(len(T))]


@pytest.mark.parametrize("start", [START, MIDNIGHT])
@pytest.mark.parametrize(
    "form", ["%m/%d/%Y %H:%M:%S.%f", "%d/%m/%Y %H:%M:%S.%f", "%d.%m.%Y %H:%M:%S.%f", "%m/%d/%y %I:%M:%S.%f %p", "%Y/%m/%d %H:%M:%S.%f"]
)
def test_dates_with_a_time_of_day_are_the_clock(form: str, start: datetime, tmp_path: Path) -> None:
    line, found = proposed(tmp_path, written(start, form))
    assert line == {"column": "Timestamp", "unit": "s"} and "time_s" not in {q.target for q in found.questions}
    # from 2 to 3 May is a day, and from 5 February to 5 March a month: days are those that lie nearest together
    np.testing.assert_allclose(np.diff(imported(tmp_path, found)), STEP, atol=1e-6)


def test_an_order_in_which_a_date_does_not_exist_is_none(tmp_path: Path) -> None:
    _, found = proposed(tmp_path, written(datetime(2024, 5, 30, 23, 59, 59), "%m/%d/%Y %H:%M:%S.%f"))
    times = imported(tmp_path, found)
    assert times[0] == datetime(2024, 5, 30, 23, 59, 59, tzinfo=UTC).timestamp() and times[-1] - times[0] < 60.0


def test_a_month_between_two_stamps_is_a_gap(tmp_path: Path) -> None:
    stamps = written(START, "%d.%m.%Y %H:%M:%S.%f")
    _, found = proposed(tmp_path, stamps[:200] + [s.replace("02.05", "02.06") for s in stamps[200:]])
    assert np.diff(imported(tmp_path, found)).max() == pytest.approx(31 * 86_400 + STEP)


@pytest.mark.parametrize(("start_s", "decimal"), [(0.0, "."), (3590.0, "."), (0.0, ","), (90_000.0, ".")])
def test_hours_since_the_start_need_not_have_two_places(start_s: float, decimal: str, tmp_path: Path) -> None:
    at = [start_s + STEP * i for i in range(len(T))]
    stamps = [f"{int(t // 3600)}:{int(t // 60 % 60):02d}:{t % 60:06.3f}".replace(".", decimal) for t in at]
    _, found = proposed(tmp_path, stamps, ";")
    np.testing.assert_allclose(imported(tmp_path, found), at, atol=1e-9)


def test_months_may_be_words_and_a_colon_may_stand_before_the_fraction(tmp_path: Path) -> None:
    _, found = proposed(tmp_path, [s.replace("|", ":") for s in written(START, "%d-%b-%Y %H:%M:%S|%f")])
    times = imported(tmp_path, found)
    np.testing.assert_allclose(np.diff(times), STEP, atol=1e-6)
    assert times[0] == pytest.approx(START.replace(tzinfo=UTC).timestamp())


def test_samples_that_share_stamps_are_asked(tmp_path: Path) -> None:
    stamps = written(START, "%H:%M:%S.%f")
    line, found = proposed(tmp_path, [stamps[i - i % 2 * (i % 3 > 0)] for i in range(len(T))])
    assert line == {"column": "Timestamp", "unit": "s"} and "share the stamp of another" in found.questions[0].text


def test_a_cell_that_is_no_time_among_times_is_refused_with_its_line(tmp_path: Path) -> None:
    stamps = written(START, "%H:%M:%S.%f")
    _, found = proposed(tmp_path, [*stamps[:150], "later", *stamps[151:]])
    assert any("line 152" in r and "'later' in a column of times" in r for r in found.reasons)


def test_times_in_text_count_in_seconds_alone(tmp_path: Path) -> None:
    _, found = proposed(tmp_path, written(START, "%H:%M:%S.%f"))
    with pytest.raises(SstlError, match="read in s, and its unit is given as ms"):
        imported(tmp_path, replace(found, toml=found.toml.replace('unit = "s"', 'unit = "ms"')))


@pytest.mark.parametrize("stamp", ["05/02/2024", "9.15", "12:3", "1:2:3", "99/99/2024 9:15:03 xm"])
def test_what_is_no_time_of_day_is_no_clock(stamp: str, tmp_path: Path) -> None:
    line, _ = proposed(tmp_path, [f"{stamp} {i}" for i in range(len(T))])
    assert line == {"rate_hz": 0}
