"""What columns, runs and systems are called by other loggers and in other languages."""

from __future__ import annotations

import tomllib
from pathlib import Path

import h5py
import pytest
from header_table import T, X, Y, rows
from proposals import proposed

from sstl_cli.importers.guess import guess
from sstl_cli.importers.guess_names import said
from sstl_cli.importers.mapping import mapping_of
from sstl_cli.steps.import_ import run


def runs_file(path: Path, systems: tuple[str, ...]) -> Path:
    """Write a group for each system, which its attribute tells."""
    with h5py.File(path, "w") as file:
        for k, system in enumerate(systems):
            group = file.create_group(f"Test {k + 1}")
            group.attrs["System"] = system
            for name, values in (("time_s", T), ("Fin_N", (k + 1) * X), ("Fout_N", Y)):
                group[name] = values
    return path


def test_words_for_systems_are_read_in_every_group(tmp_path: Path) -> None:
    path = runs_file(tmp_path / "bend30.h5", ("actuation", "sensing loop"))
    found = guess([path])
    [asked] = [q for q in found.questions if q.target == "system"]
    assert "'actuation' as act and 'sensing loop' as sstl" in asked.text
    toml = "\n".join(line.partition("  # (?)")[0] for line in found.toml.split("\n"))
    held = {r.system: float(r.tension_in_n.max()) for r in run([path], mapping_of(tomllib.loads(toml), "test")).runs}
    assert set(held) == {"act", "sstl"} and held["sstl"] > 1.9 * held["act"]


def test_a_word_of_another_group_that_is_no_system_is_asked(tmp_path: Path) -> None:
    found = guess([runs_file(tmp_path / "bend30.h5", ("act", "calibration"))])
    assert [q.text for q in found.questions if q.target == "system" and "'calibration', neither" in q.text]
    assert not guess([runs_file(tmp_path / "bend30.h5", ("act", "sstl"))]).questions


@pytest.mark.parametrize("run_in_front", ["Data Set 1:", "Latest: ", "Run 12: "])
def test_a_run_in_front_of_a_colon_is_no_word_of_the_channel(run_in_front: str, tmp_path: Path) -> None:
    names = ",".join(f'"{run_in_front}{n}"' for n in ("Time (s)", "Force In (N)", "Force Out (N)"))
    _, found = proposed(tmp_path / "act_bend30.csv", f"{names}\n" + rows(T, X, Y))
    assert not found.questions and f'"{run_in_front}Force In (N)"' in found.toml
    # a side in front of a colon is one
    assert said("Motor: Force (N)").side == "in"


@pytest.mark.parametrize("form", ["Run {k}: {n}", "{n} Run #{k}"])
def test_runs_side_by_side_are_no_tendons(form: str, tmp_path: Path) -> None:
    names = ",".join(form.format(k=k, n=n) for k in (1, 2) for n in ("Time (s)", "Force In (N)", "Force Out (N)"))
    _, found = proposed(tmp_path / "act_bend30.csv", f"{names}\n" + rows(T, X, Y, T, X, Y))
    assert ("runs side by side" in found.toml or r"runs = 'Run \d+: '" in found.toml) and "tendon" not in found.toml


@pytest.mark.parametrize(("name", "scale"), [("ms", 1e3), ("us", 1e6), ("micros", 1e6), ("millis", 1e3)])
def test_a_clock_called_by_its_unit_goes_before_the_stamp_of_a_monitor(name: str, scale: float, tmp_path: Path) -> None:
    stamps = [f"10:22:{30 + int(t)}.{int(1000 * t) % 1000:03d}" for t in T[T < 29]]
    body = "".join(f"{s} -> {t * scale:.0f},{x:.3f},{y:.3f}\n" for s, t, x, y in zip(stamps, T, X, Y, strict=False))
    _, found = proposed(tmp_path / "act_bend30.txt", f"10:22:29.900 -> {name},Fin_N,Fout_N\n{body}")
    assert f'time_s = {{ column = "{name}", unit = "{"us" if scale > 1e4 else "ms"}" }}\n' in found.toml
    assert any("of several clocks ('stamp' too)" in r for r in found.reasons)


@pytest.mark.parametrize("encoding", ["cp1251", "utf-8"])
def test_russian_names_and_units_are_read(encoding: str, tmp_path: Path) -> None:
    text = "Время, мс;Натяжение на выходе, Н;Усилие на входе, мН\n" + rows(1000 * T, Y, 1000 * X, sep=";", digits=1)
    (tmp_path / "act_bend30.csv").write_bytes(text.encode(encoding))
    found = guess([tmp_path / "act_bend30.csv"])
    columns = tomllib.loads(found.toml)["columns"]
    assert not found.questions and columns["time_s"] == {"column": "Время, мс", "unit": "ms"}
    assert columns["tension_in_n"] == {"column": "Усилие на входе, мН", "unit": "mN"}
    assert columns["tension_out_n"] == {"column": "Натяжение на выходе, Н", "unit": "N"}


def test_questions_name_the_columns_of_an_unknown_language(tmp_path: Path) -> None:
    _, found = proposed(tmp_path / "act_bend30.csv", "aika_in,eka,toka\n" + rows(T, X, Y))
    texts = {q.target: q.text for q in found.questions}
    assert "'aika_in' runs forward" in texts["time_s"]


def test_a_channel_that_is_called_measured_wins_over_the_same_without_that_word(tmp_path: Path) -> None:
    columns, found = proposed(tmp_path / "act_bend30.csv", "time_s,T_in_N,T_in_meas_N,T_out_N\n" + rows(T, X + 1, X, Y))
    assert columns["tension_in_n"]["column"] == "T_in_meas_N" and not found.questions


def test_a_clock_that_runs_backward_is_said_to(tmp_path: Path) -> None:
    columns, found = proposed(tmp_path / "act_bend30.csv", "Time (s),Fin (N),Fout (N)\n" + rows(T[::-1], X, Y))
    assert columns["time_s"] == {"rate_hz": 0} and "'Time (s)' runs backward" in found.questions[0].text


def test_a_force_with_the_unit_of_something_else_is_named(tmp_path: Path) -> None:
    _, found = proposed(tmp_path / "act_bend30.csv", "Time (s),Fin (m),Fout (m)\n" + rows(T, X, Y))
    assert "'Fin (m)' is called a force, and has the unit m" in found.toml
