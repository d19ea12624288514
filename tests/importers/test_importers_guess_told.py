"""What files say of channels beside their names: structs of ControlDesk, lists of names, rates as a number, rows that say what they hold."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import numpy as np
import pytest
from header_table import N, T, X, Y, rows
from scipy.io import savemat

from sstl_cli.core.runs import Run
from sstl_cli.importers.guess import Guess, guess
from sstl_cli.importers.guess_files import name_pattern, shared_labels
from sstl_cli.importers.mapping import read_mapping
from sstl_cli.importers.pattern import search
from sstl_cli.steps.import_ import run

LBF, GF = 4.4482216, 9.80665e-3
EPOCH = 1_709_647_331


def imported(path: Path, found: Guess) -> Run:
    """Return the run that a proposal gives once its marks are deleted."""
    mapping = path.with_name("rig.toml")
    mapping.write_text(re.sub(r"  # \(\?\).*", "", found.toml))
    [one] = run([path], read_mapping(mapping)).runs
    return one


def in_newtons_and_seconds(path: Path, found: Guess) -> None:
    one = imported(path, found)
    np.testing.assert_allclose(one.tension_in_n, X, atol=2e-3)
    np.testing.assert_allclose(one.tension_out_n, Y, atol=2e-3)
    assert np.median(np.diff(one.time_s)) == pytest.approx(0.004, abs=1e-6)


def targets(found: Guess) -> set[str]:
    return {q.target for q in found.questions}


def log(folder: Path, text: str) -> tuple[Path, Guess]:
    path = folder / "log.csv"
    path.write_text(text)
    return path, guess([path])


def records(*fields: dict[str, object]) -> np.ndarray:
    return np.array([[tuple(f.values()) for f in fields]], dtype=[(k, object) for k in fields[0]])


@pytest.mark.parametrize(("unit", "factor"), [("N", 1.0), ("lbf", LBF)])
def test_the_structs_of_controldesk_say_what_their_data_are(unit: str, factor: float, tmp_path: Path) -> None:
    names = ("Model Root/ref", "Model Root/Force out/Out1", "Model Root/Force in/Out1")
    signals = [{"Name": n, "Data": v[None] / factor, "Unit": unit} for n, v in zip(names, (X[::-1], Y, X), strict=True)]
    clock = {"Name": "time", "Data": T[None], "Unit": "s"}
    savemat(tmp_path / "rec.mat", {"rec_1": {"X": records(clock), "Y": records(*signals), "RTProgram": "rig.sdf"}})
    found = guess([tmp_path / "rec.mat"])
    columns = tomllib.loads(found.toml)["columns"]
    assert columns["tension_in_n"] == {"column": "rec_1.Y(3).Data", "unit": unit} and targets(found) == {"system"}
    in_newtons_and_seconds(tmp_path / "rec.mat", found)


def test_a_list_of_names_tells_the_columns_of_the_one_matrix_that_it_fits(tmp_path: Path) -> None:
    names, units = np.array(["time", "F_out", "F_in"]), np.array(["s", "mN", "mN"])
    table = np.column_stack([T, 1e3 * Y, 1e3 * X])
    np.savez(tmp_path / "a.npz", data=table, names=names, units=units)
    found = guess([tmp_path / "a.npz"])
    assert targets(found) == {"system"}
    in_newtons_and_seconds(tmp_path / "a.npz", found)
    np.savez(tmp_path / "b.npz", data=table, pose=table[:, ::-1], names=names, units=units)
    assert {"time_s", "tension_in_n", "tension_out_n"} <= targets(guess([tmp_path / "b.npz"]))


@pytest.mark.parametrize(
    ("name", "value"), [("fs", 250), ("Fs", 250.0), ("sampleRate", 250.0), ("fs_kHz", 0.25), ("dt", 0.004), ("sampling_period_ms", 4.0)]
)
def test_a_rate_that_stands_beside_the_readings_as_a_number_is_asked(name: str, value: float, tmp_path: Path) -> None:
    np.savez(tmp_path / "a.npz", Fin_N=X, Fout_N=Y, **{name: np.array(value)})
    savemat(tmp_path / "a.mat", {"log": {"Fin_N": X, "Fout_N": Y}, "info": {name: value, "operator": "AB"}})
    for path in (tmp_path / "a.npz", tmp_path / "a.mat"):
        found = guess([path])
        assert targets(found) == {"system", "time_s"}
        in_newtons_and_seconds(path, found)


@pytest.mark.parametrize("line", ["# dt = 0.004 s", "# Abtastzeit: 4 ms", "# sampling interval = 4e-3 s"])
def test_a_period_above_the_table_is_asked(line: str, tmp_path: Path) -> None:
    path, found = log(tmp_path, f"{line}\nFin (N),Fout (N)\n" + rows(X, Y))
    assert targets(found) == {"system", "time_s"}
    in_newtons_and_seconds(path, found)


@pytest.mark.parametrize("numbers", [{"frequency": 2.0}, {"fs": 250.0, "sample_rate": 1000.0}])
def test_a_frequency_of_the_motion_and_rates_that_differ_are_no_rate(numbers: dict[str, float], tmp_path: Path) -> None:
    np.savez(tmp_path / "a.npz", Fin_N=X, Fout_N=Y, **numbers)  # type: ignore[arg-type]
    assert tomllib.loads(guess([tmp_path / "a.npz"]).toml)["columns"]["time_s"] == {"rate_hz": 0}


@pytest.mark.parametrize(("rate", "asks"), [(250.0, False), (251.0, False), (1000.0, True)])
def test_a_clock_that_runs_at_another_rate_than_the_file_states_is_asked(rate: float, asks: bool, tmp_path: Path) -> None:
    np.savez(tmp_path / "a.npz", time_s=T, Fin_N=X, Fout_N=Y, fs=rate)
    assert ("time_s" in targets(guess([tmp_path / "a.npz"]))) == asks


@pytest.mark.parametrize(
    "head",
    [
        # names, places in the model, units
        "Time,F_in,F_out\n,Platform()://Model Root/A/Out1,Platform()://Model Root/B/Out1\ns,lbf,lbf\n",
        "Time,F_in,F_out\nType: double,Type: double,Type: double\nUnits: s,Units: lbf,Units: lbf\nInterp: linear,Interp: linear,Interp: linear\n",
        "Time,F_in,F_out\n,Unit: lbf,Unit: lbf\n",
        "Time,F_in,F_out\nin s,in lbf,in lbf\n",
    ],
)
def test_rows_below_the_names_are_told_apart(head: str, tmp_path: Path) -> None:
    path, found = log(tmp_path, head + rows(T, X / LBF, Y / LBF))
    assert targets(found) == {"system"}
    in_newtons_and_seconds(path, found)


@pytest.mark.parametrize(
    "head",
    [
        "Name;Zeit;Kraft ein;Kraft aus\nEinheit;s;lbf;lbf\nBeschreibung;;Messdose 1;Messdose 2\n",
        "Kanalname:;Zeit;Kraft ein;Kraft aus\nEinheit:;s;lbf;lbf\nAbtastrate:;250;250;250\n",
        "Signal;Zeit;Kraft ein;Kraft aus\nPath;;Model Root/A;Model Root/B\nUnits;s;lbf;lbf\n",
    ],
)
def test_rows_that_say_in_their_first_cells_what_they_hold(head: str, tmp_path: Path) -> None:
    body = "".join(f";{line}\n" for line in rows(T, X / LBF, Y / LBF, sep=";", dec=",").splitlines())
    path, found = log(tmp_path, head + body)
    assert targets(found) == {"system"}
    in_newtons_and_seconds(path, found)


def test_a_waveform_s_start_and_step_above_its_names_are_no_readings(tmp_path: Path) -> None:
    head = "waveform\t[0]\t[1]\nt0\t14:02:11,123\t14:02:11,123\ndelta t\t0,004000\t0,004000\n\ntime[0]\tForce in (N)\tForce out (N)\n"
    path, found = log(tmp_path, head + rows(T, X, Y, sep="\t", dec=","))
    assert targets(found) == {"system"}
    in_newtons_and_seconds(path, found)


def test_the_header_of_a_message_is_its_time_and_its_count_whatever_sent_it(tmp_path: Path) -> None:
    stamps = np.round(1e9 * (0.5 + T)).astype(np.int64)
    head = "/lc_in/header/seq,/lc_in/header/stamp/secs,/lc_in/header/stamp/nsecs,/lc_in/force,/lc_out/header/seq,/lc_out/force\n"
    body = (
        f"{k + 7},{EPOCH + stamps[k] // 10**9},{stamps[k] % 10**9},{x:.4f},{k + 9},{y:.4f}\n"
        for k, (x, y) in enumerate(zip(X, Y, strict=True))
    )
    path, found = log(tmp_path, head + "".join(body))
    columns = tomllib.loads(found.toml)["columns"]
    assert columns["time_s"]["column"].endswith("secs") and columns["time_s"]["fraction"] == "/lc_in/header/stamp/nsecs"
    assert [columns[t]["column"] for t in ("tension_in_n", "tension_out_n")] == ["/lc_in/force", "/lc_out/force"]
    in_newtons_and_seconds(path, found)


@pytest.mark.parametrize(
    ("names", "sure"),
    [
        ("load_in_g,load_out_g", True),
        ("Fin_g,Fout_g", True),
        ("weight_in_gram,weight_out_gram", True),
        ("Gewicht Motor (g),Gewicht Spitze (g)", True),
        ("motor_g,tip_g", False),
        ("Fin_G,Fout_G", False),
        ("Proximal (g),Distal (g)", False),
    ],
)
def test_grams_are_grams_of_force_or_asked(names: str, sure: bool, tmp_path: Path) -> None:
    path, found = log(tmp_path, f"time_s,{names}\n" + rows(T, X / GF, Y / GF))
    assert targets(found) == ({"system"} if sure else {"system", "tension_in_n", "tension_out_n"})
    in_newtons_and_seconds(path, found)


def test_an_acceleration_in_g_is_no_tension(tmp_path: Path) -> None:
    _, found = log(tmp_path, "time_s,Fin (N),Fout (N),Vibration motor (g),Vibration tip (g)\n" + rows(T, X, Y, X / 10, Y / 10))
    assert targets(found) == {"system"}


@pytest.mark.parametrize(
    ("stems", "labels"),
    [
        (["sstlTin", "sstlTout"], {"system": "sstl"}),
        (["act_Fin", "act_Fout", "act_time"], {"system": "act"}),
        (["bend30_SSTLTin", "bend30_SSTLTout"], {"system": "SSTL", "config_id": "30"}),
        (["contactTin", "contactTout"], {}),
        (["ActForceIn", "ActForceOut"], {}),
    ],
)
def test_system_and_channel_in_one_word(stems: list[str], labels: dict[str, str]) -> None:
    assert dict(shared_labels(stems).constants) == labels


def test_the_system_in_one_word_with_what_follows() -> None:
    found = name_pattern(["actBend30Run1", "sstlBend60Run1"])
    assert not found.question
    assert search(found.pattern, ["sstlBend60Run1"]) == [{"system": "sstl", "config_id": "60"}]
    assert "'no' stands beside 'Sstl'" in name_pattern(["noSstlBend30"]).question


@pytest.mark.parametrize("names", ["sstlTin,sstlTout", "sstl_Fin,sstl_Fout"])
def test_the_system_in_the_names_of_both_tensions_is_proposed_and_asked(names: str, tmp_path: Path) -> None:
    _, found = log(tmp_path, f"time_s,{names}\n" + rows(T, X, Y))
    assert tomllib.loads(found.toml)["constants"]["system"] == "sstl" and "system" in targets(found)


@pytest.mark.parametrize(
    "stem", ["Bogen30_{}", "Bogen 30-{}", "Krümmung30_{}", "Krümmung30_{}", "arco30_{}", "Bogen30grad ({})", "bocht30_{}", "zakret30_0{}"]
)
def test_a_repeat_behind_a_bend_is_no_bend(stem: str) -> None:
    stems = [stem.format(k) for k in (1, 2)]
    found = name_pattern(stems)
    assert found.question and search(found.pattern, stems) == [{"config_id": "30"}] * 2


def test_what_does_not_count_may_be_a_bend() -> None:
    found = name_pattern(["rope3_20", "rope3_40"])
    assert found.question and search(found.pattern, ["rope3_40"]) == [{"config_id": "40"}]


def test_the_unit_of_a_bend_is_no_word_for_the_number_behind_it() -> None:
    stems = ["act_30deg_1", "act_30deg_2"]
    found = name_pattern(stems)
    assert "may be the config_id too" not in found.question
    assert search(found.pattern, stems) == [{"system": "act", "config_id": "30"}] * 2


def test_a_reading_with_a_word_in_a_column_that_is_empty_below_stays_one(tmp_path: Path) -> None:
    lines = rows(T, X, Y).splitlines()
    text = "Time (s),Fin (N),Fout (N),Event\n" + "".join(f"{line},{'' if k else 'start'}\n" for k, line in enumerate(lines))
    path, found = log(tmp_path, text)
    assert len(imported(path, found)) == N
