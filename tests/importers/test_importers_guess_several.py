"""Proposals for several files: a line that is right for the first and not for another says so, and file names tell the side."""

from __future__ import annotations

import tomllib
from pathlib import Path

import numpy as np
import pytest
from header_table import N, T, X, Y, rows
from test_importers_guess import answered

from sstl_cli.importers.guess import guess
from sstl_cli.importers.mapping import read_mapping
from sstl_cli.steps.import_ import run

FORCES = ("tension_in_n", "tension_out_n")
SIDES = {
    "a units row": ("Time,Fin,Fout\ns,N,N\n", "Time,Fin,Fout\nms,mN,mN\n", 1e3, 1e3, ("time_s", *FORCES)),
    "kgf in a units row": ("Time,Fin,Fout\ns,N,N\n", "Time,Fin,Fout\ns,kgf,kgf\n", 1, 0.1, FORCES),
    "other columns beside": ("Time,Fin,Fout\ns,N,N\n", "Time,Fin,Fout,Mode\ns,N,mN,\n", 1, 1e3, ("tension_out_n",)),
    "a clock in ms": ("Time,Fin (N),Fout (N)\n", "Time,Fin (N),Fout (N)\n", 1e3, 1, ("time_s",)),
    "another step of no stated unit": ("Time,Fin (N),Fout (N)\n", "Time,Fin (N),Fout (N)\n", 10, 1, ("time_s",)),
    "another sign": ("Time (s),Fin (N),Fout (N)\n", "Time (s),Fin (N),Fout (N)\n", 1, -1, FORCES),
    "another rate of a stated unit": ("Time (s),Fin (N),Fout (N)\n", "Time (s),Fin (N),Fout (N)\n", 10, 1, ()),
}


@pytest.mark.parametrize("case", SIDES)
def test_a_file_that_says_something_else_is_named(case: str, tmp_path: Path) -> None:
    head, other, slower, scale, expected = SIDES[case]
    files = [tmp_path / "act_bend20.csv", tmp_path / "act_bend40.csv"]
    files[0].write_text(head + rows(T, X, Y))
    more = ("1",) if "Mode" in other else ()
    files[1].write_text(other + rows(slower * T, X if more else scale * X, scale * Y, *more))
    found = guess(files)
    assert {q.target for q in found.questions} == set(expected)
    assert all("'act_bend40.csv'" in q.text for q in found.questions)


def test_rates_that_headers_state_are_compared(tmp_path: Path) -> None:
    files = []
    for bend, step in ((20, 0.01), (40, 0.002)):
        head = f"LabVIEW Measurement\nX_Columns\tNo\n***End_of_Header***\n\nChannels\t2\nY_Unit_Label\tN\tN\nX_Dimension\tTime\tTime\nDelta_X\t{step}\t{step}\n"
        files.append(tmp_path / f"act_bend{bend}.lvm")
        files[-1].write_text(head + "***End_of_Header***\nX_Value\tFin\tFout\tComment\n" + rows("", X, Y, sep="\t"))
    [question] = guess(files).questions
    assert question.target == "time_s" and "'act_bend40.lvm' gives { rate_hz = 500 }" in question.text


def test_pairs_that_differ_are_named(tmp_path: Path) -> None:
    files = []
    for take, unit in ((1, "N"), (2, "mN")):
        for side, values in (("motor", X), ("tip", Y)):
            files.append(tmp_path / f"{side}_act_{take}.csv")
            files[-1].write_text(f"Time,Force\ns,{unit if side == 'tip' else 'N'}\n" + rows(T, values))
    [question] = guess(files).questions
    assert question.target == "tension_out_n" and "'tip_act_2.csv' gives" in question.text


def test_the_axes_of_messages_written_flat_are_those_of_their_force(tmp_path: Path) -> None:
    head = "rosbagTimestamp,header,seq,secs,nsecs,frame_id,wrench,force,x,y,z,torque,x,y,z\n"
    files = [tmp_path / f"_slash_ft_{side}_slash_wrench_sstl_bend060.csv" for side in ("proximal", "distal")]
    for path, values in zip(files, (X, Y), strict=True):
        stamps = [f"{1763633703250000000 + 10_000_000 * i}" for i in range(N)]
        body = rows(T, "", np.arange(N), "ft", "", "", X / 100, X / 90, values, "", X / 50, X / 40, 2 * values).splitlines()
        path.write_text(
            head + "".join(f"{s},,{i},{s[:10]},{s[10:]},{b.split(',', 3)[3]}\n" for i, (s, b) in enumerate(zip(stamps, body, strict=True)))
        )
    found = guess(files)
    columns = tomllib.loads(found.toml)["columns"]
    assert {columns[t]["column"] for t in FORCES} == {"z.1"} and 'merge = "channels"' in found.toml
    assert 'system = "sstl"' in found.toml and 'config_id = "060"' in found.toml
    assert {q.target for q in found.questions} == set(FORCES)


@pytest.mark.parametrize("above", ["", "# system: act\n"])
def test_what_stands_behind_the_side_of_one_pair_gives_labels(above: str, tmp_path: Path) -> None:
    files = [tmp_path / f"F_{side}_sstl_bend60.csv" for side in ("in", "out")]
    for path, values in zip(files, (X, Y), strict=True):
        path.write_text(above + "Time (s),Force (N)\n" + rows(T, values))
    found = guess(files)
    assert 'system = "sstl"' in found.toml and 'config_id = "60"' in found.toml
    assert [q.target for q in found.questions] == (["system"] if above else [])


@pytest.mark.parametrize("names", [("motorside_act", "tipside_act"), ("act_proximal", "act_distal")])
def test_axes_of_one_sensor_a_side_are_asked(names: tuple[str, str], tmp_path: Path) -> None:
    files = []
    for name, values in zip(names, (X, Y), strict=True):
        files.append(tmp_path / f"{name}.csv")
        files[-1].write_text("time (s),force.x (N),force.y (N),force.z (N)\n" + rows(T, 0.01 * values, 0.02 * values, values))
    found = guess(files)
    assert {q.target for q in found.questions} == set(FORCES) and 'merge = "channels"' in found.toml
    assert all("or 'force.x (N)', 'force.y (N)'?" in q.text for q in found.questions)
    [one] = run(files, answered(found.toml.replace("(?)", ""), tmp_path)).runs
    np.testing.assert_allclose((one.tension_in_n, one.tension_out_n), (X, Y), atol=1e-5)
    assert len(one) == N


@pytest.mark.parametrize(
    ("names", "head", "asked"),
    [
        (("tension_in.csv", "tension_out.csv"), "timestamp,data\n", False),
        (("LC_in_act_run1.txt", "LC_out_act_run1.txt"), "", False),
        (("rig_motor.csv", "rig_tip.csv"), "Time (s),value\n", True),
    ],
)
def test_one_channel_without_a_name_is_that_of_the_side_in_the_files_name(
    names: tuple[str, str], head: str, asked: bool, tmp_path: Path
) -> None:
    """A file with an unnamed channel was said to hold no tension, and the side in its name was taken for a bend."""
    files = [tmp_path / n for n in names]
    for path, values in zip(files, (X, Y), strict=True):
        path.write_text(head + rows(T, values).replace(",", "," if path.suffix == ".csv" else "\t"))
    found = guess(files)
    assert 'merge = "channels"' in found.toml and "config_id" not in found.toml
    assert any("is this a tension?" in q.text for q in found.questions) is asked
    [one] = run(files, answered(found.toml.replace("(?)", ""), tmp_path)).runs
    np.testing.assert_allclose((one.tension_in_n, one.tension_out_n), (X, Y), atol=1e-5)


def test_one_channel_that_is_no_tension_makes_no_pair(tmp_path: Path) -> None:
    files = [tmp_path / "rig_in.csv", tmp_path / "rig_out.csv"]
    for path in files:
        path.write_text("Time (s),Winkel (deg)\n" + rows(T, X))
    assert "merge" not in guess(files).toml


def test_two_files_of_one_tension_each_are_asked_which_holds_the_input(tmp_path: Path) -> None:
    files = [tmp_path / "F0001CH2.csv", tmp_path / "F0001CH1.csv"]
    for path, v in zip(files, (Y, X), strict=True):
        path.write_text("TIME,CH\ns,N\n" + rows(T, v))
    found = guess(files)
    asked = {q.target: q.text for q in found.questions}
    assert "'F0001CH1.csv' the input" in asked["tension_in_n"] and "'F0001CH2.csv' the output" in asked["tension_out_n"]
    (tmp_path / "rig.toml").write_text(found.toml.replace("(?)", ""))
    [one] = run(files, read_mapping(tmp_path / "rig.toml")).runs
    np.testing.assert_allclose(one.tension_in_n, X, atol=2e-3)
    np.testing.assert_allclose(one.tension_out_n, Y, atol=2e-3)
