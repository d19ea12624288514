"""The rig of law variants, law by law, against the numbers of the version whose results are published.

That the records are right is the matter of the other tests; here they are to stay the same. After a change that is
meant: ``python tests/physics/test_variant_golden.py`` writes the numbers anew.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from variant_cases import EVERY_LAW, recorded

GOLDEN = Path(__file__).with_suffix(".csv")
CASES = [(effect, law, system) for effect, law in [("none", "none"), *EVERY_LAW] for system in ("act", "sstl")]
# one jump more or less moves all that follow
JUMPING = ("stribeck", "stick_slip", "dwell_aging")


def numbers(effect: str, law: str, system: str) -> list[float]:
    """Return work and loads of a record: dissipation (J), sums of each channel against smooth weights."""
    found = recorded(system, None if effect == "none" else effect, law)
    weights = [np.ones(found.time_s.size), np.sin(np.arange(found.time_s.size) / 40.0), np.linspace(-1.0, 1.0, found.time_s.size)]
    channels = (found.time_s, found.tension_in_n, found.tension_out_n, found.position_in_mm)
    return [found.dissipated_j, *(float(np.sum(w * c)) for c in channels for w in weights)]


def read() -> dict[tuple[str, ...], list[float]]:
    lines = GOLDEN.read_text(encoding="utf-8").splitlines()
    return {tuple(c[:3]): [float(v) for v in c[3:]] for c in (line.split(",") for line in lines)}


@pytest.mark.parametrize("case", CASES, ids="-".join)
def test_the_same_numbers_as_published(case: tuple[str, str, str]) -> None:
    tolerance = 1e-3 if case[0] in JUMPING else 1e-5
    assert numbers(*case) == pytest.approx(read()[case], rel=tolerance, abs=tolerance)


def test_every_law_has_its_numbers() -> None:
    assert set(read()) == set(CASES)


if __name__ == "__main__":
    GOLDEN.write_text("".join(",".join([*c, *(f"{v:.9g}" for v in numbers(*c))]) + "\n" for c in CASES), encoding="utf-8")
