"""Headers of more than a line, stamps in text and units at the end of a name: what the proposal says of them is true."""

from __future__ import annotations

import tomllib
from datetime import UTC, datetime, timedelta
from pathlib import Path

import numpy as np
import pytest
from header_table import T, X, Y, rows

from sstl_cli.importers.guess import Guess, guess

LBF = 4.4482216


def proposed(folder: Path, text: str, encoding: str = "utf-8") -> tuple[dict[str, dict[str, object]], Guess]:
    path = folder / "log.csv"
    path.write_bytes(text.encode(encoding))
    found = guess([path])
    return tomllib.loads(found.toml)["columns"], found


def test_a_row_of_units_with_one_of_something_else_is_no_header(tmp_path: Path) -> None:
    text = "Zeit;Kraft_prox;Kraft_dist;Temperatur\ns;mN;mN;°C\n" + rows(T, 1e3 * X, 1e3 * Y, 20 + 0.01 * X, sep=";", dec=",")
    columns, _ = proposed(tmp_path, text)
    assert columns["time_s"] == {"column": "Zeit", "unit": "s"}
    assert columns["tension_in_n"] == {"column": "Kraft_prox", "unit": "mN"} and columns["tension_out_n"] == {
        "column": "Kraft_dist",
        "unit": "mN",
    }


@pytest.mark.parametrize("second", ["Sec", "s", "(s)", "[s]"])
def test_settings_as_wide_as_the_data_stand_before_the_header(second: str, tmp_path: Path) -> None:
    head = "MTS793|MPT|ENU|1|2|.|/|:|1|0|0|A\n\nData Header:\tTime:\t10.2334\tSec\nData Acquisition: Timed\n"
    head += f"Time\tAxial Displacement\tAxial Force\tLoad Cell 2\n{second}\tmm\tkN\tN\n"
    columns, found = proposed(tmp_path, head + rows(T, 0.1 * X, X / 1e3, Y, sep="\t"))
    assert columns["time_s"] == {"column": "Time", "unit": "s"} and columns["position_in_mm"]["unit"] == "mm"
    assert columns["tension_in_n"] == {"column": "Axial Force", "unit": "kN"} and columns["tension_out_n"] == {
        "column": "Load Cell 2",
        "unit": "N",
    }
    assert {"tension_in_n", "tension_out_n"} <= {q.target for q in found.questions}


def test_a_load_cell_called_by_its_strain_is_a_tension_and_an_error_is_none(tmp_path: Path) -> None:
    head = '"Time","Extension","Load","Strain 1 Load cell"\n"(s)","(mm)","(N)","(lbf)"\n'
    columns, found = proposed(tmp_path, head + rows(T, 0.1 * X, X, Y / LBF))
    assert columns["tension_out_n"] == {"column": "Strain 1 Load cell", "unit": "lbf"} and columns["tension_in_n"]["column"] == "Load"
    assert not any("not in this file" in r for r in found.reasons)
    columns, found = proposed(tmp_path, "Time (s),Load (N),Load error (N)\n" + rows(T, X, 0.01 * Y))
    assert columns["tension_out_n"]["column"] == "Load (N)" and any("of whichever side" in r for r in found.reasons)


@pytest.mark.parametrize("step", [0.02, 0.004, 0.25])
@pytest.mark.parametrize(("separator", "zone"), [("T", "Z"), (" ", ""), ("T", "+02:00")])
def test_dates_in_text_tell_the_rate_and_ask_for_it(step: float, separator: str, zone: str, tmp_path: Path) -> None:
    start = datetime(2024, 3, 5, 14, 2, 11, tzinfo=UTC)
    stamps = [
        (start + timedelta(seconds=step * k)).replace(tzinfo=None).isoformat(sep=separator, timespec="milliseconds") + zone
        for k in range(len(T))
    ]
    text = "timestamp,distal_tension_N,proximal_tension_N\n" + "\n".join(
        f"{s},{y:.4f},{x:.4f}" for s, y, x in zip(stamps, Y, X, strict=True)
    )
    columns, found = proposed(tmp_path, text + "\n")
    assert columns["time_s"]["rate_hz"] == pytest.approx(1.0 / step) and "time_s" in {q.target for q in found.questions}
    assert any("dates as text" in r for r in found.reasons) and not any("no clock" in r for r in found.reasons)


@pytest.mark.parametrize("unit", ["N", "mN", "kN", "lbf", "kgf"])
def test_the_unit_at_the_end_of_a_name_is_no_word_of_it(unit: str, tmp_path: Path) -> None:
    columns, found = proposed(tmp_path, f"t_us,Fp_{unit},Fd_{unit}\n" + rows(np.round(1e6 * T), X, Y))
    assert {columns[c]["column"] for c in ("tension_in_n", "tension_out_n")} == {f"Fp_{unit}", f"Fd_{unit}"}
    assert columns["tension_in_n"]["unit"] == unit and "fewer than two channels move" not in found.reasons
    text = f"time_s,act_in_{unit},act_out_{unit},sstl_in_{unit},sstl_out_{unit}\n" + rows(T, X, Y, X, 0.7 * Y)
    columns, found = proposed(tmp_path, text)
    assert columns["tension_in_n"]["column"] == f"act_in_{unit}" and columns["tension_out_n"]["column"] == f"act_out_{unit}"
    assert {"tension_in_n", "tension_out_n"} <= {q.target for q in found.questions}
