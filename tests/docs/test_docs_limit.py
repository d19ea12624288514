"""The tables of docs/limit.md are those of the measured rows beside them."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import pytest

from sstl_cli.core.observer import ideal

ROOT = Path(__file__).parents[2]
sys.path.insert(0, str(ROOT / "tools"))
import limit_table  # noqa: E402
import next_table  # noqa: E402
import page_part  # noqa: E402


def rows(name: str) -> list[dict]:
    kept = json.loads((ROOT / "data" / name).read_text(encoding="utf-8"))
    return kept["rows"] if isinstance(kept, dict) else kept


def test_what_recordings_could_tell_is_that_of_the_rows() -> None:
    assert page_part.inside("limit.md", "shares").strip() == limit_table.shares(rows("limit_cases.json"))


def test_simulated_error_rates_are_those_of_the_rows() -> None:
    assert page_part.inside("limit.md", "simulated").strip() == limit_table.simulated(ROOT / "data" / "limit_simulation.json")


def test_what_a_proposal_settled_is_that_of_the_rows() -> None:
    assert page_part.inside("limit.md", "next").strip() == next_table.told(rows("next_cases.json"))


def test_what_a_proposal_settled_stands_beside_what_the_noise_alone_allows() -> None:
    made = [{"d2": d2, "settled": d2 > 4.0, "settled_random": False, "commit": "abc"} for d2 in (0.0, 5.0, 12.0, 23.9, 24.0, 800.0)]
    parts = dict(next_table.strata(made))
    assert {name: [r["d2"] for r in part] for name, part in parts.items()} == {
        "24 and more": [24.0, 800.0], "6 to 24": [12.0, 23.9], "below 6": [0.0, 5.0],
    }  # fmt: skip
    assert float(next_table.likely(parts["6 to 24"])) == pytest.approx(ideal(12.0) + ideal(23.9), abs=0.05)
    assert f"settled 3 of 4; by the noise alone it would have been {ideal(5.0) + ideal(12.0) + ideal(23.9):.1f}." in next_table.told(made)
