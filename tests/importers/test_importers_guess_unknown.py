"""What a proposal says where names say little: no guess that would look like knowledge."""

from __future__ import annotations

import tomllib
from pathlib import Path

import numpy as np
import pytest
from header_table import T, X, Y, rows
from scipy.io import savemat

from sstl_cli.core.errors import SstlError
from sstl_cli.importers.guess import Guess, guess
from sstl_cli.importers.mapping import read_mapping
from sstl_cli.steps.import_ import run


def proposed(path: Path, text: str = "") -> tuple[dict[str, dict[str, object]], Guess]:
    if text:
        path.write_text(text)
    found = guess([path])
    return tomllib.loads(found.toml)["columns"], found


def asked(found: Guess) -> dict[str, str]:
    return {q.target: q.text for q in found.questions}


def test_labels_of_a_structure_with_time_give_names_and_units(tmp_path: Path) -> None:
    kind = [("values", object), ("label", object)]
    signals = np.array([(0.9 * X, "T_ref"), (1e3 * X, "T_in (mN)"), (Y, "T_out (N)")], dtype=kind)
    savemat(tmp_path / "a.mat", {"Scope": {"time": T, "signals": signals}})
    columns, found = proposed(tmp_path / "a.mat")
    assert columns["tension_in_n"] == {"column": "Scope.signals(2).values", "unit": "mN"}
    assert columns["tension_out_n"] == {"column": "Scope.signals(3).values", "unit": "N"}
    assert not {"tension_in_n", "tension_out_n"} & set(asked(found))
    (tmp_path / "rig.toml").write_text(found.toml.replace("(?)", ""))
    [one] = run([tmp_path / "a.mat"], read_mapping(tmp_path / "rig.toml")).runs
    assert one.tension_in_n == pytest.approx(X)


def test_columns_of_a_matrix_that_move_alike_are_not_told_apart(tmp_path: Path) -> None:
    np.save(tmp_path / "data.npy", np.column_stack([np.arange(len(T)), 5.0 * np.arange(len(T)), 0.02 * X, X, Y]))
    columns, found = proposed(tmp_path / "data.npy")
    assert columns["tension_in_n"]["column"] == columns["tension_out_n"]["column"] == "..."
    assert columns["time_s"] == {"column": "[2]", "unit": "ms"} and "in its name" not in asked(found)["time_s"]
    assert "merge" not in found.toml and ".npy" in found.reasons[0]


def test_of_two_channels_without_names_the_larger_is_asked_as_the_input(tmp_path: Path) -> None:
    columns, found = proposed(tmp_path / "a.csv", rows(T, Y, X))
    assert (columns["tension_in_n"]["column"], columns["tension_out_n"]["column"]) == ("col3", "col2")
    assert {"tension_in_n", "tension_out_n"} <= set(asked(found)) and any("moves more" in r for r in found.reasons)


def test_one_row_per_field_is_refused_with_what_to_do(tmp_path: Path) -> None:
    lines = (f"{t:.3f},{n},{v:.4f}\n" for n, values in (("force_in", X), ("force_out", Y)) for t, v in zip(T, values, strict=True))
    with pytest.raises(SstlError, match="one row per field .'_field' says which, '_value' holds it.*pivot it first") as raised:
        proposed(tmp_path / "a.csv", "_time,_field,_value\n" + "".join(lines))
    assert raised.value.code == "E333"


def test_a_stated_rate_beats_a_switched_signal(tmp_path: Path) -> None:
    head = "# Sample rate: 250 Hz\nSample,Proximal (N),Distal (N),Digital\n"
    columns, _ = proposed(tmp_path / "a.csv", head + rows(np.arange(len(T)), X, Y, np.arange(len(T)) > 90, digits=4))
    assert columns["time_s"] == {"rate_hz": 250}
    columns, found = proposed(tmp_path / "a.csv", head.split("\n")[1] + "\n" + rows(np.arange(len(T)), X, Y, np.arange(len(T)) > 90))
    assert columns["time_s"] == {"rate_hz": 0} and "time_s" in asked(found)


@pytest.mark.parametrize("gap", [0.0, 0.7])
def test_a_clock_in_two_columns_is_told_as_one(gap: float, tmp_path: Path) -> None:
    time = 0.25 + 0.01 * np.arange(len(T)) + gap * (np.arange(len(T)) > 50)
    sec = np.floor(time + 1e-9)
    lines = (f"{1712345678 + s:.0f},{max(t - s, 0.0) * 1e9:.0f},{x:.4f},{y:.4f}\n" for t, s, x, y in zip(time, sec, X, Y, strict=True))
    columns, found = proposed(tmp_path / "a.csv", "stamp.sec,stamp.nanosec,Fin (N),Fout (N)\n" + "".join(lines))
    assert columns["time_s"] == {"column": "stamp.sec", "unit": "s", "fraction": "stamp.nanosec", "fraction_unit": "ns"}
    (tmp_path / "rig.toml").write_text(found.toml.replace("(?)", "") + "\n[time]\ngap_s = 10\n")
    [one] = run([tmp_path / "a.csv"], read_mapping(tmp_path / "rig.toml")).runs
    np.testing.assert_allclose(one.time_s - 1712345678, time, atol=1e-6)


def test_unix_time_by_name_and_values_is_not_asked(tmp_path: Path) -> None:
    lines = (f"{1712345678000 + 10 * k},{x:.4f},{y:.4f}\n" for k, (x, y) in enumerate(zip(X, Y, strict=True)))
    columns, found = proposed(tmp_path / "a.csv", "Epoch_ms,Fin (N),Fout (N)\n" + "".join(lines))
    assert columns["time_s"] == {"column": "Epoch_ms", "unit": "ms"} and "time_s" not in asked(found)


def test_a_run_number_in_names_may_stay_without_a_label(tmp_path: Path) -> None:
    files = [tmp_path / f"bend{bend}_act_{take:02d}.csv" for bend, take in ((45, 1), (90, 2))]
    for path in files:
        path.write_text("Time (s),Fin (N),Fout (N)\n" + rows(T, X, Y))
    assert "deleting this mark is enough" in asked(guess(files))["file_name"]


def test_arrays_of_one_channel_each_are_proposed_row_by_row(tmp_path: Path) -> None:
    files = [tmp_path / f"{stem}.npy" for stem in ("t_s", "f_in_N", "f_out_N")]
    for path, values in zip(files, (T, X, Y), strict=True):
        np.save(path, values)
    found = guess(files)
    document = tomllib.loads(found.toml)
    assert document["files"] == {"merge": "rows"} and document["columns"]["time_s"] == {"column": "t_s", "unit": "s"}
    assert [q.target for q in found.questions] == ["system"]
    (tmp_path / "rig.toml").write_text(found.toml.replace("  # (?) act: single pass, sstl: double pass", ""))
    [one] = run(files, read_mapping(tmp_path / "rig.toml")).runs
    assert len(one) == len(T)


@pytest.mark.parametrize(
    ("shared", "labels", "asks"),
    [
        ("bend60_sstl_rep1", {"config_id": "60", "system": "sstl"}, set()),
        ("NP_lead10_act", {"config_id": "NP-10", "system": "act", "location": "NP", "lead_mm": "10"}, set()),
        ("b30_sstl", {"config_id": "30", "system": "sstl"}, {"config_id", "system"}),
    ],
)
def test_arrays_of_one_channel_each_have_the_labels_that_their_names_share(
    shared: str, labels: dict[str, str], asks: set[str], tmp_path: Path
) -> None:
    """The reasons announced them, and the mapping proposed ``act`` for files named sstl."""
    files = [tmp_path / f"{shared}_{name}.npy" for name in ("Tin_N", "Tout_N", "time_s")]
    for path, values in zip(files, (X, Y, T), strict=True):
        np.save(path, values)
    found = guess(files)
    assert tomllib.loads(found.toml)["constants"] == labels and {q.target for q in found.questions} == asks
    (tmp_path / "rig.toml").write_text("\n".join(line.partition("  # (?)")[0] for line in found.toml.splitlines()))
    [one] = run(files, read_mapping(tmp_path / "rig.toml")).runs
    assert (one.config_id, one.system) == (labels["config_id"], labels["system"])
    assert one.lead_mm == (10.0 if "lead_mm" in labels else None) or np.isnan(one.lead_mm)


def test_arrays_of_other_lengths_are_none_of_one_recording(tmp_path: Path) -> None:
    files = [tmp_path / f"{stem}.npy" for stem in ("t_s", "f_in_N", "f_out_N")]
    for path, values in zip(files, (T, X, Y[:-3]), strict=True):
        np.save(path, values)
    with pytest.raises(SstlError, match="E333"):
        guess(files)


@pytest.mark.parametrize(
    ("head", "plain"),
    [
        ("Output 1 (N),Output 2 (N),Force (N)", "tension_in_n"),
        ("Distal 1 (N),Distal 2 (N),Total force (N)", "tension_in_n"),
        ("In1 (N),In2 (N),Force (N)", "tension_out_n"),
    ],
)
def test_a_plain_tension_beside_two_of_one_side_is_asked(head: str, plain: str, tmp_path: Path) -> None:
    path = tmp_path / "act.csv"
    path.write_text(f"Time (s),{head}\n" + rows(T, X, 0.9 * X, Y))
    asked = {q.target: q.text for q in guess([path]).questions}
    assert "are the other side: is this the" in asked[plain] and set(asked) == {"tension_in_n", "tension_out_n"}
