"""Headers of recorders, oscilloscopes and loggers: names, units and the interval stand in lines of their own."""

from __future__ import annotations

import tomllib
from pathlib import Path

import numpy as np
import pytest
from header_table import T, X, Y, rows
from proposals import proposed

from sstl_cli.importers.guess import Guess
from sstl_cli.importers.mapping import read_mapping
from sstl_cli.steps.import_ import run

# of T
STEP = float(T[1] - T[0])
K = np.arange(len(T))
SECONDS = T.astype(int)


def in_newtons_and_seconds(path: Path, found: Guess) -> None:
    (path.parent / "rig.toml").write_text(found.toml.replace("(?)", ""))
    [one] = run([path], read_mapping(path.parent / "rig.toml")).runs
    for mine, theirs in ((one.time_s - one.time_s[0], T - T[0]), (one.tension_in_n, X), (one.tension_out_n, Y)):
        np.testing.assert_allclose(mine, theirs, atol=2e-3)


ACQ = f"bend.acq\n{1e3 * STEP:g} msec/sample\n2 channels\nForce in\nN\nForce out\nN\n"
LABCHART = f"Interval=\t{STEP:g} s\nExcelDateTime=\t4.54e+04\t14/05/2024 10:22:33.123\nTimeFormat=\tStartOfBlock\nChannelTitle=\tForce in\tForce out\n"
YOKOGAWA = (
    f'"Model Name","DL850E"\n"TraceName","Force in","Force out"\n"BlockSize",400,400\n"VUnit","N","N"\n"HResolution",{STEP:g},{STEP:g}\n\n'
)
GRAPHTEC = (
    'Vendor,Graphtec\nSampling interval,{}ms\nCH,Signal name,Input,Range,Filter,Span\nCH1,"Force in",DC,5V,Off,50.0,0.0,N\nCH2,"Force out",DC,5V,Off,50.0,0.0,N\n'
    "Data\nNumber,Date&Time,ms,CH1,CH2,Alarm1-10,AlarmOut\nNO.,Time,ms,N,N,A1234567890,A1234\n"
).format(f"{1e3 * STEP:g}")
HIOKI = '"File name","A.MEM"\n"CH","U1-1","U2-1"\n"Range","5V","5V"\n"Comment","Force in","Force out"\n"Offset"," 0.0E+00"," 0.0E+00"\n"Time[s]","U1-1[N]","U2-1[N]"\n'


def day(i: int) -> str:
    return f"2024/05/14 10:22:{SECONDS[i]:02d}"


def part(i: int) -> str:
    return f"{round(1e3 * (T[i] - SECONDS[i])):03d}"


@pytest.mark.parametrize(
    ("text", "asked"),
    [
        (ACQ + f"min\tCH1\tCH2\t\n\t{len(T)}\t{len(T)}\t\n" + rows(T / 60, X, Y, "", sep="\t", digits=9), set()),
        (ACQ + f"CH1\tCH2\t\n{len(T)}\t{len(T)}\t\n" + rows(X, Y, "", sep="\t"), {"time_s"}),
        (LABCHART + "Range=\t50.000 N\t50.000 N\n" + rows(T, X, Y, sep="\t"), set()),
        (LABCHART + "Range=\t10.000 V\t10.000 V\nUnitName=\tN\tN\nTopValue=\t*\t*\n" + rows(T, X, Y, sep="\t"), set()),
        (YOKOGAWA + rows("", X, Y), {"time_s"}),
        (YOKOGAWA + rows("", X, Y, ""), {"time_s"}),
        (GRAPHTEC + rows(lambda i: str(i + 1), day, part, X, Y, "LLLL", "LL"), set()),
        (GRAPHTEC + rows(lambda i: str(i + 1), day, part, lambda i: f"+ {X[i]:8.4f}", lambda i: f"+ {Y[i]:8.4f}", "LLLL", "LL"), set()),
        (HIOKI + rows(T, X, Y), set()),
    ],
    ids=[
        "AcqKnowledge",
        "AcqKnowledge without time",
        "LabChart",
        "LabChart units",
        "Yokogawa",
        "Yokogawa with a separator at both ends",
        "Graphtec",
        "Graphtec signs apart",
        "Hioki",
    ],
)
def test_names_units_and_interval_of_a_recorder_are_read(text: str, asked: set[str], tmp_path: Path) -> None:
    _, found = proposed(tmp_path / "act.txt", text)
    assert {q.target for q in found.questions} == asked
    in_newtons_and_seconds(tmp_path / "act.txt", found)


@pytest.mark.parametrize(
    "head", [f"X,CH1,CH2,Start,Increment,\nSequence,Volt,Volt,-1.0e-01,{STEP:e}\n", f"X,CH1(V),CH2(V),t0 = -0.1, tInc = {STEP:e},\n"]
)
def test_the_increment_of_an_oscilloscope_is_its_step(head: str, tmp_path: Path) -> None:
    columns, found = proposed(tmp_path / "act.csv", head + rows(K, X / 10, Y / 10, "", "", "", digits=4))
    assert columns["time_s"]["rate_hz"] == pytest.approx(1 / STEP) and columns["tension_in_n"]["unit"] == "V"
    assert "the header states it" in found.toml


@pytest.mark.parametrize("behind", ["", ","])
def test_readings_that_end_before_the_settings_of_an_oscilloscope_are_read(behind: str, tmp_path: Path) -> None:
    head = f"X,CH1,CH2,Start,Increment,\nSequence,Volt,Volt,-1.0e-01,{STEP:e}\n"
    columns, _ = proposed(tmp_path / "act.csv", head + rows(K, X / 10, Y / 10, behind, digits=4))
    assert columns["time_s"]["rate_hz"] == pytest.approx(1 / STEP)
    assert [columns[t]["column"] for t in ("tension_in_n", "tension_out_n")] == ["CH1", "CH2"]


@pytest.mark.parametrize("unit", ["Volts", "Newtons", "lbf"])
def test_units_of_labview_with_a_clock_for_each_channel_are_read(unit: str, tmp_path: Path) -> None:
    head = "LabVIEW Measurement\t\nMulti_Headings\tYes\nX_Columns\tMulti\n***End_of_Header***\t\n\nChannels\t2\t\t\t\n"
    told = f"Y_Unit_Label\t{unit}\t\t{unit}\t\t\nX_Dimension\tTime\t\tTime\t\t\n***End_of_Header***\nX_Value\tFin\tX_Value\tFout\tComment\n"
    columns, _ = proposed(tmp_path / "act.lvm", head + told + rows(T, X, T, Y, sep="\t"))
    assert {columns[t]["unit"] for t in ("tension_in_n", "tension_out_n")} == {{"Volts": "V", "Newtons": "N"}.get(unit, unit)}


@pytest.mark.parametrize("line", ["Run time: 60 s", "Period = 4 s", "Test time: 5 s", "Hold time = 10 ms"])
def test_other_times_of_a_header_are_no_step(line: str, tmp_path: Path) -> None:
    _, found = proposed(tmp_path / "act.csv", f"{line}\nTime (s),Fin (N),Fout (N)\n" + rows(T, X, Y))
    assert found.questions == []


def test_a_label_beside_a_name_that_says_it_itself_is_none(tmp_path: Path) -> None:
    head = "CH,Label\nF_in,output of amplifier 1\nF_out,output of amplifier 2\n\nTime (s),F_in,F_out\ns,N,N\n"
    columns, _ = proposed(tmp_path / "act.csv", head + rows(T, X, Y))
    assert (columns["tension_in_n"]["column"], columns["tension_out_n"]["column"]) == ("F_in", "F_out")


@pytest.mark.parametrize("above", ["Min,2.1,1.2\nMax:,31.0,22.5\nStd. dev.,8.1,7.2\n", "Mittelwert,9.1,7.2\nStandardabweichung,3.0,2.0\n"])
def test_rows_of_statistics_above_the_samples_are_no_samples(above: str, tmp_path: Path) -> None:
    columns, found = proposed(tmp_path / "act.csv", "Time (s),Fin (N),Fout (N)\n" + above + rows(T, X, Y))
    assert columns["time_s"] == {"column": "Time (s)", "unit": "s"} and found.questions == []
    in_newtons_and_seconds(tmp_path / "act.csv", found)


def test_a_table_of_statistics_below_the_samples_is_no_part_of_them(tmp_path: Path) -> None:
    below = "\nStatistics,Fin (N),Fout (N)\nMin,2.1,1.2\nStd. dev.,8.1,7.2\n"
    _, found = proposed(tmp_path / "act.csv", "Time (s),Fin (N),Fout (N)\n" + rows(T, X, Y) + below)
    in_newtons_and_seconds(tmp_path / "act.csv", found)


@pytest.mark.parametrize(("first", "second"), [("cpu_ms", "adc_ms"), ("host_ms", "daq_us"), ("plc_s", "raw_ms"), ("plc_ms", "hx_us")])
def test_ticks_that_run_on_evenly_are_a_clock_whatever_they_are_of(first: str, second: str, tmp_path: Path) -> None:
    size = {"ms": 1e3, "us": 1e6, "s": 1.0}
    a, b = (size[n.rpartition("_")[2]] for n in (first, second))
    later = 0.37 + 1.25 * T
    columns, found = proposed(tmp_path / "act.csv", f"{first},Fin_N,{second},Fout_N\n" + rows(a * T, X, b * later, np.interp(later, T, Y)))
    assert columns["time_s"]["column"] == first and found.questions == []
    assert columns["tension_out_n"]["time"] == second


@pytest.mark.parametrize(
    ("values", "name", "asks"),
    [
        (("act", "sstl"), "run_act_sstl_3", ""),
        (("ACT", "Sensing"), "run3", ""),
        (("single", "loop"), "run3", "'loop' as sstl and 'single' as act"),
        (("act", "sense"), "run3", "'act' as act and 'sense' as sstl"),
        (("sstl", "sstl"), "run3", "is 'sstl' as sstl the system"),
        (("sstl", "sstl"), "act_run3", "the name of 'act_run3.csv' says act, this column sstl"),
        (("act", "sstl"), "act_run3", "says act, this column act and sstl"),
    ],
)
def test_a_column_that_holds_systems_gives_the_system(values: tuple[str, str], name: str, asks: str, tmp_path: Path) -> None:
    path = tmp_path / f"{name}.csv"
    text = "mode,time_s,Fin_N,Fout_N\n" + "".join(rows(v, T, X, Y) for v in values)
    columns, found = proposed(path, text)
    assert columns["system"] == "mode" and "system" not in tomllib.loads(found.toml)["constants"]
    assert asks in "".join(q.text for q in found.questions) and bool(asks) == any(q.target == "system" for q in found.questions)
    (tmp_path / "rig.toml").write_text(found.toml.replace("(?)", ""))
    systems = [r.system for r in run([path], read_mapping(tmp_path / "rig.toml")).runs]
    assert systems == [{"act": "act", "single": "act"}.get(v.lower(), "sstl") for v in values]


def test_a_type_of_data_is_no_system(tmp_path: Path) -> None:
    _, found = proposed(tmp_path / "act.csv", "Time (s),Fin (N),Fout (N),type\n" + rows(T, X, Y, "double"))
    assert found.questions == []


def test_channels_that_all_say_one_side_are_asked_for_the_other(tmp_path: Path) -> None:
    _, found = proposed(tmp_path / "act.csv", "Time (s),Input 1 (N),Input 2 (N)\n" + rows(T, X, Y))
    asked = {q.target: q.text for q in found.questions}
    assert "'Input 1 (N)', 'Input 2 (N)' all say input: which of them" in asked["tension_out_n"]
    assert "NAME" not in found.toml and "merge" not in found.toml
