"""Names against what the channels hold: swapped sides, channels that take turns in a long table, units of f_in, numbers of forces."""

from __future__ import annotations

import tomllib
from pathlib import Path

import numpy as np
import pytest
from header_table import T, X, Y
from proposals import proposed
from scipy.io import savemat

from sstl_cli.core.errors import SstlError
from sstl_cli.importers.guess import guess


@pytest.mark.parametrize("swapped", [True, False])
def test_an_output_that_moves_more_and_first_is_asked(swapped: bool, tmp_path: Path) -> None:
    t = np.arange(2000) / 100
    x = 15 - 10 * np.cos(2 * np.pi * 0.2 * t)
    # later and less, or, from a cell whose gain is wrong, later and more
    y = (0.7 if swapped else 1.4) * (15 - 10 * np.cos(2 * np.pi * 0.2 * t - 0.3))
    first, second = (y, x) if swapped else (x, y)
    text = "time_s,tension_in_N,tension_out_N\n" + "".join(f"{a:.2f},{b:.4f},{c:.4f}\n" for a, b, c in zip(t, first, second, strict=True))
    _, found = proposed(tmp_path / "act.csv", text)
    asked = {q.target for q in found.questions} & {"tension_in_n", "tension_out_n"}
    assert asked == ({"tension_in_n", "tension_out_n"} if swapped else set())


@pytest.mark.parametrize("header", ["Time(ms),Device,Channel,Data", "stamp_ms,source,port,x"])
def test_words_that_take_turns_name_channels(header: str, tmp_path: Path) -> None:
    rows = (f"{10 * i},LoadCellIn,0,{x:.3f}\n{10 * i},LoadCellOut,1,{y:.3f}" for i, (x, y) in enumerate(zip(X, Y, strict=True)))
    (tmp_path / "act.csv").write_text("\n".join([header, *rows, ""]))
    with pytest.raises(SstlError, match="one row per field") as error:
        guess([tmp_path / "act.csv"])
    assert "pivot" in error.value.fix


def test_a_column_of_units_holds_for_f_in(tmp_path: Path) -> None:
    text = "t_s,f_in,f_out,unit\n" + "".join(f"{t:.3f},{x:.3f},{y:.3f},N\n" for t, x, y in zip(T, X, Y, strict=True))
    columns, found = proposed(tmp_path / "act.csv", text)
    assert [columns[c]["unit"] for c in ("tension_in_n", "tension_out_n")] == ["N", "N"] and not found.questions


def test_what_numbers_forces_is_none(tmp_path: Path) -> None:
    text = "Time (s),F/T Sequence,Fx (N),Fz (N)\n" + "".join(
        f"{t:.3f},{k},{x:.3f},{y:.3f}\n" for k, (t, x, y) in enumerate(zip(T, X, Y, strict=True))
    )
    columns, _ = proposed(tmp_path / "act.csv", text)
    assert {columns[c]["column"] for c in ("tension_in_n", "tension_out_n")} == {"Fx (N)", "Fz (N)"}


def test_what_a_model_gives_out_is_no_output_by_that(tmp_path: Path) -> None:
    logs = {"T_in_N": {"Time": T, "Data": X}, "T_out_N": {"Time": T, "Data": Y}}
    savemat(tmp_path / "act.mat", {"out": {"tout": T, "logs": logs}})
    found = guess([tmp_path / "act.mat"])
    columns = tomllib.loads(found.toml)["columns"]
    assert [columns[t]["column"] for t in ("time_s", "tension_in_n")] == ["out.tout", "out.logs.T_in_N.Data"] and not found.questions
