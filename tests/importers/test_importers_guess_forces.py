"""Units of force that loggers write: each is recognized wherever it stands, and converted exactly."""

from __future__ import annotations

import tomllib
from pathlib import Path

import pytest
from header_table import T, X, Y, rows

from sstl_cli.core.units import unit_of
from sstl_cli.importers.guess import guess
from sstl_cli.importers.mapping import mapping_of
from sstl_cli.steps.import_ import run

# by definition: 9.80665 m/s2, a pound of 0.45359237 kg of 16 ounces, a dyne of 1 g cm/s2
G, OUNCE = 9.80665e-3, 9.80665 * 0.45359237 / 16
SIZES = {"dN": 0.1, "cN": 0.01, "daN": 10.0, "mN": 1e-3, "kN": 1e3, "gf": G, "kgf": 1e3 * G, "ozf": OUNCE, "oz": OUNCE, "dyn": 1e-5}
WRITTEN = {
    "DN": 0.1, "CN": 0.01, "DaN": 10.0, "centinewton": 0.01, "milliNewton": 1e-3, "gmf": G, "gram-force": G, "pond": G, "kilopond": 1e3 * G,
    "kg-f": 1e3 * G, "oz-f": OUNCE, "ounce": OUNCE, "lb-f": 16 * OUNCE, "pound force": 16 * OUNCE, "dynes": 1e-5, "千克力": 1e3 * G,
}  # fmt: skip


@pytest.mark.parametrize(("unit", "size"), SIZES.items())
def test_a_unit_of_force_is_converted_by_its_definition(unit: str, size: float) -> None:
    assert unit_of(unit) == ("force", pytest.approx(size, rel=1e-12))


@pytest.mark.each_once
@pytest.mark.parametrize(("unit", "size"), [*SIZES.items(), *WRITTEN.items()])
@pytest.mark.parametrize("head", ["Time (s),Fin ({0}),Fout [{0}]", "Time,Fin,Fout\ns,{0},{0}"])
def test_forces_arrive_in_newtons(unit: str, size: float, head: str, tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text(head.format(unit) + "\n" + rows(T, X / size, Y / size, digits=6), encoding="utf-8")
    found = guess([path])
    assert not {"tension_in_n", "tension_out_n"} & {q.target for q in found.questions}
    mapping = mapping_of({"columns": tomllib.loads(found.toml)["columns"], "constants": {"system": "act"}}, "m.toml")
    [one] = run([path], mapping).runs
    assert one.tension_in_n == pytest.approx(X, rel=1e-3, abs=1e-3) and one.tension_out_n == pytest.approx(Y, rel=1e-3, abs=1e-3)


@pytest.mark.parametrize("unit", ["dN", "cN", "daN"])
def test_a_unit_at_the_end_of_a_name_is_sure(unit: str, tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    size = SIZES[unit]
    path.write_text(f"time_s,F_in_{unit},F_out_{unit}\n" + rows(T, X / size, Y / size, digits=6))
    found = guess([path])
    assert {q.target for q in found.questions} == {"system"} and found.toml.count(f'unit = "{unit}"') == 2
