"""Several clocks in one table: equal ones are one, an output on another gets its own, and what stands nowhere is asked."""

from __future__ import annotations

import tomllib
from collections.abc import Callable
from pathlib import Path

import pytest

from sstl_cli.importers.guess import Guess, guess

N = 400


def fin(t: float) -> float:
    return 10.0 + 5.0 * (t % 3.0)


def fout(t: float) -> float:
    return 6.0 + 2.0 * (t % 3.0)


def table(
    folder: Path, head: str, first: Callable[[int], float], second: Callable[[int], float], order: str = "TITI", end: int = N
) -> Guess:
    """Write clocks ``first`` (0.01 s a row) and ``second`` in the order given: T and I are the input's, the second T and I the output's."""
    lines = [head]
    for i in range(N):
        pairs = [(first(i), fin(0.01 * i)), (second(i), fout(0.01 * i))]
        cells = {"T": [f"{t:.6f}" for t, _ in pairs], "I": [f"{v:.4f}" for _, v in pairs]}
        if i >= end:
            cells["T"][1] = cells["I"][1] = ""
        lines.append(",".join(cells[letter].pop(0) for letter in order))
    path = folder / "act.csv"
    path.write_text("\n".join(lines) + "\n")
    return guess([path])


def columns(found: Guess) -> dict[str, dict[str, object]]:
    return tomllib.loads(found.toml)["columns"]


PAIRS = [
    ("Zeit 1 [s],Kraft Motor [N],Zeit 2 [s],Kraft Spitze [N]", "Zeit 2 [s]"),
    ("Time,Fin (N),Time,Fout (N)\ns,N,s,N", "Time.2"),
    ("Time (s),Fin (N),t_daq (s),Fout (N)", "t_daq (s)"),
]


@pytest.mark.parametrize(("head", "clock"), PAIRS)
@pytest.mark.parametrize("second", [lambda i: 0.005 * i, lambda i: 0.5 + 0.01 * i, lambda i: 0.01 * i + 0.004 * (i % 2)])
def test_an_output_behind_a_clock_that_differs_gets_it(head: str, clock: str, second: Callable[[int], float], tmp_path: Path) -> None:
    found = table(tmp_path, head, lambda i: 0.01 * i, second)
    assert columns(found)["tension_out_n"]["time"] == clock and columns(found)["tension_out_n"]["time_unit"] == "s"
    assert "time" not in columns(found)["tension_in_n"]
    # row n of two clocks is no sample of one loop
    assert found.preview == []


@pytest.mark.parametrize(("head", "clock"), PAIRS)
def test_equal_clocks_are_one(head: str, clock: str, tmp_path: Path) -> None:
    found = table(tmp_path, head, lambda i: 0.01 * i, lambda i: 0.01 * i)
    assert "time" not in columns(found)["tension_out_n"] and found.questions == []


def test_a_clock_of_shorter_columns_is_the_outputs(tmp_path: Path) -> None:
    found = table(tmp_path, "Zeit 1 [s],Kraft Motor [N],Zeit 2 [s],Kraft Spitze [N]", lambda i: 0.01 * i, lambda i: 0.05 * i, end=80)
    assert columns(found)["tension_out_n"]["time"] == "Zeit 2 [s]"


def test_the_clock_of_the_file_is_that_of_the_input(tmp_path: Path) -> None:
    found = table(tmp_path, "Zeit 1 [s],Kraft Spitze [N],Zeit 2 [ms],Kraft Motor [N]", lambda i: 0.01 * i, lambda i: 5.0 * i)
    assert columns(found)["time_s"] == {"column": "Zeit 2 [ms]", "unit": "ms"}
    assert columns(found)["tension_out_n"]["time"] == "Zeit 1 [s]"


@pytest.mark.parametrize("second", [lambda i: 0.005 * i, lambda i: 0.5 + 0.01 * i])
def test_clocks_that_differ_and_stand_together_are_asked(second: Callable[[int], float], tmp_path: Path) -> None:
    found = table(tmp_path, "Zeit 1 [s],Zeit 2 [s],Kraft Motor [N],Kraft Spitze [N]", lambda i: 0.01 * i, second, "TTII")
    [question] = found.questions
    assert "'Zeit 2 [s]' is another clock: whose?" in question.text and 'time = "Zeit 2 [s]", time_unit = "s"' in question.text


@pytest.mark.parametrize(
    ("head", "second", "order"),
    [
        ("Time (s),Unix time (s),Fin (N),Fout (N)", lambda i: 1_714_658_600.0 + 0.01 * i, "TTII"),
        ("Time (s),Fin (N),Unix time (s),Fout (N)", lambda i: 1_714_658_600.0 + 0.01 * i, "TITI"),
        ("Time (s),millis,Fin (N),Fout (N)", lambda i: 5000.0 + 10.0 * i + i % 3, "TTII"),
        ("Time (s),Elapsed (min),Fin (N),Fout (N)", lambda i: round(0.01 * i / 60.0, 2), "TTII"),
        ("Time (s),Fin (N),Elapsed (min),Fout (N)", lambda i: round(0.01 * i / 60.0, 2), "TITI"),
        ("Time (s),Lap time (s),Fin (N),Fout (N)", lambda i: 0.01 * (i % 150), "TTII"),
    ],
)
def test_two_clocks_of_the_same_rows_are_no_question(head: str, second: Callable[[int], float], order: str, tmp_path: Path) -> None:
    found = table(tmp_path, head, lambda i: 0.01 * i, second, order)
    assert columns(found)["time_s"]["column"] in ("Time (s)", "Unix time (s)") and "time" not in columns(found)["tension_out_n"]
    assert found.questions == []


def test_clocks_that_begin_anew_with_each_run_are_compared_within_the_first(tmp_path: Path) -> None:
    lines = [f"{i // 200},{0.01 * (i % 200):.3f},{fin(i)},{0.005 * (i % 200):.4f},{fout(i)}" for i in range(N)]
    path = tmp_path / "act.csv"
    path.write_text("Trial No,Zeit 1 [s],Kraft Motor [N],Zeit 2 [s],Kraft Spitze [N]\n" + "\n".join(lines) + "\n")
    assert columns(guess([path]))["tension_out_n"]["time"] == "Zeit 2 [s]"


NAMED_SO = [
    ("t_motor_ms,F_in_N,t_sensor_ms,F_out_N", 1e3, "ms"),
    ("stamp_motor,F_in_N,stamp_loadcell,F_out_N", 1.0, "s"),
    ("timestamp_motor_ms,F_in_N,timestamp_loadcell_ms,F_out_N", 1e3, "ms"),
    ("t_prox [s],F_prox [N],t_dist [s],F_dist [N]", 1.0, "s"),
    ("tick_us,F_in_N,tick2_us,F_out_N", 1e6, "us"),
    ("t_plc_s,F_in_N,t_daq_s,F_out_N", 1.0, "s"),
    (",time_in,F_in_N,time_out,F_out_N", 1.0, "s"),
]


@pytest.mark.parametrize(("head", "per_s", "unit"), NAMED_SO)
def test_a_second_clock_of_any_name_that_ends_early_is_the_outputs(head: str, per_s: float, unit: str, tmp_path: Path) -> None:
    rows = [f"{0.01 * i * per_s},{fin(0.01 * i)}," + (f"{0.0125 * i * per_s},{fout(0.0125 * i)}" if i < 320 else ",") for i in range(N)]
    path = tmp_path / "act.csv"
    numbered = [f"{i},{row}" for i, row in enumerate(rows)] if head.startswith(",") else rows
    path.write_text(head + "\n" + "\n".join(numbered) + "\n")
    found = guess([path])
    first, second = head.strip(",").split(",")[::2]
    assert columns(found)["time_s"] == {"column": first, "unit": unit}
    assert columns(found)["tension_out_n"]["time"] == second and columns(found)["tension_out_n"]["time_unit"] == unit
    assert found.questions == []


@pytest.mark.parametrize("head", ["t_motor_ms,t_tip_ms,F_in_N,F_out_N", "t_tip_ms,t_motor_ms,F_in_N,F_out_N"])
def test_clocks_of_sides_that_stand_together_are_of_their_sides(head: str, tmp_path: Path) -> None:
    found = table(tmp_path, head, lambda i: 10.0 * i, lambda i: 12.5 * i, "TTII")
    assert columns(found)["time_s"]["column"] == "t_motor_ms" and columns(found)["tension_out_n"]["time"] == "t_tip_ms"


def test_a_clock_as_fast_from_another_zero_is_asked(tmp_path: Path) -> None:
    found = table(tmp_path, "t_motor_ms,F_in_N,t_sensor_ms,F_out_N", lambda i: 5000.0 + 10.0 * i, lambda i: 183.0 + 10.0 * i)
    [question] = found.questions
    assert question.target == "tension_out_n" and "'t_motor_ms' runs as fast from another zero" in question.text


def test_a_column_that_says_nothing_and_runs_off_the_clocks_line_is_asked(tmp_path: Path) -> None:
    found = table(tmp_path, "Time (s),aux,Fin (N),Fout (N)", lambda i: 0.01 * i, lambda i: 3.0 * i + 0.002 * i * i, "TTII")
    assert "'aux' is another clock: whose?" in found.questions[0].text
    straight = table(tmp_path, "Time (s),aux,Fin (N),Fout (N)", lambda i: 0.01 * i, lambda i: 10.0 * i, "TTII")
    assert straight.questions == []


def test_a_temperature_of_a_motor_that_warms_is_no_clock(tmp_path: Path) -> None:
    found = table(tmp_path, "Time (s),T_motor (C),Fin (N),Fout (N)", lambda i: 0.01 * i, lambda i: 20.0 + i * 0.003, "TTII")
    assert found.questions == [] and "T_motor" not in found.toml


@pytest.mark.parametrize("names", [("t1", "t2"), ("ts_ecu", "ts_daq"), ("clk_a", "clk_b"), ("rostime", "wall"), ("time_s", "recv")])
@pytest.mark.parametrize("second", [lambda i: 0.0125 * i, lambda i: 0.41 + 0.01 * i])
def test_a_clock_that_no_word_calls_one_is_asked_where_it_runs_otherwise(
    names: tuple[str, str], second: Callable[[int], float], tmp_path: Path
) -> None:
    found = table(tmp_path, f"{names[0]},prox_N,{names[1]},dist_N", lambda i: 0.01 * i, second)
    assert any(f"'{names[1]}' is another clock: whose?" in q.text for q in found.questions)


def test_a_copy_of_the_clock_in_another_unit_is_none(tmp_path: Path) -> None:
    found = table(tmp_path, "time_s,prox_N,aux,dist_N", lambda i: 0.01 * i, lambda i: 10.0 * i)
    assert not any("another clock" in q.text for q in found.questions)


@pytest.mark.parametrize("zero", [0.0, 0.5])
def test_unix_time_of_one_side_beside_a_clock_of_the_other_from_zero_is_asked(zero: float, tmp_path: Path) -> None:
    found = table(tmp_path, "stamp_in_ms,Fin_N,t_out_s,Fout_N", lambda i: 1763633703120.0 + 10 * i, lambda i: zero + 0.01003 * i)
    assert columns(found)["tension_out_n"]["time"] == "t_out_s"
    assert "another zero" in next(q.text for q in found.questions if q.target == "tension_out_n")


def test_unix_time_of_one_side_beside_another_rate_from_zero_asks_how_they_meet(tmp_path: Path) -> None:
    found = table(tmp_path, "stamp_in_ms,Fin_N,t_out_s,Fout_N", lambda i: 1763633703120.0 + 10 * i, lambda i: 0.0125 * i)
    assert "never meet" in next(q.text for q in found.questions if q.target == "tension_out_n")


def test_elapsed_and_unix_time_of_no_side_stay_one_clock(tmp_path: Path) -> None:
    found = table(tmp_path, "time_s,Fin_N,unix_ms,Fout_N", lambda i: 0.01 * i, lambda i: 1763633703120.0 + 10 * i)
    assert "time" not in columns(found)["tension_out_n"] and not found.questions


def pair_of_files(folder: Path, first: Callable[[int], float], second: Callable[[int], float], many: int = N) -> Guess:
    paths = [folder / "F_in.csv", folder / "F_out.csv"]
    for path, clock, force, rows in zip(paths, (first, second), (fin, fout), (N, many), strict=True):
        path.write_text("Time (s),Force (N)\n" + "".join(f"{clock(i):.4f},{force(clock(i)):.4f}\n" for i in range(rows)))
    return guess(paths)


@pytest.mark.parametrize(("step", "many"), [(0.01, N - 40), (0.0125, N)])
def test_two_files_whose_clocks_each_begin_at_zero_are_asked_whether_they_began_together(step: float, many: int, tmp_path: Path) -> None:
    found = pair_of_files(tmp_path, lambda i: 0.01 * i, lambda i: step * i, many)
    assert "zero of its own" in next(q.text for q in found.questions if q.target == "align")
    assert tomllib.loads(found.toml)["clocks"]["align"] == "start"


@pytest.mark.parametrize("zero", [0.0, 12.5])
def test_two_files_with_the_same_stamps_are_not_asked(zero: float, tmp_path: Path) -> None:
    found = pair_of_files(tmp_path, lambda i: zero + 0.01 * i, lambda i: zero + 0.01 * i)
    assert not [q for q in found.questions if q.target == "align"]


def test_two_files_on_one_clock_that_began_before_them_are_not_asked(tmp_path: Path) -> None:
    found = pair_of_files(tmp_path, lambda i: 12.5 + 0.01 * i, lambda i: 12.53 + 0.01 * i, N - 7)
    assert not [q for q in found.questions if q.target == "align"]
