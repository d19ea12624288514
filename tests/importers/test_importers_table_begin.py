"""Where a table begins below an instrument's settings, and which of the rows above it holds the names."""

from __future__ import annotations

import tomllib
from pathlib import Path

import pytest
from header_table import T, X, Y, rows

from sstl_cli.core.errors import SstlError
from sstl_cli.importers.guess import guess
from sstl_cli.importers.mapping import read_mapping
from sstl_cli.steps.import_ import run


def proposed(folder: Path, text: str) -> dict[str, dict[str, object]]:
    path = folder / "log.csv"
    path.write_text(text, encoding="utf-8")
    found = guess([path])
    (folder / "rig.toml").write_text(found.toml.replace("(?)", ""), encoding="utf-8")
    columns: dict[str, dict[str, object]] = tomllib.loads(found.toml)["columns"]
    return columns


def test_settings_with_a_number_for_each_channel_are_no_table(tmp_path: Path) -> None:
    head = (
        "Model,X1\nSample Interval,0.01\nProbe Attenuation,1,1\nVertical Units,N,N\nVertical Offset,0,0\n,,\nLabel,in,out\nTIME,CH1,CH2\n"
    )
    columns = proposed(tmp_path, head + rows(T, X, Y))
    assert {n: c["column"] for n, c in columns.items()} == {"time_s": "TIME", "tension_in_n": "CH1", "tension_out_n": "CH2"}
    assert columns["tension_in_n"]["unit"] == "N"
    [one] = run([tmp_path / "log.csv"], read_mapping(tmp_path / "rig.toml")).runs
    assert len(one) == len(T) and one.tension_in_n == pytest.approx(X, abs=1e-3)


@pytest.mark.parametrize("units", ["second,Volt,Volt,Ampere\n", ""])
def test_channels_may_be_named_by_numbers(units: str, tmp_path: Path) -> None:
    columns = proposed(tmp_path, "x-axis,1,2,3\n" + units + rows(T - 1.0, X / 9, Y / 9, 0.5 * X))
    assert columns["time_s"]["column"] == "x-axis"
    if units:
        assert [columns[n]["column"] for n in ("tension_in_n", "tension_out_n")] == ["1", "2"]
        assert columns["tension_in_n"]["unit"] == "V" and columns["time_s"]["unit"] == "second"


def test_the_lines_of_a_file_stand_above_those_of_its_channels(tmp_path: Path) -> None:
    head = "Name\tScope\nFile\tC:\\a.svdx\nStart of record\t133500000000000000\t12.03.2024\n\n"
    head += "Name\tfForceDrive\tName\tfForceTip\nData-Type\tREAL64\tData-Type\tREAL64\nSampleTime[ms]\t10\tSampleTime[ms]\t10\nUnit\tN\tUnit\tN\n\n"
    columns = proposed(tmp_path, head + rows(1e3 * T, X, 1e3 * T, Y, sep="\t"))
    assert columns["time_s"] == {"column": "time.1", "unit": "ms"}
    assert [columns[n]["column"] for n in ("tension_in_n", "tension_out_n")] == ["fForceDrive", "fForceTip"]


@pytest.mark.parametrize(
    "head",
    [
        "Time;Force_Motor;Force_Tip;I\ns;mN;mN;A\nDT_DOUBLE;DT_DOUBLE;DT_DOUBLE;DT_LONG\n",
        "Time;Force_Motor;Force_Tip;I\ns;mN;mN;A\nCAN=1 MX 0;MX CH1 S2M/100N;MX CH2 S2M/50N;MX CH3\n",
        '"Pruefer";"mk"\n"Vorkraft";0,5;"N"\n\n"Time";"Force_Motor";"Force_Tip";"Speed"\n"s";"mN";"mN";"mm/min"\n',
    ],
)
def test_names_stand_above_their_units_whatever_is_below(head: str, tmp_path: Path) -> None:
    columns = proposed(tmp_path, head + rows(T, 1e3 * X, 1e3 * Y, 0.1 * X, sep=";", dec=","))
    assert columns["time_s"] == {"column": "Time", "unit": "s"}
    assert columns["tension_in_n"] == {"column": "Force_Motor", "unit": "mN"}
    assert columns["tension_out_n"] == {"column": "Force_Tip", "unit": "mN"}


def test_a_setting_above_the_names_is_no_row_of_units(tmp_path: Path) -> None:
    columns = proposed(tmp_path, "Firmware,a.b\nVertical Units,N,N\nTIME,CH1,CH2\n" + rows(T, X, Y))
    assert columns["time_s"]["column"] == "TIME"


@pytest.mark.parametrize("first", ["a,b,c\nx,1,2\n", "x,90684,102345\n"])
def test_a_damaged_first_row_is_not_left_out(first: str, tmp_path: Path) -> None:
    names = ("a", "b", "c") if first.startswith("a") else ("col1", "col2", "col3")
    columns = "".join(f'{target} = "{name}"\n' for target, name in zip(("time_s", "tension_in_n", "tension_out_n"), names, strict=True))
    (tmp_path / "rig.toml").write_text(f'[columns]\n{columns}[constants]\nsystem = "act"\n')
    (tmp_path / "log.csv").write_text(first + rows(T, X, Y))
    with pytest.raises(SstlError, match="'x', not a number") as raised:
        list(run([tmp_path / "log.csv"], read_mapping(tmp_path / "rig.toml")).runs)
    assert raised.value.code == "E328"


def test_a_header_that_stands_there_again_is_named_with_its_line(tmp_path: Path) -> None:
    table = "t_ms,in_N,out_N\n" + rows(1e3 * T, X, Y)
    (tmp_path / "rig.toml").write_text(
        '[columns]\ntime_s = "t_ms"\ntension_in_n = "in_N"\ntension_out_n = "out_N"\n[constants]\nsystem = "act"\n'
    )
    (tmp_path / "log.csv").write_text(table + table)
    with pytest.raises(SstlError, match=f"line {len(T) + 2}: column 't_ms'.*header stands there again") as raised:
        list(run([tmp_path / "log.csv"], read_mapping(tmp_path / "rig.toml")).runs)
    assert raised.value.code == "E328" and 'blocks = "runs"' in raised.value.fix
    # with another width the first table is not left out in silence, nor one of times in text
    wider = "t_ms,in_N,out_N,i\n" + rows(1e3 * T, X, Y, X)
    times = "".join(f"14:03:{k:02d},{k},{k}\n" for k in range(20))
    for first in (table, "Time,in_N,out_N\n" + times):
        with pytest.raises(SstlError) as raised:
            proposed(tmp_path, first + wider)
        assert raised.value.code in ("E327", "E333")


def test_too_few_channels_say_where_the_table_seems_to_begin(tmp_path: Path) -> None:
    with pytest.raises(SstlError, match=r"columns 'key' \(text\), 'value'; .* line 2\).*skip_rows and header") as raised:
        proposed(tmp_path, "key,value\n" + "".join(f"a{i},{i}\n" for i in range(50)))
    assert raised.value.code == "E333"


@pytest.mark.parametrize("encoding", ["utf-16-le", "utf-16-be"])
def test_unicode_text_of_a_spreadsheet_is_read(encoding: str, tmp_path: Path) -> None:
    text = (
        "\ufeffTempo [s]\tForza ingresso [N]\tForza uscita [N]\r\n"
        + rows(T, X, Y, sep="\t", dec=",").replace("\n", "\r\n")
        + "Media\t9,2\t7,8\r\n"
    )
    (tmp_path / "log.txt").write_bytes(text.encode(encoding))
    found = guess([tmp_path / "log.txt"])
    assert [q.target for q in found.questions] == ["system"]
    (tmp_path / "rig.toml").write_text(found.toml.replace("(?)", ""))
    done = run([tmp_path / "log.txt"], read_mapping(tmp_path / "rig.toml"))
    [one] = done.runs
    assert one.tension_out_n == pytest.approx(Y, abs=1e-3) and "statistics below the samples (Media)" in str(done.counts.notes)
    (tmp_path / "log.txt").write_bytes(text.encode(encoding)[:-3])
    assert len(list(run([tmp_path / "log.txt"], read_mapping(tmp_path / "rig.toml")).runs)) == 1


def test_a_second_block_with_a_line_of_its_own_is_said_to_be_one(tmp_path: Path) -> None:
    block = rows(T, X, Y, sep="\t")
    text = f"Time\tProximal Force\tDistal Force\nSec\tN\tN\n{block}\nDaq: Timed\t\tTime:\t52.010\tSec\nTime\tProximal Force\tDistal Force\n{block}"
    with pytest.raises(SstlError) as error:
        proposed(tmp_path, text)
    said = str(error.value.fix)
    assert error.value.code == "E327" and "split the file there" in said and "skip_rows" not in said
