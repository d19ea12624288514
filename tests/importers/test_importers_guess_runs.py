"""Groups that each hold a whole run: one pattern for all, labels by their names and attributes, and what differs asked."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from pathlib import Path

import h5py
import numpy as np
import pytest
from header_table import T, X, Y
from nptdms import ChannelObject, GroupObject, RootObject, TdmsWriter
from scipy.io import savemat

from sstl_cli.core.runs import Run
from sstl_cli.importers.base import Layout
from sstl_cli.importers.guess import Guess, guess
from sstl_cli.importers.hdf5 import channels
from sstl_cli.importers.mapping import mapping_of
from sstl_cli.steps.import_ import run


def scaled(k: int) -> dict[str, np.ndarray]:
    """Return the channels of run ``k``, which tells itself by its size."""
    return {"time": T, "fin": (k + 1) * X, "fout": (k + 1) * Y}


def hdf5(path: Path, groups: Mapping[str, Mapping[str, object]], unit: str = "N", lack: str = "") -> Path:
    with h5py.File(path, "w") as file:
        for k, (name, attributes) in enumerate(groups.items()):
            group = file.create_group(name)
            group.attrs.update(attributes)
            for channel, values in scaled(k).items():
                if f"{name}/{channel}" != lack:
                    group.create_dataset(channel, data=values).attrs["units"] = "s" if channel == "time" else unit
        file["calibration/gain"] = np.arange(5.0)
    return path


def imported(path: Path, found: Guess) -> list[Run]:
    document = tomllib.loads(found.toml)
    return sorted(run([path], mapping_of(document, "m.toml")).runs, key=lambda r: r.run_id)


def sized(runs: list[Run]) -> list[float]:
    return [float(np.max(one.tension_in_n) / np.max(X)) for one in runs]


@pytest.mark.parametrize(
    "names",
    [
        ("run01", "run02", "run03"), ("data/run01", "data/run02"), ("2024-05-03", "2024-05-04"), ("2024-05-03T14:05:06", "2024-05-03T14:15:06"),
        ("20240503_140506", "20240503_141506"), ("03.05.2024 14:05", "03.05.2024 14:15"),
    ],
)  # fmt: skip
def test_groups_that_count_or_are_dated_are_runs(names: tuple[str, ...], tmp_path: Path) -> None:
    path = hdf5(tmp_path / "log.h5", {n: {} for n in names})
    found = guess([path])
    assert {q.target for q in found.questions} == {"system"}
    assert sized(imported(path, found)) == pytest.approx([k + 1.0 for k in range(len(names))])


def test_names_of_groups_give_bend_and_system(tmp_path: Path) -> None:
    path = hdf5(tmp_path / "log.h5", {"act_bend30": {}, "act_bend60": {}, "sstl_bend30": {}})
    found = guess([path])
    assert not found.questions
    assert [(r.system, r.config_id) for r in imported(path, found)] == [("act", "30"), ("act", "60"), ("sstl", "30")]


@pytest.mark.parametrize("names", [("act/30", "act/60"), ("trial_A", "trial_B"), ("A", "B")])
def test_a_part_of_a_group_that_may_tell_the_bend_is_asked(names: tuple[str, ...], tmp_path: Path) -> None:
    found = guess([hdf5(tmp_path / "log.h5", {n: {} for n in names})])
    assert "(?P<config_id>" in found.toml and "runs" in {q.target for q in found.questions}


def test_attributes_of_groups_give_the_labels_of_each_run(tmp_path: Path) -> None:
    path = hdf5(tmp_path / "log.h5", {"run01": {"bend_deg": 30, "system": "act"}, "run02": {"bend_deg": 60, "system": "sstl"}})
    found = guess([path])
    assert not found.questions
    assert [(r.system, r.config_id) for r in imported(path, found)] == [("act", "30"), ("sstl", "60")]


def test_units_that_differ_between_groups_are_asked(tmp_path: Path) -> None:
    path = hdf5(tmp_path / "log.h5", {"run01": {}, "run02": {}})
    with h5py.File(path, "r+") as file:
        file["run02/fin"].attrs["units"] = "mN"
    found = guess([path])
    assert "'run02/fin' is in mN, this one in N" in next(q.text for q in found.questions if q.target == "tension_in_n")
    assert "tension_out_n" not in {q.target for q in found.questions}


def test_a_unit_that_a_group_states_is_proposed_and_asked(tmp_path: Path) -> None:
    path = hdf5(tmp_path / "log.h5", {"run01": {"units": "mN"}, "run02": {"units": "mN"}}, unit="")
    found = guess([path])
    assert found.toml.count('unit = "mN"') == 2 and {"tension_in_n", "tension_out_n"} <= {q.target for q in found.questions}


def test_a_group_that_lacks_a_tension_is_left_out_with_a_question(tmp_path: Path) -> None:
    """The output of one run was proposed beside the input of the other."""
    found = guess([hdf5(tmp_path / "log.h5", {"run01": {}, "run02": {}}, lack="run02/fout")])
    assert "runs = 'run01/'" in found.toml
    assert "'run02' lacks a tension" in next(q.text for q in found.questions if q.target == "runs")


def test_a_rate_that_an_attribute_of_the_file_states_is_proposed(tmp_path: Path) -> None:
    path = tmp_path / "log.h5"
    with h5py.File(path, "w") as file:
        file.attrs["sample_rate"] = 250.0
        for k in (1, 2):
            file[f"trial_{k}/tension_motor"], file[f"trial_{k}/tension_tip"] = X, Y
    found = guess([path])
    assert "time_s = { rate_hz = 250 }" in found.toml and "time_s" in {q.target for q in found.questions}


def test_groups_of_one_run_are_none(tmp_path: Path) -> None:
    path = tmp_path / "log.h5"
    with h5py.File(path, "w") as file:
        file["motor/time"], file["motor/force"], file["tip/time"], file["tip/force"] = T, X, T, Y
    assert "runs = " not in guess([path]).toml


@pytest.mark.parametrize("dated", [False, True])
def test_groups_of_tdms_are_runs_and_their_properties_labels(dated: bool, tmp_path: Path) -> None:
    path = tmp_path / "log.tdms"
    names = ("2024-05-03 14-05-06", "2024-05-03 14-15-06") if dated else ("run01", "run02")
    objects: list[object] = [RootObject({})]
    for k, (name, bend) in enumerate(zip(names, (30, 60), strict=True)):
        timed = {"wf_increment": 0.004, "wf_start_offset": 0.0, "unit_string": "N"}
        objects += [GroupObject(name, {"bend_deg": bend}), *(ChannelObject(name, n, v, timed) for n, v in list(scaled(k).items())[1:])]
    with TdmsWriter(str(path)) as writer:
        writer.write_segment(objects)
    found = guess([path])
    assert {q.target for q in found.questions} == {"system"}
    runs = imported(path, found)
    assert [r.config_id for r in runs] == ["30", "60"] and sized(runs) == pytest.approx([1.0, 2.0])


@pytest.mark.parametrize("kind", ["mat", "npz/", "npz_"])
def test_structs_and_arrays_called_by_their_run_are_runs(kind: str, tmp_path: Path) -> None:
    path = tmp_path / f"log.{kind[:3]}"
    if kind == "mat":
        savemat(path, {f"bend{30 * (k + 1)}": scaled(k) for k in range(2)})
    else:
        np.savez(path, **{f"bend{30 * (k + 1)}{kind[3:]}{n}": v for k in range(2) for n, v in scaled(k).items()})
    found = guess([path])
    runs = imported(path, found)
    assert [r.config_id for r in runs] == ["30", "60"] and sized(runs) == pytest.approx([1.0, 2.0])


def test_groups_come_in_the_order_of_their_names(tmp_path: Path) -> None:
    path = hdf5(tmp_path / "log.h5", {"a/run1": {}, "a/run2": {}, "b/run1": {}})
    assert [c.name for c in channels(path, Layout()) if c.name.endswith("/fin")] == ["a/run1/fin", "a/run2/fin", "b/run1/fin"]


@pytest.mark.parametrize("runs", [("Run 1", "Run 2"), ("Run 1", "Latest"), ("Data Set 1", "Data Set 2")])
def test_runs_side_by_side_in_a_table_are_found(runs: tuple[str, str], tmp_path: Path) -> None:
    """The second is shorter, as in Logger Pro."""
    path = tmp_path / "log.csv"
    head = ",".join(f"{r}: {n}" for r in runs for n in ("Time (s)", "Force In (N)", "Force Out (N)"))
    lines = [
        f"{t},{x},{y}," + (f"{t},{2 * x},{2 * y}" if k < len(T) - 50 else ",,") for k, (t, x, y) in enumerate(zip(T, X, Y, strict=True))
    ]
    path.write_text("\n".join([head, *lines]) + "\n")
    found = guess([path])
    assert {q.target for q in found.questions} == {"system"}
    held = list(run([path], mapping_of(tomllib.loads(found.toml), "m.toml")).runs)
    assert sorted((len(r.time_s), round(float(r.tension_in_n.max() / X.max()), 3)) for r in held) == [(len(T) - 50, 2.0), (len(T), 1.0)]


def test_bends_in_front_of_the_colons_of_a_table_give_labels(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    head = ",".join(f"{s} bend{b}: {n}" for s, b in (("act", 30), ("sstl", 60)) for n in ("Time (s)", "Fin (N)", "Fout (N)"))
    path.write_text(head + "\n" + "".join(f"{t},{x},{y},{t},{x},{y}\n" for t, x, y in zip(T, X, Y, strict=True)))
    found = guess([path])
    assert not found.questions
    assert [(r.system, r.config_id) for r in imported(path, found)] == [("act", "30"), ("sstl", "60")]
