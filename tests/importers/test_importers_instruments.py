"""Headers of instruments that state names in lines of their own, names in other scripts or with blanks, and counters that begin anew."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from sstl_cli.importers.guess import guess
from sstl_cli.importers.mapping import mapping_of
from sstl_cli.steps import import_

N = 300
T = np.arange(N) * 0.01
X = 4.0 - 2.5 * np.cos(3.0 * T)
Y = 0.6 * X + 0.2 * np.sin(3.0 * T)


def lines(separator: str, *columns: np.ndarray, digits: int = 4) -> str:
    return "".join(separator.join(f"{v:.{digits}f}" for v in row) + "\n" for row in zip(*columns, strict=True))


def proposed(path: Path, text: str | bytes) -> tuple[str, dict[str, str]]:
    """Return why, and the lines of the mapping by what they give."""
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    found = guess([path])
    return " ".join(found.reasons), {x.split(" = ")[0]: x for x in found.toml.splitlines() if " = " in x}


def test_control_desk_names_its_traces_in_a_line_of_their_own(tmp_path: Path) -> None:
    head = '"type";"measurement"\n"version";"2.0"\n"path";"A://in";"A://out"\n"trace_name";"Model/Force_in";"Model/Force_out"\n"unit";"N";"mN"\n"trace_values"\n'
    _, found = proposed(tmp_path / "a.csv", head + lines(";", T, X, 1000.0 * Y))
    assert found["time_s"] == 'time_s = { column = "time", unit = "s" }'
    assert found["tension_in_n"] == 'tension_in_n = { column = "Model/Force_in", unit = "N" }'
    assert found["tension_out_n"] == 'tension_out_n = { column = "Model/Force_out", unit = "mN" }'
    columns = {"time_s": "time", "tension_in_n": "Model/Force_in", "tension_out_n": {"column": "Model/Force_out", "unit": "mN"}}
    [run] = import_.run([tmp_path / "a.csv"], mapping_of({"columns": columns, "constants": {"system": "act"}}, "m.toml")).runs
    assert len(run) == N and run.tension_out_n == pytest.approx(Y, abs=1e-6)


@pytest.mark.parametrize(
    ("paths", "names"),
    [
        (("Model Root/Sensors/F_prox", "Model Root/Sensors/F_dist"), ("F_prox", "F_dist")),
        (("Model Root/F_in/Out1", "Model Root/F_out/Out1"), ("F_in/Out1", "F_out/Out1")),
        (("Model Root/Proximal/Value", "Model Root/Distal/Value"), ("Model Root/Proximal/Value", "Model Root/Distal/Value")),
    ],
)
def test_control_desk_without_names_is_read_by_its_paths(paths: tuple[str, str], names: tuple[str, str], tmp_path: Path) -> None:
    """It was cut at the width of its settings, and its first line of another width was an error."""
    head = f'"type","descriptor","sampling"\n"meta","ControlDesk 7.3","0.005"\npath,"HostService","{paths[0]}","{paths[1]}"\nunit,s,N,mN\ntrace_values\n'
    text = "".join(f",{line}\n" for line in lines(",", T, X, 1000.0 * Y).splitlines())
    _, found = proposed(tmp_path / "a.csv", head + text)
    assert found["time_s"] == 'time_s = { column = "HostService", unit = "s" }'
    for target, name, unit in (("tension_in_n", names[0], "N"), ("tension_out_n", names[1], "mN")):
        assert found[target] == f'{target} = {{ column = "{name}", unit = "{unit}" }}'


def test_a_scope_writes_a_word_before_every_channel(tmp_path: Path) -> None:
    head = "Name\tMAIN.fTensionIn\tName\tMAIN.fTensionOut\nData-Type\tREAL64\tData-Type\tREAL64\nSampleTime[ms]\t10\tSampleTime[ms]\t10\nUnit\tN\tUnit\tN\n\n"
    _, found = proposed(tmp_path / "a.csv", head + lines("\t", 1000 * T, X, 1000 * T, Y))
    assert found["time_s"] == 'time_s = { column = "time.1", unit = "ms" }'
    assert found["tension_in_n"] == 'tension_in_n = { column = "MAIN.fTensionIn", unit = "N" }'
    assert found["tension_out_n"] == 'tension_out_n = { column = "MAIN.fTensionOut", unit = "N" }'


def test_an_oscilloscope_states_units_among_its_settings(tmp_path: Path) -> None:
    """They were asked for: the rows above the header that hold them were left out."""
    head = "Model,MSO24\n\nPoint Format,Y,Y\nHorizontal Units,{},\nSample Interval,0.01,\nVertical Units,{},{}\nLabel,,\nTIME,CH1,CH2\n"
    _, found = proposed(tmp_path / "a.csv", head.format("s", "V", "mV") + lines(",", T - 3.0, X, 1000.0 * Y))
    assert found["time_s"] == 'time_s = { column = "TIME", unit = "s" }'
    assert 'column = "CH1", unit = "V" }  # (?) ' in found["tension_in_n"] and "gain = N per V" in found["tension_in_n"]
    assert 'column = "CH2", unit = "mV" }  # (?) ' in found["tension_out_n"]
    _, found = proposed(tmp_path / "a.csv", head.format("ms", "N", "N") + lines(",", 1000.0 * T, X, Y))
    assert 'unit = "ms" }' in found["time_s"] and 'unit = "N"' in found["tension_in_n"] and "no unit is stated" not in found["tension_in_n"]


def test_a_row_of_units_may_say_how_a_time_of_day_is_written(tmp_path: Path) -> None:
    rows = "".join(
        f"{i};09:15:{10 + i // 100:02d},{i % 100}0;{x:.3f};{y:.3f}\n".replace(".", ",") for i, (x, y) in enumerate(zip(X, Y, strict=True))
    )
    why, found = proposed(tmp_path / "a.csv", "Versuch: Zug\nNr.;Uhrzeit;Kraft_ein;Kraft_aus\n;hh:mm:ss,000;N;N\n" + rows)
    assert found["tension_in_n"] == 'tension_in_n = { column = "Kraft_ein", unit = "N" }' and "Uhrzeit" in why
    assert found["tension_out_n"] == 'tension_out_n = { column = "Kraft_aus", unit = "N" }' and "(?)" in found["time_s"]


def test_names_with_blanks_above_columns_cut_at_blanks(tmp_path: Path) -> None:
    _, found = proposed(tmp_path / "a.txt", "time (ms)  in (g)  out (g)\n" + lines("   ", 1000.0 * T, 101.97 * X, 101.97 * Y, digits=1))
    assert found["time_s"] == 'time_s = { column = "time (ms)", unit = "ms" }'
    assert '"in (g)", unit = "g"' in found["tension_in_n"] and '"out (g)", unit = "g"' in found["tension_out_n"]


@pytest.mark.parametrize(
    ("head", "code"),
    [
        ("序号,时间/ms,近端拉力/N,远端拉力/N", "gbk"),
        ("序号,时间/ms,输入张力/N,输出张力/N", "utf-8"),
        ("番号,時刻/ms,入力張力/N,出力張力/N", "utf-8"),
    ],
)
def test_chinese_and_japanese_names_are_read(head: str, code: str, tmp_path: Path) -> None:
    names = head.split(",")
    _, found = proposed(tmp_path / "a.csv", (head + "\n" + lines(",", np.arange(N), 1000.0 * T, X, Y)).encode(code))
    for target, name, unit in (("time_s", names[1], "ms"), ("tension_in_n", names[2], "N"), ("tension_out_n", names[3], "N")):
        assert found[target] == f'{target} = {{ column = "{name}", unit = "{unit}" }}'


def test_a_counter_that_begins_anew_is_the_clock_and_is_said_to(tmp_path: Path) -> None:
    count = (2**32 - 1_000_000 + np.arange(N) * 10_000) % 2**32
    rows = "".join(f"{c},{x:.3f},{y:.3f}\n" for c, x, y in zip(count, X, Y, strict=True))
    why, found = proposed(tmp_path / "a.csv", "us,motor_N,tip_N\n" + rows)
    assert 'column = "us", unit = "us"' in found["time_s"] and "counts to 2^32 and begins anew" in why


@pytest.mark.parametrize(("name", "side"), [("distal", "out"), ("out", "out"), ("proximal", "in")])
def test_a_column_named_by_its_side_alone_is_that_side_and_both_are_asked(name: str, side: str, tmp_path: Path) -> None:
    """The tension beside it was called the output, as it stands beside the command of a motion."""
    _, found = proposed(tmp_path / "a.csv", f"t_ms,Stroke_Ref,Tension,{name}\n" + lines(",", 1000.0 * T, 5.0 * T, X, Y))
    mine, other = ("tension_out_n", "tension_in_n") if side == "out" else ("tension_in_n", "tension_out_n")
    assert f'column = "{name}"' in found[mine] and 'column = "Tension"' in found[other]
    assert all("(?)" in found[v] for v in (mine, other))


@pytest.mark.parametrize("word", ['"trace_values"', '""'])
def test_the_first_sample_may_stand_behind_control_desks_word(word: str, tmp_path: Path) -> None:
    """It was lost without a word."""
    head = '"path","","A://in","A://out"\n"name","time","LC_in","LC_out"\n"unit","s","N","N"\n'
    rows = lines(",", T, X, Y).splitlines()
    text = head + f'"trace_values",{rows[0]}\n' + "".join(f"{word},{row}\n" for row in rows[1:])
    _, found = proposed(tmp_path / "a.csv", text)
    columns = {
        t: {"column": found[t].split('"')[1], "unit": u} for t, u in (("time_s", "s"), ("tension_in_n", "N"), ("tension_out_n", "N"))
    }
    [run] = import_.run([tmp_path / "a.csv"], mapping_of({"columns": columns, "constants": {"system": "act"}}, "m.toml")).runs
    assert len(run) == N and run.tension_in_n == pytest.approx(X, abs=1e-4)


def test_a_scopes_lines_about_the_file_are_not_those_of_its_channels(tmp_path: Path) -> None:
    """Its first block looked like one channel named after the chart."""
    head = "Name\tYT Chart\nFile\tC:\\rig\nStarttime of export\t133601772000000000\n\n"
    head += "Name\tfIn\tName\tfOut\nData-Type\tREAL64\tData-Type\tREAL64\nSymbolBased\tTrue\tSymbolBased\tTrue\nUnit\t(N)\tUnit\t(mN)\n\n"
    _, found = proposed(tmp_path / "a.csv", head + lines("\t", 1000 * T, X, 1000 * T, 1000 * Y))
    assert found["tension_in_n"] == 'tension_in_n = { column = "fIn", unit = "N" }'
    assert found["tension_out_n"] == 'tension_out_n = { column = "fOut", unit = "mN" }'
