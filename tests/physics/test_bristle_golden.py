"""Every effect of the bristle simulator against the numbers of the version whose library is published.

After a change that is meant: ``python tests/physics/test_bristle_golden.py`` writes them anew.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from sstl_cli.physics.bristle import BristleRun, BristleSpec, NoiseSpec, parameters, simulate_bristle

GOLDEN = Path(__file__).with_suffix(".csv")
TIME = np.arange(350) * 0.04
PATH = np.interp(TIME, [0, 3, 5, 6, 7.5, 8.5, 10, 10.6, 14], [5, 31, 9, 16, 16, 0, 0, 8, 24])
BESIDE = 12.0 + 10.0 * np.sin(0.7 * TIME)
# an instant of each kind: pull, hold, release, slack, reversal, end
INSTANTS = (60, 120, 145, 170, 230, 260, 300, 349)


def strong(effect: str) -> dict[str, dict[str, float]]:
    """Every parameter three quarters of the way from neutral to its upper bound."""
    if effect == "none":
        return {}
    if effect == "saturation":
        return {effect: {"t_max_in_n": 20.0, "t_max_out_n": 9.0}}
    return {effect: {name: 0.25 * b.neutral + 0.75 * b.high for name, b in parameters()[effect].items()}}


def numbers(effect: str, system: str) -> list[float]:
    run = BristleRun(system, 0.53, {"act": "NP", "sstl": "ND"}[system], TIME, "tension", PATH, BESIDE)
    done = simulate_bristle(BristleSpec(nodes=12), run, strong(effect), NoiseSpec(0.02, 0.03, 0.3, 0.01), seed=7)
    signals = (done.true_tension_out_n, done.tension_in_n, done.tension_out_n, done.position_in_mm)
    return [1e3 * done.dissipated_j, *(float(s[k]) for s in signals for k in INSTANTS)]


def read() -> dict[tuple[str, str], list[float]]:
    lines = GOLDEN.read_text(encoding="utf-8").splitlines() if GOLDEN.exists() else []
    return {(c[0], c[1]): [float(v) for v in c[2:]] for c in (line.split(",") for line in lines)}


KNOWN = read()


def test_every_effect_has_its_numbers() -> None:
    assert {effect for effect, _ in KNOWN} == {"none", *parameters()}


@pytest.mark.parametrize("case", sorted(KNOWN), ids="-".join)
def test_the_same_numbers_as_published(case: tuple[str, str]) -> None:
    # jumps carry a rounding error on: what is left of it after a few of them is far below the noise
    loose = 1e-3 if case[0] in ("stick_slip", "stribeck", "dwell_aging") else 1e-6
    assert numbers(*case) == pytest.approx(KNOWN[case], rel=loose, abs=loose)


if __name__ == "__main__":
    rows = [(e, s, *(f"{v:.8g}" for v in numbers(e, s))) for e in ("none", *sorted(parameters())) for s in ("act", "sstl")]
    GOLDEN.write_text("".join(",".join(row) + "\n" for row in rows), encoding="utf-8")
