"""Proposals for several files: labels from names, files that hold one side each, and lines that import asks for."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from header_table import N, T, X, Y, rows

from sstl_cli.core.errors import SstlError
from sstl_cli.importers.guess import guess
from sstl_cli.importers.guess_files import name_pattern
from sstl_cli.importers.guess_names import said
from sstl_cli.importers.inline import inline_mapping, targets_of
from sstl_cli.importers.mapping import Mapping, read_mapping
from sstl_cli.steps.import_ import run


def answered(toml: str, folder: Path, answers: str = "system=act") -> Mapping:
    """Return the proposed mapping with the questions answered on the command line."""
    (folder / "rig.toml").write_text(toml)
    return inline_mapping(answers, read_mapping(folder / "rig.toml", targets_of(answers)))


def test_labels_from_names_of_several_files(tmp_path: Path) -> None:
    files = []
    for place, bend, system in (("CP", 40, "act"), ("CP", 40, "sstl"), ("ND", 60, "act")):
        files.append(tmp_path / f"{place}_{bend:03d}_{system}_run1.csv")
        files[-1].write_text("Time (s),Motor (N),Tip (N)\n" + rows(T, X, Y))
    found = guess(files)
    assert not found.questions
    (tmp_path / "rig.toml").write_text(found.toml)
    runs = list(run(files, read_mapping(tmp_path / "rig.toml")).runs)
    assert [(r.location, r.config_id, r.system) for r in runs] == [
        ("CP", "CP-040", "act"),
        ("CP", "CP-040", "sstl"),
        ("ND", "ND-060", "act"),
    ]
    np.testing.assert_allclose(runs[0].tension_in_n, X, atol=1e-5)


@pytest.mark.parametrize("takes", [1, 3])
def test_two_files_with_one_side_each_are_merged(takes: int, tmp_path: Path) -> None:
    files = []
    for take in range(takes):
        for side, values in (("motor", X), ("tip", Y + take)):
            files.append(tmp_path / f"{side}_{take}.csv")
            files[-1].write_text("t [s],Force [lbf]\n" + rows(T, values))
    found = guess(files)
    assert [q.target for q in found.questions] == ["system"]
    runs = list(run(files, answered(found.toml, tmp_path)).runs)
    assert len(runs) == takes and all(len(r) == N for r in runs)
    for take, one in enumerate(runs):
        np.testing.assert_allclose(one.tension_out_n, 4.4482216152605 * (Y + take), atol=1e-3)


def test_one_tension_only_proposes_the_other_file(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text("Time [s],Stroke_Ref [mm],Tension [N]\n" + rows(T, X, Y))
    found = guess([path])
    # beside the command of a motion it likely is the output, but a rig may record its input alone
    assert (
        'merge = "channels"' in found.toml
        and 'tension_out_n = { column = "Tension [N]", unit = "N" }  # (?) is this the output' in found.toml
    )
    assert {q.target for q in found.questions} == {"tension_in_n", "tension_out_n", "system"}


def test_import_asks_for_every_open_line(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text("Sample,adc_motor,adc_tip\n" + rows(np.arange(N), np.round(100 * X), np.round(100 * Y), digits=0))
    found = guess([path])
    assert [q.target for q in found.questions] == ["time_s", "tension_in_n", "tension_out_n", "system"]
    assert found.toml.count('unit = "counts"') == 2
    with pytest.raises(SstlError, match=r"line 5 still asks: time_s.*and 3 more, lines 6, 7, 10"):
        answered(found.toml, tmp_path, "config_id=a")
    # a mark deleted without an answer is still not taken for newtons
    bare = "\n".join(line.partition("# (?)")[0] for line in found.toml.splitlines())
    with pytest.raises(SstlError, match=r"rate_hz.*greater than 0"):
        answered(bare, tmp_path)
    with pytest.raises(SstlError, match=r"counts needs a gain.*gain = G, offset = Z"):
        list(run([path], answered(bare.replace("rate_hz = 0", "rate_hz = 100"), tmp_path)).runs)


def test_unreadable_and_unlike_files_are_named(tmp_path: Path) -> None:
    for name, head in (("a", "t [s],Fin [N],Fout [N]"), ("b", "t [s],Fin [N],Fout [N]"), ("c", "t [s],Weg [mm],Fin [N]")):
        (tmp_path / f"{name}.csv").write_text(head + "\n" + rows(T, X, Y))
    (tmp_path / "d.csv").write_text("")
    found = guess([tmp_path / f"{n}.csv" for n in "abcd"])
    assert any("'c.csv' has other channels" in r for r in found.reasons)
    assert any("d.csv: is empty" in r for r in found.reasons)


@pytest.mark.parametrize(
    ("stems", "pattern"),
    [
        (["bend_030_run1", "bend_060_run2"], r"^bend_(?P<config_id>\d+)_"),
        (["lead3.5mm", "lead4mm"], r"^lead(?P<lead_mm>\d+(?:\.\d+)?)mm"),
        (["20240301_101500", "20240301_103000"], ""),
        (["a1", "b-2"], ""),
    ],
)
def test_patterns_of_names(stems: list[str], pattern: str) -> None:
    assert name_pattern(stems).pattern == pattern


@pytest.mark.parametrize(
    ("stem", "question"),
    [
        ("act_0.5mm_bend60", "lead of a screw"),
        ("act_bend3p5", "3p5 one number"),
        ("act_bend-30", "its sign"),
        ("act_roll90deg", "roll of something else"),
        ("act_0deg_to_90deg", "90 may be the config_id too"),
        ("act_lead0.5mm_bend60", ""),
        ("act-bend-30-run1", ""),
        ("act_30deg_s1", ""),
    ],
)
def test_a_part_of_the_name_that_may_be_something_else_is_asked(stem: str, question: str) -> None:
    found = name_pattern([stem])
    assert question in found.question and bool(question) == bool(found.question) and "config_id" in found.labels


@pytest.mark.parametrize("stem", ["act_60deg_per_s", "act_60deg_s", "act_60deg_sec"])
def test_a_speed_is_no_bend(stem: str) -> None:
    assert name_pattern([stem]).labels == ("system",)


@pytest.mark.parametrize("stem", ["sstl_vs_act_bend30", "bend30_des_act", "ref_act_bend30", "act_cmd_bend30", "bend30_actual_act"])
def test_act_beside_other_words_need_not_be_the_system(stem: str) -> None:
    assert name_pattern([stem]).labels == ("config_id",)
    # where others say sstl in its place it is
    assert name_pattern(["ref_act_bend30", "ref_sstl_bend30"]).labels == ("system", "config_id")


def test_an_unknown_part_of_the_name_is_asked() -> None:
    assert "bending configuration" in name_pattern(["KDN_1bar", "KDN_5bar"]).question


@pytest.mark.parametrize(
    ("name", "quantity", "side", "unit", "tension"),
    [
        ("F_in", "force", "in", "", True),
        ("Ausgangskraft in N", "force", "out", "N", True),
        ("tensión de salida [N]", "force", "out", "N", True),
        ("Motor current (A)", "current", "in", "", False),
        ("Sollkraft [N]", "force", "", "N", False),
        ("Force rate [N/s]", "force", "", "", False),
        ("F_min", "force", "", "", True),
        ("lc_in_g", "force", "in", "g", True),
        ("LC2 [kgf]", "force", "", "kgf", True),
    ],
)
def test_what_names_say(name: str, quantity: str, side: str, unit: str, tension: bool) -> None:
    found = said(name)
    assert (found.quantity, found.side, found.unit, found.tension) == (quantity, side, unit, tension)


@pytest.mark.parametrize(("name", "unit"), [("t_s", "s"), ("t_ms", "ms"), ("T ms", "ms")])
def test_a_short_clock_with_its_unit_is_a_clock(name: str, unit: str) -> None:
    found = said(name)
    assert (found.quantity, found.unit) == ("time", unit)
    # a letter alone says time, with a side it is a tension
    assert said("T_s_out").quantity != "time" and said("T_in").quantity == "force"


def pairs(folder: Path, names: str) -> list[Path]:
    """Write two pairs: unix time and N on the motor's side, milliseconds from zero and mN at the tip."""
    files = []
    for bend in (20, 40):
        for side in ("motor", "tip"):
            files.append(folder / names.format(side=side, bend=bend))
        files[-2].write_text("time,Force (N)\n" + rows(1.718e9 + T, X, digits=4))
        files[-1].write_text("t;Force [mN]\n" + rows(1000 * T, 1000 * Y, sep=";", digits=2))
    return files


@pytest.mark.parametrize("names", ["{side}_NP_{bend:03d}mm_{bend}.csv", "NP_{bend:03d}mm_{side}.csv"])
def test_names_of_pairs_give_labels_too(names: str, tmp_path: Path) -> None:
    files = pairs(tmp_path, names)
    toml = guess(files).toml.replace("# (?)", "#")
    (tmp_path / "rig.toml").write_text(toml)
    runs = list(run(files, read_mapping(tmp_path / "rig.toml")).runs)
    assert [(r.location, r.lead_mm, len(r)) for r in runs] == [("NP", 20.0, N), ("NP", 40.0, N)]


def test_clocks_of_a_pair_are_asked_for(tmp_path: Path) -> None:
    found = guess(pairs(tmp_path, "{side}_{bend}.csv"))
    assert {q.target for q in found.questions} == {"tension_out_n", "system", "align"}
    assert "its time: no unit is stated: ms fits steps of 4" in found.toml
    (tmp_path / "rig.toml").write_text(found.toml)
    with pytest.raises(SstlError, match="still asks.*the clocks never meet"):
        read_mapping(tmp_path / "rig.toml", ["tension_out_n", "system"])


def test_the_path_of_a_block_diagram_is_no_clock(tmp_path: Path) -> None:
    for name, side in (("Model Root/TendonPlant/T_in [N]", "in"), ("Model Root/TendonPlant/T_out [N]", "out")):
        assert (said(name).quantity, said(name).side, said(name).tension) == ("force", side, True)
    log = tmp_path / "dspace.csv"
    log.write_text("Model Root/Time,Model Root/TendonPlant/T_in [N],Model Root/TendonPlant/T_out [N]\n" + rows(T, X, Y))
    found = guess([log])
    assert 'tension_in_n = { column = "Model Root/TendonPlant/T_in [N]", unit = "N" }\n' in found.toml
    assert len(found.questions) == 1


@pytest.mark.parametrize(
    ("encoding", "names"), [("gb2312", "时间(s),输入张力(N),输出张力(N)"), ("latin-1", "Zeit (s),Kraft Gerät (N),Prüfkraft (N)")]
)
def test_a_header_in_an_older_encoding_is_read_as_it_was_written(tmp_path: Path, encoding: str, names: str) -> None:
    log = tmp_path / "old.csv"
    log.write_bytes((names + "\n" + rows(T, X, Y)).encode(encoding))
    toml = guess([log]).toml
    assert all(f'"{name}"' in toml for name in names.split(","))


@pytest.mark.parametrize(("first", "second", "turned"), [(-1, 1, 1), (-1, -1, 2), (1, 1, 0)])
def test_a_tension_that_reads_negative_throughout_is_asked(first: int, second: int, turned: int, tmp_path: Path) -> None:
    path = tmp_path / "act.csv"
    path.write_text("Time (s),Fin (N),Fout (N)\n" + rows(T, first * X, second * Y))
    found = guess([path])
    assert found.toml.count("sign = -1 }  # (?) negative throughout") == turned == len(found.questions)
    [one] = run([path], answered(found.toml.replace("(?)", ""), tmp_path, "system=act")).runs
    np.testing.assert_allclose(one.tension_in_n, X, atol=1e-5)
