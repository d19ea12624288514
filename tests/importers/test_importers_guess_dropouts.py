"""Tables whose channels have readings in rows of their own, and variables that are called after their file."""

from __future__ import annotations

import tomllib
from pathlib import Path

import numpy as np
import pytest
from header_table import T, X, Y
from proposals import proposed
from scipy.io import savemat

from sstl_cli.importers.guess import guess
from sstl_cli.importers.mapping import mapping_of
from sstl_cli.steps.import_ import run

HEAD = "__time,/in/force_N,/out/force_N,/motor/pos_mm\n"


def table(*channels: tuple[np.ndarray, np.ndarray]) -> str:
    """Return rows of channels with their own times, put into one table as PlotJuggler does."""
    stamps = sorted({round(t, 4) for times, _ in channels for t in times})
    held = [dict(zip(np.round(times, 4), values, strict=True)) for times, values in channels]
    return "".join(f"{t:.4f}," + ",".join(f"{h[t]:.4f}" if t in h else "" for h in held) + "\n" for t in stamps)


def test_channels_in_rows_of_their_own_are_put_on_lines(tmp_path: Path) -> None:
    path = tmp_path / "act.csv"
    # so long that the steps can be of seconds alone
    t, x, y = np.arange(2 * len(T)) * 0.004, np.tile(X, 2), np.tile(Y, 2)
    _, found = proposed(path, HEAD + table((t, x), (t[::2] + 0.0031, y[::2]), (t[::5], 10 * t[::5])))
    assert tomllib.loads(found.toml)["repair"] == {"dropouts": "interpolate"} and not found.questions
    assert any("0 both: rates of their own" in r for r in found.reasons)
    [one] = run([path], mapping_of(tomllib.loads(found.toml), "m.toml")).runs
    inside = one.time_s[one.time_s < T[::5].max()]
    assert one.position_in_mm is not None and one.position_in_mm[: len(inside)] == pytest.approx(10 * inside, abs=1e-3)


def test_a_long_hole_in_such_a_channel_is_asked(tmp_path: Path) -> None:
    late = np.r_[T[:40], T[80:]] + 0.0031
    _, found = proposed(tmp_path / "act.csv", HEAD + table((T, X), (late, np.interp(late, T, Y)), (T, T)))
    assert [q.target for q in found.questions] == ["dropouts"] and "straight line" in found.questions[0].text


def test_a_slow_output_beside_readings_of_the_input_keeps_those_taken_together(tmp_path: Path) -> None:
    _, found = proposed(tmp_path / "act.csv", HEAD + table((T, X), (T[::4], Y[::4]), (T, T)))
    assert tomllib.loads(found.toml)["repair"] == {"dropouts": "drop"} and any("keeps these" in r for r in found.reasons)
    _, whole = proposed(tmp_path / "act.csv", HEAD + table((T, X), (np.delete(T, 50), np.delete(Y, 50)), (T, T)))
    assert "repair" not in tomllib.loads(whole.toml)


@pytest.mark.parametrize("held", ["struct", "matrix"])
def test_a_variable_called_after_its_file_is_found_in_each(held: str, tmp_path: Path) -> None:
    files = [tmp_path / f"{name}.mat" for name in ("act_bend30", "act_bend60", "sstl_bend60")]
    for file in files:
        readings = {"t_s": T, "Fin_N": X, "Fout_N": Y} if held == "struct" else np.column_stack([T, X, Y])
        savemat(file, {file.stem: readings})
    found = guess(files)
    asked = {"time_s", "tension_in_n", "tension_out_n"} if held == "matrix" else set()
    assert {q.target for q in found.questions} == asked and not any("not covered" in r for r in found.reasons)
    runs = list(run(files, mapping_of(tomllib.loads(found.toml), "m.toml")).runs)
    assert [(r.run_id, r.system, r.config_id) for r in runs] == [(f.stem, f.stem.partition("_")[0], f.stem[-2:]) for f in files]
    assert all(r.tension_out_n == pytest.approx(Y) for r in runs)


def test_a_variable_of_another_name_is_named_whole(tmp_path: Path) -> None:
    savemat(tmp_path / "act_bend30.mat", {"log": {"t_s": T, "Fin_N": X, "Fout_N": Y}})
    assert '"log.Fin_N"' in guess([tmp_path / "act_bend30.mat"]).toml
