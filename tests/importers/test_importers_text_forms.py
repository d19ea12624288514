"""Lines that hold more than cells: labels in front of numbers, units behind them, and the clock of a serial monitor."""

from __future__ import annotations

import tomllib
from datetime import datetime, timedelta
from pathlib import Path

import numpy as np
import pytest
from header_table import T, X, Y
from proposals import proposed

from sstl_cli.core.errors import SstlError
from sstl_cli.core.runs import Run
from sstl_cli.importers.follow import TextFollower
from sstl_cli.importers.guess import Guess, guess
from sstl_cli.importers.mapping import mapping_of, read_mapping
from sstl_cli.steps.import_ import run

START = datetime(2024, 5, 14, 10, 22, 33)
LBF = 4.4482216152605


def imported(path: Path, found: Guess) -> Run:
    (path.parent / "rig.toml").write_text(found.toml.replace("(?)", ""))
    [one] = run([path], read_mapping(path.parent / "rig.toml")).runs
    return one


def lines(form: str, *columns: np.ndarray, stamp: str = "") -> str:
    times = (START + timedelta(seconds=float(t)) for t in T)
    return "".join(
        f"{t:{stamp}}"[: -3 if stamp else None] * bool(stamp) + form.format(*v) + "\n"
        for t, v in zip(times, zip(*columns, strict=True), strict=True)
    )


@pytest.mark.parametrize(
    "form",
    [
        "t_s:{:.3f},Fin_N:{:.3f},Fout_N:{:.3f}",
        "t_s:{:.3f}\tFin_N:{:.3f}\tFout_N:{:.3f}\r",
        "t_s={:.3f} Fin_N={:.3f} Fout_N={:.3f}",
        "t_s: {:.3f}, Fin_N: {:.3f}, Fout_N: {:.3f}",
        "t_s: {:.3f}; Fin: {:.3f} N; Fout: {:.3f} N;",
        "{:.3f} Fin: {:.3f} N Fout: {:.3f} N",
    ],
)
def test_labels_in_every_cell_are_the_header(form: str, tmp_path: Path) -> None:
    columns, found = proposed(
        tmp_path / "act.txt", f"HX711 ready{form[-1:].strip('}N;')}\nTare done{form[-1:].strip('}N;')}\n" + lines(form, T, X, Y)
    )
    assert [str(columns[c]["column"])[:4].strip("_") for c in ("tension_in_n", "tension_out_n")] == ["Fin", "Fout"]
    assert columns["tension_in_n"]["unit"] == "N" and not {"tension_in_n", "tension_out_n"} & {q.target for q in found.questions}
    one = imported(tmp_path / "act.txt", found)
    for mine, theirs in ((one.time_s, T), (one.tension_in_n, X), (one.tension_out_n, Y)):
        np.testing.assert_allclose(mine, theirs, atol=6e-4)


def test_a_line_with_other_labels_is_refused_with_its_number(tmp_path: Path) -> None:
    text = lines("t_s:{:.3f},Fin_N:{:.3f},Fout_N:{:.3f}", T, X, Y).splitlines()
    text[200] = text[200].replace("Fin_N", "Fout_N", 1).replace(",Fout_N", ",Fin_N", 2)
    with pytest.raises(SstlError, match="line 201"):
        proposed(tmp_path / "act.txt", "\n".join(text) + "\n")


@pytest.mark.parametrize("rest", ["{:.3f}\t{:.3f}", "{:.3f},{:.3f}", "{:.3f} {:.3f}", "Fin:{:.3f},Fout:{:.3f}"])
@pytest.mark.parametrize(("stamp", "between"), [("%H:%M:%S.%f", " -> "), ("[%Y-%m-%d %H:%M:%S.%f", "] ")])
def test_the_stamp_of_a_serial_monitor_is_the_clock(rest: str, stamp: str, between: str, tmp_path: Path) -> None:
    columns, found = proposed(tmp_path / "act.txt", lines(between + rest, X, Y, stamp=stamp))
    asked = {q.target for q in found.questions}
    assert columns["time_s"] == {"column": "stamp", "unit": "s"} and asked == {"tension_in_n", "tension_out_n"}
    one = imported(tmp_path / "act.txt", found)
    np.testing.assert_allclose(one.time_s - one.time_s[0], np.floor(1e3 * T + 1e-6) / 1e3, atol=1.1e-3)
    np.testing.assert_allclose(one.tension_in_n, X, atol=6e-4)


def test_what_a_program_says_while_it_starts_is_no_header(tmp_path: Path) -> None:
    boot = "10:22:31.003 -> Starting\n10:22:32.551 -> Tare done\n"
    text = boot + lines(" -> {:.3f}\t{:.3f}", X, Y, stamp="%H:%M:%S.%f")
    columns, _ = proposed(tmp_path / "act.txt", text)
    assert (columns["tension_in_n"]["column"], columns["tension_out_n"]["column"]) == ("col2", "col3")


@pytest.mark.parametrize(
    ("head", "form", "unit", "newtons"),
    [
        ("t,Fin,Fout", "{:.3f},{:.4f} lbf,{:.4f} lbf", "lbf", LBF),
        ("Time (s)\tFin\tFout", "{:.3f}\t{:.4f} kg\t{:.4f} kg", "kg", 9.80665),
        ("Zeit;Kraft ein;Kraft aus", "{:.3f} s;{:.4f} N;{:.4f} N", "N", 1.0),
        ("t  Fin  Fout", "{:.3f}  {:.4f} kgf  {:.4f} kgf", "kgf", 9.80665),
        ('"t","Fin","Fout"', '"{:.3f}","{:.4f}N","{:.4f}N"', "N", 1.0),
    ],
)
def test_units_behind_the_numbers_are_read(head: str, form: str, unit: str, newtons: float, tmp_path: Path) -> None:
    text = lines(form, T, X, Y)
    text = text.replace(".", ",") if ";" in form else text
    columns, found = proposed(tmp_path / "act.csv", head + "\n" + text)
    assert columns["tension_in_n"]["unit"] == unit and found.questions == []
    one = imported(tmp_path / "act.csv", found)
    np.testing.assert_allclose(one.tension_in_n, newtons * X, atol=1e-3 * newtons)
    np.testing.assert_allclose(one.time_s, T, atol=6e-4)


def test_a_unit_that_changes_is_refused(tmp_path: Path) -> None:
    text = "t,Fin,Fout\n" + "".join(
        f"{t:.3f},{x:.3f} N,{f'{y:.3f} N' if y > 1 else f'{1e3 * y:.0f} mN'}\n" for t, x, y in zip(T, X, Y / Y.max() * 2, strict=True)
    )
    with pytest.raises(SstlError, match="column 'Fout' holds .* and .*: the unit behind its numbers changes"):
        proposed(tmp_path / "act.csv", text)


def test_a_unit_that_changes_later_is_refused_with_its_line(tmp_path: Path) -> None:
    text = ("t,Fin,Fout\n" + lines("{:.3f},{:.3f} N,{:.3f} N", T, X, Y)).splitlines()
    mapping = mapping_of(
        {
            "columns": {
                "time_s": {"column": "t"},
                "tension_in_n": {"column": "Fin", "unit": "N"},
                "tension_out_n": {"column": "Fout", "unit": "N"},
            },
            "constants": {"system": "act"},
        },
        "here",
    )
    text = text[:1] + 12 * text[1:]
    text[2500] = text[2500].rpartition(",")[0] + ",950 mN"
    (tmp_path / "act.csv").write_text("\n".join(text) + "\n")
    with pytest.raises(SstlError, match="line 2501"):
        list(run([tmp_path / "act.csv"], mapping).runs)


def test_another_unit_in_the_name_is_asked(tmp_path: Path) -> None:
    _, found = proposed(tmp_path / "act.csv", "Time (s),Fin (N),Fout (N)\n" + lines("{:.3f},{:.4f} lbf,{:.4f} lbf", T, X, Y))
    assert all("its name says N" in q.text for q in found.questions) and len(found.questions) == 2


def test_labels_of_text_keep_their_units(tmp_path: Path) -> None:
    text = "time_s,tension_in_n,tension_out_n,config_id\n" + "".join(
        f"{t:.3f},{x:.4f},{y:.4f},30deg\n" for t, x, y in zip(T, X, Y, strict=True)
    )
    (tmp_path / "act.csv").write_text(text)
    [one] = run([tmp_path / "act.csv"], mapping_of({"constants": {"system": "act"}}, "here")).runs
    assert one.config_id == "30deg"


def test_a_log_of_a_serial_monitor_is_followed(tmp_path: Path) -> None:
    (tmp_path / "act.txt").write_text(lines(" -> Fin:{:.3f},Fout:{:.3f}", X, Y, stamp="%H:%M:%S.%f"))
    columns = {"time_s": "stamp", "tension_in_n": {"column": "Fin", "unit": "N"}, "tension_out_n": {"column": "Fout", "unit": "N"}}
    follower = TextFollower(tmp_path / "act.txt", mapping_of({"columns": columns, "constants": {"system": "act"}}, "here"))
    [one] = list(follower.look(True))
    np.testing.assert_allclose(one.tension_in_n, X, atol=6e-4)
    np.testing.assert_allclose(one.time_s - one.time_s[0], T, atol=1.1e-3)


def test_a_clock_in_two_columns_is_followed(tmp_path: Path) -> None:
    text = "sec,nanosec,Fin,Fout\n" + "".join(
        f"{int(7 + t)},{round(1e9 * (t % 1))},{x:.4f},{y:.4f}\n" for t, x, y in zip(T, X, Y, strict=True)
    )
    (tmp_path / "act.txt").write_text(text)
    time = {"column": "sec", "unit": "s", "fraction": "nanosec", "fraction_unit": "ns"}
    columns = {"time_s": time, "tension_in_n": {"column": "Fin", "unit": "N"}, "tension_out_n": {"column": "Fout", "unit": "N"}}
    mapping = mapping_of({"columns": columns, "constants": {"system": "act"}}, "here")
    [one] = list(TextFollower(tmp_path / "act.txt", mapping).look(True))
    np.testing.assert_allclose(one.time_s, 7 + T, atol=1e-6)


def test_a_fraction_belongs_to_a_clock(tmp_path: Path) -> None:
    with pytest.raises(SstlError, match="'fraction' on tension_in_n"):
        mapping_of({"columns": {"tension_in_n": {"column": "Fin", "fraction": "nanosec"}}}, "here")


@pytest.mark.parametrize(
    ("stamp", "between"),
    [
        ("%Y-%m-%d %H:%M:%S,%f", " INFO rig: Fin={:.3f} Fout={:.3f}"),
        ("%H:%M:%S.%f", ", Fin: {:.3f}, Fout: {:.3f}"),
        ("%Y-%m-%d %H:%M:%S.%f", " Fin: {:.3f} N Fout: {:.3f} N"),
    ],
)
def test_a_stamp_and_words_may_stand_in_front_of_labels(stamp: str, between: str, tmp_path: Path) -> None:
    columns, found = proposed(tmp_path / "act.log", lines(between, X, Y, stamp=stamp))
    assert columns["time_s"] == {"column": "stamp", "unit": "s"}
    assert (columns["tension_in_n"]["column"], columns["tension_out_n"]["column"]) == ("Fin", "Fout")
    one = imported(tmp_path / "act.log", found)
    np.testing.assert_allclose(one.tension_out_n, Y, atol=6e-4)
    np.testing.assert_allclose(one.time_s - one.time_s[0], T, atol=1.1e-3)


def test_a_date_and_a_time_in_front_of_cells_are_one_stamp(tmp_path: Path) -> None:
    columns, found = proposed(tmp_path / "act.log", lines(" {:.3f},{:.3f}", X, Y, stamp="%Y-%m-%d %H:%M:%S.%f"))
    assert columns["time_s"] == {"column": "stamp", "unit": "s"}
    np.testing.assert_allclose(imported(tmp_path / "act.log", found).tension_in_n, X, atol=6e-4)


def test_labels_may_hold_numbers(tmp_path: Path) -> None:
    columns, _ = proposed(tmp_path / "act.log", lines("Cell 1: {:.0f} Cell 2: {:.0f}", 1e3 * X, 1e3 * Y))
    assert (columns["tension_in_n"]["column"], columns["tension_out_n"]["column"]) == ("Cell 1", "Cell 2")


@pytest.mark.parametrize("later", [0.0, 0.37])
def test_two_clocks_in_two_columns_each_are_two_clocks(later: float, tmp_path: Path) -> None:
    other = later + (1.25 if later else 1.0) * T
    nano = np.round(1e9 * np.array([7.25 + T, 7.25 + other])).astype(np.int64)
    text = "in_stamp_sec,in_stamp_nanosec,Fin_N,out_stamp_sec,out_stamp_nanosec,Fout_N\n" + "".join(
        f"{a // 10**9},{a % 10**9},{x:.4f},{b // 10**9},{b % 10**9},{y:.4f}\n"
        for a, x, b, y in zip(nano[0], X, nano[1], np.interp(other, T, Y), strict=True)
    )
    columns, found = proposed(tmp_path / "act.csv", text)
    assert columns["time_s"] == {"column": "in_stamp_sec", "unit": "s", "fraction": "in_stamp_nanosec", "fraction_unit": "ns"}
    own = {k: columns["tension_out_n"].get(k) for k in ("time", "fraction")}
    assert own == ({"time": "out_stamp_sec", "fraction": "out_stamp_nanosec"} if later else {"time": None, "fraction": None})
    one = imported(tmp_path / "act.csv", found)
    np.testing.assert_allclose(one.tension_out_n, np.interp(one.time_s - 7.25, T, Y), atol=0.05)


def test_two_headerless_wrenches_of_ros_are_a_pair_on_the_clocks_of_two_columns(tmp_path: Path) -> None:
    files = [tmp_path / "ft_in.csv", tmp_path / "ft_out.csv"]
    for path, force, late in zip(files, (X, Y), (0, 1000), strict=True):
        stamps = 1715682153 * 10**9 + np.round(1e9 * (0.123 + T)).astype(np.int64) + late
        path.write_text("".join(f"{s // 10**9},{s % 10**9},ft,0.1,-0.2,{f:.4f},0.0,0.0,0.0\n" for s, f in zip(stamps, force, strict=True)))
    found = guess(files)
    columns = tomllib.loads(found.toml)["columns"]
    assert columns["time_s"]["fraction"] == columns["tension_out_n"]["fraction"] == "col2"
    assert {q.target for q in found.questions} == {"time_s", "tension_in_n", "tension_out_n", "system"}
    (tmp_path / "rig.toml").write_text(found.toml.replace("(?)", ""))
    [one] = run(files, read_mapping(tmp_path / "rig.toml")).runs
    at = one.time_s - 1715682153.123
    np.testing.assert_allclose(one.tension_in_n, np.interp(at, T, X), atol=2e-3)
    np.testing.assert_allclose(one.tension_out_n, np.interp(at, T, Y), atol=2e-3)
    np.testing.assert_allclose(np.diff(at), np.diff(T)[0], atol=1e-6)
