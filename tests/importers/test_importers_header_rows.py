"""Headers of more than a line, stamps in text and units at the end of a name: what the proposal says of them is true."""

from __future__ import annotations

import tomllib
from datetime import UTC, datetime, timedelta
from pathlib import Path

import numpy as np
import pytest
from header_table import T, X, Y, rows

from sstl_cli.importers.guess import Guess, guess
from sstl_cli.importers.mapping import read_mapping
from sstl_cli.steps.import_ import run

LBF = 4.4482216


def proposed(folder: Path, text: str, encoding: str = "utf-8") -> tuple[dict[str, dict[str, object]], Guess]:
    path = folder / "log.csv"
    path.write_bytes(text.encode(encoding))
    found = guess([path])
    return tomllib.loads(found.toml)["columns"], found


def times(folder: Path, found: Guess, gap_s: float = 1.0) -> np.ndarray:
    """Return the times (s) that an import of what is proposed gives."""
    (folder / "rig.toml").write_text(found.toml.replace("(?)", "") + f"\n[time]\ngap_s = {gap_s}\n")
    [one] = run([folder / "log.csv"], read_mapping(folder / "rig.toml")).runs
    return one.time_s


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
def test_dates_in_text_are_the_clock(step: float, separator: str, zone: str, tmp_path: Path) -> None:
    start = datetime(2024, 3, 5, 14, 2, 11, tzinfo=UTC)
    stamps = [
        (start + timedelta(seconds=step * k)).replace(tzinfo=None).isoformat(sep=separator, timespec="milliseconds") + zone
        for k in range(len(T))
    ]
    text = "timestamp,distal_tension_N,proximal_tension_N\n" + "\n".join(
        f"{s},{y:.4f},{x:.4f}" for s, y, x in zip(stamps, Y, X, strict=True)
    )
    columns, found = proposed(tmp_path, text + "\n")
    assert columns["time_s"] == {"column": "timestamp", "unit": "s"} and "time_s" not in {q.target for q in found.questions}
    np.testing.assert_allclose(times(tmp_path, found) - start.timestamp() + 7200 * ("+" in zone), step * np.arange(len(T)), atol=1e-6)


@pytest.mark.parametrize("unit", ["N", "mN", "kN", "lbf", "kgf"])
def test_the_unit_at_the_end_of_a_name_is_no_word_of_it(unit: str, tmp_path: Path) -> None:
    columns, found = proposed(tmp_path, f"t_us,Fp_{unit},Fd_{unit}\n" + rows(np.round(1e6 * T), X, Y))
    assert {columns[c]["column"] for c in ("tension_in_n", "tension_out_n")} == {f"Fp_{unit}", f"Fd_{unit}"}
    assert columns["tension_in_n"]["unit"] == unit and "fewer than two channels move" not in found.reasons
    text = f"time_s,act_in_{unit},act_out_{unit},sstl_in_{unit},sstl_out_{unit}\n" + rows(T, X, Y, X, 0.7 * Y)
    columns, found = proposed(tmp_path, text)
    assert columns["tension_in_n"]["column"] == f"act_in_{unit}" and columns["tension_out_n"]["column"] == f"act_out_{unit}"
    assert {"tension_in_n", "tension_out_n"} <= {q.target for q in found.questions}


def test_no_rate_is_proposed_that_is_not_in_the_file(tmp_path: Path) -> None:
    columns, found = proposed(tmp_path, "Force in (N),Force out (N)\n" + rows(X, Y))
    # 0 is refused once its mark is deleted
    assert columns["time_s"] == {"rate_hz": 0} and "time_s" in {q.target for q in found.questions}


@pytest.mark.parametrize("written", ["{:g} sec", "{:g} s", "{:g}s"])
def test_numbers_with_a_unit_of_time_in_their_cells_are_the_clock(written: str, tmp_path: Path) -> None:
    lines = (f"{written.format(round(0.05 * k, 6))},{x:.4f},{y:.4f}" for k, (x, y) in enumerate(zip(X, Y, strict=True)))
    columns, found = proposed(tmp_path, "Time,T_prox,T_dist\n" + "\n".join(lines) + "\n")
    assert columns["time_s"]["column"] == "Time" and "time_s" not in {q.target for q in found.questions}
    np.testing.assert_allclose(times(tmp_path, found), 0.05 * np.arange(len(T)), atol=1e-9)


def test_a_time_of_day_beside_a_date_is_the_clock(tmp_path: Path) -> None:
    start = datetime(2024, 3, 5, 14, 3, 21, tzinfo=UTC)
    stamps = [(start + timedelta(seconds=0.05 * k)).strftime("05.03.2024;%H:%M:%S,%f")[:-3] for k in range(len(T))]
    lines = (f"{s};{x:.3f};{y:.3f}".replace(".", ",", 0) for s, x, y in zip(stamps, X, Y, strict=True))
    text = "Datum;Uhrzeit;Zugkraft Motorseite (N);Zugkraft Werkzeugseite (N)\n" + "\n".join(lines) + "\n"
    columns, found = proposed(tmp_path, text)
    assert columns["time_s"] == {"column": "Uhrzeit", "unit": "s"}
    np.testing.assert_allclose(times(tmp_path, found) - 50_601.0, 0.05 * np.arange(len(T)), atol=1e-6)


def test_a_tension_in_volts_beside_two_forces_is_none_of_them(tmp_path: Path) -> None:
    head = "Temps (s);Tension moteur (V);Force proximale (N);Force distale (N)\n"
    columns, found = proposed(tmp_path, head + rows(T, 0.3 * X, X, Y, sep=";", dec=","))
    assert columns["tension_in_n"]["column"] == "Force proximale (N)" and columns["tension_out_n"]["column"] == "Force distale (N)"
    assert not {"tension_in_n", "tension_out_n"} & {q.target for q in found.questions}


@pytest.mark.parametrize("names", ["time,T_in_C,T_out_C,F_in,F_out", "time_s,Tin,Tout,Fin,Fout"])
def test_temperatures_that_rise_are_no_clocks(names: str, tmp_path: Path) -> None:
    warm = np.round(np.linspace(22.0, 22.4, len(T)), 1)
    _, found = proposed(tmp_path, f"{names}\n" + rows(T, warm, warm + 1.0, X, Y))
    assert not any("clock" in q.text for q in found.questions)
    assert not any("clocks" in r for r in found.reasons)


def test_further_segments_of_labview_are_runs_and_asked_where_their_units_are_others(tmp_path: Path) -> None:
    head = ["LabVIEW Measurement", "X_Columns\tOne", "***End_of_Header***"]
    segment = ["Channels\t2", "Y_Unit_Label\tN\tN", "***End_of_Header***", "X_Value\tForce in\tForce out"]
    rows = [f"{t}\t{x:.6f}\t{y:.6f}" for t, x, y in zip(T, X, Y, strict=True)]
    _, found = proposed(tmp_path, "\n".join([*head, *segment, *rows, *segment, *rows]) + "\n")
    assert 'blocks = "runs"\n' in found.toml and {q.target for q in found.questions} == {"system"}
    other = [x.replace("N\tN", "N\tmN") for x in segment]
    _, found = proposed(tmp_path, "\n".join([*head, *segment, *rows, *other, *rows]) + "\n")
    [asked] = [q.text for q in found.questions if q.target == "blocks"]
    assert "'Y_Unit_Label' is" in asked and f"line {len(head) + len(segment) + len(rows) + 1}" in asked


@pytest.mark.parametrize("columns", ["One", "No"])
def test_units_and_rate_of_labviews_header_are_read(columns: str, tmp_path: Path) -> None:
    step = float(T[1] - T[0])
    head = [
        "LabVIEW Measurement", "Separator\tTab", f"X_Columns\t{columns}", "***End_of_Header***", "", "Channels\t2", "Y_Unit_Label\tN\tmN",
        "X_Dimension\tTime\tTime", "X0\t0.0\t0.0", f"Delta_X\t{step:g}\t{step:g}", "***End_of_Header***",
        "X_Value\tTension proximal\tTension distal\tComment",
    ]  # fmt: skip
    clock = [f"{t:.6f}" for t in T] if columns == "One" else [""] * len(T)
    lines = [f"{t}\t{x:.6f}\t{1e3 * y:.4f}" for t, x, y in zip(clock, X, Y, strict=True)]
    found, guessed = proposed(tmp_path, "\r\n".join([*head, *lines]) + "\r\n")
    assert (found["tension_in_n"]["unit"], found["tension_out_n"]["unit"]) == ("N", "mN")
    if columns == "One":
        assert found["time_s"] == {"column": "X_Value", "unit": "s"} and "time_s" not in {q.target for q in guessed.questions}
    else:
        assert found["time_s"]["rate_hz"] == pytest.approx(1.0 / step) and "time_s" not in {q.target for q in guessed.questions}
        # channels that begin apart have no clock in common
        _, apart = proposed(tmp_path, "\r\n".join([*head, *lines]).replace("X0\t0.0\t0.0", "X0\t0.0\t0.25") + "\r\n")
        assert "time_s" in {q.target for q in apart.questions}


def stamped(after_100_s: float) -> str:
    """Return a log whose stamps are text and jump once."""
    start = datetime(2024, 3, 5, 14, 3, 21, tzinfo=UTC)
    times = [start + timedelta(seconds=0.01 * k + (after_100_s if k > 100 else 0.0)) for k in range(len(T))]
    lines = (f"{t:%H:%M:%S.%f},{x:.4f},{y:.4f}" for t, x, y in zip(times, X, Y, strict=True))
    return "Time,Fin (N),Fout (N)\n" + "\n".join(lines) + "\n"


def test_a_gap_in_times_of_text_is_kept(tmp_path: Path) -> None:
    columns, found = proposed(tmp_path, stamped(0.6))
    assert columns["time_s"] == {"column": "Time", "unit": "s"}
    assert np.diff(times(tmp_path, found, gap_s=10.0)).max() == pytest.approx(0.61)


@pytest.mark.parametrize(
    "line",
    [
        "# sampling rate: 500 Hz",
        "# Abtastrate = 0,5 kHz",
        "# sampled at 500 Hz",
        "# Sample rate 500 S/s",
        "# fs = 500 Hz",
        "# Fs: 0.5 kHz",
        "Messrate: 500 Hz",
    ],
)
def test_a_rate_in_a_comment_is_proposed(line: str, tmp_path: Path) -> None:
    columns, found = proposed(tmp_path, f"{line}\n# motion at 2 Hz\nSample,Fin [N],Fout [N]\n" + rows(np.arange(len(T)), X, Y, digits=4))
    assert columns["time_s"] == {"rate_hz": 500} and "the header states it" in {q.target: q.text for q in found.questions}["time_s"]


@pytest.mark.parametrize("line", ["# 50 N FS, 500 Hz", "# offs = 500 Hz", "# fs = 500", "# fs = 500 Hz\n# fs = 100 Hz"])
def test_a_line_that_states_no_rate_or_two_is_not_taken(line: str, tmp_path: Path) -> None:
    columns, found = proposed(tmp_path, f"{line}\nSample,Fin [N],Fout [N]\n" + rows(np.arange(len(T)), X, Y, digits=4))
    assert columns["time_s"] == {"rate_hz": 0} and "which rate" in {q.target: q.text for q in found.questions}["time_s"]


def test_channels_in_volts_and_nothing_else_are_proposed_with_their_unit(tmp_path: Path) -> None:
    columns, found = proposed(tmp_path, "Time (s),Voltage (V),Voltage_0 (V),Temp (V)\n" + rows(T, X / 20, Y / 20, X / 30))
    assert {columns[c]["column"] for c in ("tension_in_n", "tension_out_n")} == {"Voltage (V)", "Voltage_0 (V)"}
    assert all(columns[c]["unit"] == "V" for c in ("tension_in_n", "tension_out_n"))
    assert sum("need gain = N per V" in q.text for q in found.questions) == 2


@pytest.mark.parametrize(
    "footer", ["Mean,9.2,7.8\nMax,15,10.6\n", "\nMean,9.2,7.8\nMax,15,10.6", '"Mean",,7.8\nMax:,,10.6\n\n', "Mean,1,2\nMax value,1,2\n"]
)
def test_rows_of_statistics_below_the_samples_are_no_samples(footer: str, tmp_path: Path) -> None:
    columns, found = proposed(tmp_path, "Time (s),Fin (N),Fout (N)\n" + rows(T, X, Y) + footer)
    assert columns["time_s"] == {"column": "Time (s)", "unit": "s"} and [q.target for q in found.questions] == ["system"]
    (tmp_path / "rig.toml").write_text(found.toml.replace("(?)", ""))
    done = run([tmp_path / "log.csv"], read_mapping(tmp_path / "rig.toml"))
    [one] = done.runs
    assert len(one) == len(T) and "statistics below the samples (Mean, Max" in str(done.counts.notes)


@pytest.mark.parametrize(
    ("pair", "question"),
    [
        (("Fin raw (N)", "Fin filtered (N)"), "name the one that was measured"),
        (("Fin mean (N)", "Fin rms (N)"), "name the one that was measured"),
        (("Fin (N)", "Fin smoothed (N)"), "name the one that was measured"),
        (("Fin left (N)", "Fin right (N)"), "give each tendon a mapping of its own"),
    ],
)
def test_readings_of_one_sensor_are_no_tendons(pair: tuple[str, str], question: str, tmp_path: Path) -> None:
    _, found = proposed(tmp_path, f"Time (s),{pair[0]},{pair[1]},Fout (N)\n" + rows(T, X, X + 0.1, Y))
    assert question in {q.target: q.text for q in found.questions}["tension_in_n"]


def test_minutes_and_seconds_in_text_are_no_time_of_day(tmp_path: Path) -> None:
    lines = (f"{k // 600:02d}:{k % 600 / 10:04.1f},{x:.4f},{y:.4f}" for k, (x, y) in enumerate(zip(X, Y, strict=True), 400))
    columns, found = proposed(tmp_path, "Time,Fin (N),Fout (N)\n" + "\n".join(lines) + "\n")
    assert columns["time_s"] == {"column": "Time", "unit": "s"}
    np.testing.assert_allclose(times(tmp_path, found), 0.1 * np.arange(400, 400 + len(T)), atol=1e-9)


def test_a_time_of_day_goes_on_over_midnight(tmp_path: Path) -> None:
    start = datetime(2024, 3, 5, 23, 59, 59, tzinfo=UTC)
    lines = (f"{start + timedelta(seconds=0.05 * k):%H:%M:%S.%f},{x:.4f},{y:.4f}" for k, (x, y) in enumerate(zip(X, Y, strict=True)))
    columns, found = proposed(tmp_path, "Time,Fin (N),Fout (N)\n" + "\n".join(lines) + "\n")
    assert columns["time_s"] == {"column": "Time", "unit": "s"}
    np.testing.assert_allclose(np.diff(times(tmp_path, found)), 0.05, atol=1e-6)
