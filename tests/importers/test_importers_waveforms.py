"""Waveforms without a column of time: their start and step stand above the samples."""

from __future__ import annotations

from pathlib import Path

import pytest
from header_table import T, X, Y, rows
from proposals import proposed

FORCES = "Fin (N)\tFout (N)"


@pytest.mark.parametrize(
    "head",
    [
        f"waveform\t[0]\t[1]\nt0\t14:02:11,123\t14:02:11,123\ndelta t\t0,004000\t0,004000\n\n{FORCES}\n",
        f"waveform\t{FORCES}\nt0\t14:02:11,123\t14:02:11,123\ndelta t\t0,004000\t0,004000\n\n",
        f"t0\t2024-05-03 14:05:06.1\ndt\t0,004\n{FORCES}\n",
        f"# t0 = 0\n# dt = 0.004\n{FORCES}\n",
    ],
)
def test_one_start_and_step_are_the_clock(head: str, tmp_path: Path) -> None:
    columns, found = proposed(tmp_path / "act.csv", head + rows(X, Y, sep="\t", dec=","))
    assert columns["time_s"] == {"rate_hz": 250} and not found.questions
    assert columns["tension_out_n"] == {"column": "Fout (N)", "unit": "N"}


@pytest.mark.parametrize(
    ("lines", "asked", "rate"),
    [
        ("t0\t0\t0\ndelta t\t0,004\t0,002\n", "steps of 0.002 and 0.004 s in one table", 0),
        ("t0\t14:02:11,1\t14:02:11,3\ndelta t\t0,004\t0,004\n", "begin at 14:02:11,1 and 14:02:11,3", 0),
        ("dt\t0,004\n", "in s, as no unit stands there?", 250),
    ],
)
def test_steps_or_starts_that_differ_are_asked(lines: str, asked: str, rate: int, tmp_path: Path) -> None:
    columns, found = proposed(tmp_path / "act.csv", f"{lines}\n{FORCES}\n" + rows(X, Y, sep="\t", dec=","))
    assert columns["time_s"] == {"rate_hz": rate} and asked in found.questions[0].text


def test_a_column_of_time_goes_before_steps_of_each(tmp_path: Path) -> None:
    head = f"waveform\t[0]\t[1]\nt0\t0\t0\ndelta t\t0,004\t0,002\n\ntime\t{FORCES}\n"
    columns, found = proposed(tmp_path / "act.csv", head + rows(T, X, Y, sep="\t", dec=","))
    assert columns["time_s"] == {"column": "time", "unit": "s"} and not found.questions


@pytest.mark.parametrize("starts", ["X0\t0.0\t2.0\t\n", "Time\t14:05:06.0\t14:05:08.0\t\nX0\t0.0\t0.0\t\n"])
@pytest.mark.parametrize("clock", [True, False])
def test_channels_of_labview_that_begin_at_two_times_are_asked(starts: str, clock: bool, tmp_path: Path) -> None:
    head = f"LabVIEW Measurement\t\nX_Columns\t{'One' if clock else 'No'}\n***End_of_Header***\t\n\t\nChannels\t2\t\t\n"
    head += f"Y_Unit_Label\tN\tN\t\nX_Dimension\tTime\tTime\t\n{starts}Delta_X\t0.004\t0.004\t\n***End_of_Header***\t\t\t\n"
    table = rows(*([T] if clock else []), X, Y, sep="\t")
    table = table if clock else "".join(f"\t{line}\n" for line in table.splitlines())
    columns, found = proposed(tmp_path / "act.lvm", f"{head}X_Value\tFin\tFout\tComment\n{table}")
    assert columns["time_s"] == ({"column": "X_Value", "unit": "s"} if clock else {"rate_hz": 0})
    assert "begin at" in found.questions[0].text and len(found.questions) == 1
