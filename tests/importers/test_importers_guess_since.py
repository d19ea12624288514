"""Clocks whose zero lies centuries back, and rates that lines above a table state."""

from __future__ import annotations

import tomllib
from datetime import datetime
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from header_table import X, Y, rows

from sstl_cli.importers.guess import guess
from sstl_cli.importers.mapping import mapping_of
from sstl_cli.importers.rates_said import rate_said
from sstl_cli.steps.import_ import run

# 2024-05-03 14:05:06, 100 Hz
BEGIN = datetime(2024, 5, 3, 14, 5, 6)
S = np.arange(len(X)) * 0.01
DAY_S = 86_400.0


def seconds_since(year: int) -> int:
    return round((BEGIN - datetime(year, 1, 1)).total_seconds())


def written(path: Path, name: str, clock: list[str]) -> Path:
    body = rows(X, Y).splitlines()
    path.write_text(f"{name},Fin (N),Fout (N)\n" + "".join(f"{t},{line}\n" for t, line in zip(clock, body, strict=True)))
    return path


def imported(path: Path) -> np.ndarray:
    found = guess([path])
    assert {q.target for q in found.questions} == {"system"}
    columns = tomllib.loads(found.toml)["columns"]
    [one] = run([path], mapping_of({"columns": columns, "constants": {"system": "act"}}, "m.toml")).runs
    return one.time_s - one.time_s[0]


def asked(path: Path) -> str:
    return next((q.text for q in guess([path]).questions if q.target == "time_s"), "")


@pytest.mark.parametrize("since", [1, 1601])
@pytest.mark.parametrize("name", ["Ticks", "Time", "DateTime", "Timestamp [ticks]"])
def test_steps_of_100_ns_since_the_year_1_or_1601_are_a_clock(since: int, name: str, tmp_path: Path) -> None:
    clock = [str(seconds_since(since) * 10**7 + round(1e7 * t)) for t in S]
    assert imported(written(tmp_path / "a.csv", name, clock)) == pytest.approx(S, abs=2e-5)


def test_steps_of_100_ns_that_doubles_round_or_a_name_contradicts_are_asked(tmp_path: Path) -> None:
    fast = [str(seconds_since(1) * 10**7 + round(1e5 * t)) for t in S]
    assert "13 us only" in asked(written(tmp_path / "a.csv", "Ticks", fast))
    slow = [str(seconds_since(1) * 10**7 + round(1e7 * t)) for t in S]
    assert "the name says s" in asked(written(tmp_path / "b.csv", "Time (s)", slow))


@pytest.mark.parametrize(
    ("name", "zero"), [("Time", 45415.0), ("Datum", 45415.0), ("Time (days)", 45415.0), ("Time (d)", 0.0), ("Time", 739375.0)]
)
def test_days_are_a_clock(name: str, zero: float, tmp_path: Path) -> None:
    clock = [f"{zero + 0.5 + t / DAY_S:.10f}" for t in S]
    assert imported(written(tmp_path / "a.csv", name, clock)) == pytest.approx(S, abs=2e-5)


def test_a_fraction_of_a_day_is_asked_as_one(tmp_path: Path) -> None:
    path = written(tmp_path / "a.csv", "Time", [f"{0.587 + t / DAY_S:.12f}" for t in S])
    assert "days fit steps" in asked(path) and 'unit = "h", scale = 24' in guess([path]).toml


def test_seconds_of_a_day_are_no_days_since_1900(tmp_path: Path) -> None:
    """From 10 in the morning on they are numbers such as spreadsheets count days by: 36000.01 was taken for a day and 14 minutes."""
    path = written(tmp_path / "a.csv", "Time", [f"{36_000.5 + 0.4 * t:.3f}" for t in S])
    assert 'unit = "s" }' in guess([path]).toml


def test_days_whose_places_are_rounded_give_their_rate(tmp_path: Path) -> None:
    found = guess([written(tmp_path / "a.csv", "Time", [f"{45415.5 + t / DAY_S:.6f}" for t in np.arange(len(X)) * 0.01])])
    rate = tomllib.loads(found.toml)["columns"]["time_s"]["rate_hz"]
    assert rate == pytest.approx(100.0, rel=0.02) and "rounded" in asked(tmp_path / "a.csv")


@pytest.mark.parametrize(
    "line",
    [
        "Sample interval: 0.01 s", "Sample Interval (s): 0.01", "Sample interval,0.01,s", "Fs=100Hz", "Fs(Hz)=100", "Sample rate,100",
        '"Sample Rate (Hz)","100"', "SampleRate=100", "Scan rate: 100", "Samples per second: 100", "100 samples/s", "Data rate 100 Hz", "Δt = 10 ms",
        "Messintervall = 10 ms", "Abtastrate [Hz];100", "Abtastrate: 0,1 kHz", "Sample period (ms),10", "Interval(ms),10", "Time interval: 0.01 s",
        "Sample interval: 10 msec", "Sample interval: 10000 µs", "Fréquence d'échantillonnage: 100 Hz", "Frecuencia de muestreo: 100 Hz",
        "Frequenza di campionamento: 100 Hz", "采样频率: 100 Hz", "Sine of 0.5 Hz, Fs=100Hz",
    ],
)  # fmt: skip
def test_a_rate_is_read_as_operators_and_recorders_write_it(line: str, tmp_path: Path) -> None:
    assert rate_said([line]) == pytest.approx(0.01)
    path = tmp_path / "a.csv"
    path.write_text(f"{line}\nFin (N),Fout (N)\n" + rows(X, Y), encoding="utf-8")
    assert "time_s = { rate_hz = 100 }" in guess([path]).toml and "does a sample come every 0.01 s" in asked(path)


@pytest.mark.parametrize(
    "line", ["Motion: 0.5 Hz", "Update rate: 60 Hz", "Period: 2 s", "FS: 500 N", "Filter 100 Hz", "Rate: 5 mm/s", "Sampling rate: 1,000 Hz"]
)
def test_what_is_no_rate_of_samples_or_may_be_two_is_none(line: str) -> None:
    assert np.isnan(rate_said([line]))


def test_whole_nanoseconds_since_1970_in_parquet_are_a_clock(tmp_path: Path) -> None:
    clock = seconds_since(1970) * 10**9 + np.round(1e9 * S).astype(np.int64)
    pq.write_table(pa.table({"timestamp": clock, "Fin_N": X, "Fout_N": Y}), tmp_path / "a.parquet")
    assert imported(tmp_path / "a.parquet") == pytest.approx(S, abs=1e-6)
