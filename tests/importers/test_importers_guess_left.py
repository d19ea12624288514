"""Channels that a proposal leaves out, and what the reasons say of them."""

from __future__ import annotations

from pathlib import Path

import pytest
from header_table import T, X, Y, rows

from sstl_cli.importers.guess import guess
from sstl_cli.importers.guess_names import said


def left_out(folder: Path, name: str) -> list[str]:
    (folder / "a.csv").write_text(f"Time (s),{name},Fin (N),Fout (N)\n" + rows(T, 0.3 * X, X, Y))
    return [r for r in guess([folder / "a.csv"]).reasons if r.startswith("not mapped")]


@pytest.mark.parametrize(
    ("name", "line"),
    [
        ("x_motor_um", 'position_in_mm = { column = "x_motor_um", unit = "um" }'),
        ("q_motor [rad]", 'position_in_mm = { column = "q_motor [rad]", unit = "rad", radius_mm = ... }'),
        ("motor_angle", 'position_in_mm = { column = "motor_angle", unit = "...", radius_mm = ... }'),
        ("spool_deg", 'position_in_mm = { column = "spool_deg", unit = "deg", radius_mm = ... }'),
        ("theta", 'position_in_mm = { column = "theta", unit = "...", radius_mm = ... }'),
        ("/motor/joint_states/position[0]", 'position_in_mm = { column = "/motor/joint_states/position[0]", unit = "..." }'),
        ("T_cmd", 'tension_ref_n = { column = "T_cmd", unit = "..." }'),
    ],
)
def test_what_looks_like_a_position_or_a_reference_is_named_if_it_is_left_out(name: str, line: str, tmp_path: Path) -> None:
    assert left_out(tmp_path, name) == [f"not mapped: '{name}'; if it is wanted, write {line}"]


@pytest.mark.parametrize("name", ["Temp (degC)", "pwm", "Bend radius (mm)", "Bend angle (deg)", "speed (rpm)", "current_A"])
def test_what_is_neither_is_not_named(name: str, tmp_path: Path) -> None:
    assert not left_out(tmp_path, name)


def test_the_reference_of_one_of_two_files_is_named(tmp_path: Path) -> None:
    (tmp_path / "motor_b30.csv").write_text("t_s,force_N,setpoint_N\n" + rows(T, X, X))
    (tmp_path / "tip_b30.csv").write_text("t_s,force_N\n" + rows(T, Y))
    reasons = guess([tmp_path / "motor_b30.csv", tmp_path / "tip_b30.csv"]).reasons
    assert any("not mapped: 'setpoint_N'" in r for r in reasons)


def test_the_letter_of_a_type_in_front_of_a_position_is_no_force() -> None:
    one = said("fActPos", "mm")
    assert one.quantity == "position" and not one.tension and said("fActForce", "N").tension


def test_a_name_of_a_unit_alone_has_no_word() -> None:
    assert said("[N]").unmeasured == ""
