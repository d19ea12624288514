"""References and defaults of the controller, worked by hand from the paper's Section V."""

from __future__ import annotations

import numpy as np
import pytest

from sstl_cli.control import references
from sstl_cli.control.controller import Options


def test_defaults() -> None:
    assert Options().model_dump() == {
        "dt_s": 0.002, "doubled": True, "t_max_n": 80.0, "max_rate_n_s": None, "max_jump_n": None, "lead_s": 0.0,
        "observer": 0.2, "reversal": "paper", "presliding": 0.0, "widths": None, "band_n": 0.2, "deadband_n": 0.0,
        "tolerance_n": 1.0, "hold_s": 0.1, "ramp_n_s": 10.0,
    }  # fmt: skip


def test_sinusoid() -> None:
    r = references.sinusoid(dt_s=0.5)
    assert len(r.time_s) == 400 and r.cycle_s == 100.0 and r.dt_s == 0.5
    at = dict(zip(r.time_s.tolist(), r.tension_n.tolist(), strict=True))
    assert [at[t] for t in (0.0, 25.0, 50.0, 75.0, 125.0)] == pytest.approx([10.0, 15.0, 10.0, 5.0, 15.0])


def test_trapezoid_repeats() -> None:
    r = references.trapezoid(dt_s=0.1)
    assert len(r.time_s) == 240 and r.cycle_s == 12.0
    at = {round(t, 1): v for t, v in zip(r.time_s.tolist(), r.tension_n.tolist(), strict=True)}
    corners = {0.0: 5.0, 2.4: 10.0, 4.8: 15.0, 5.4: 15.0, 8.4: 10.0, 11.4: 5.0}
    for t, v in corners.items():
        assert at[t] == pytest.approx(v), t
        assert at[round(t + 12.0, 1)] == pytest.approx(v), t


def test_random_is_eight_sines_over_the_whole_range() -> None:
    r = references.random(np.random.default_rng(4), dt_s=0.1)
    assert len(r.time_s) == 4000 and r.cycle_s == 50.0
    assert r.tension_n.min() == pytest.approx(5.0) and r.tension_n.max() == pytest.approx(30.0)
    rng = np.random.default_rng(4)
    f, phi = rng.uniform(0.02, 0.15, 8), rng.uniform(0, 2 * np.pi, 8)
    wave = rng.uniform(0.4, 1.0, 8) @ np.sin(np.outer(2 * np.pi * f, r.time_s) + phi[:, None])
    assert np.corrcoef(wave, r.tension_n)[0, 1] == pytest.approx(1.0)


@pytest.mark.parametrize("name", references.NAMES)
def test_by_name(name: str) -> None:
    assert references.make(name, np.random.default_rng(0), 0.1).name == name


def test_recorded_samples_at_the_controller_s_period() -> None:
    r = references.from_samples("x", np.array([3.0, 4.0, 6.0]), np.array([1.0, 2.0, 6.0]), 0.5)
    assert r.time_s.tolist() == [0.0, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0]
    assert r.tension_n.tolist() == [1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0]


@pytest.mark.parametrize(
    ("values", "seconds"),
    [([0, 1, 2, 1, 0, 1, 2], 4.0), ([2, 1, 0, 1, 2, 1], 4.0), ([0, 1, 2], 2.0), ([1, 1, 1], 2.0), ([0, 2, 1.9, 2, 0, 2], 4.0)],
)
def test_first_cycle_ends_where_it_has_turned_twice(values: list[float], seconds: float) -> None:
    assert references.first_cycle_s(np.arange(len(values), dtype=float), np.array(values, float)) == seconds
