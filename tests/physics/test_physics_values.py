"""What the catalogue and the movements are, number by number: a change of them is meant or a mistake."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from sstl_cli.physics.effects import catalogue
from sstl_cli.physics.scenario import Trajectory
from sstl_cli.physics.trajectories import DURATION_S, RANGE_N, tension_path, times

GOLDEN = Path(__file__).with_name("test_physics_values.csv")


def test_ranges_of_the_catalogue() -> None:
    """Neutral value and range decide what can be found at all, and what blind results mean."""
    found = {}
    for effect in catalogue().values():
        for p in effect.parameters:
            found[f"{effect.id}.{p.name}"] = f"{p.neutral:g},{p.low:g},{p.high:g},{p.unit},{'shape' if p.shape else 'strength'}"
    golden = dict(line.split(",", 1) for line in GOLDEN.read_text(encoding="utf-8").splitlines())
    # effects may be added, and are added to the file; those that are in it stay as they are
    assert {k: found.get(k) for k in golden} == golden
    # where the fast model goes further than the simulators that stand in for hardware
    for name in ("const_friction.w_in_n", "const_friction.w_end_n"):
        assert found[name] == "0,0,0.5,N,strength"
    assert found["sheath_compliance.c_t_per_n"] == "0,-0.01,0.01,1/N,strength"


def path(kind: str, system: str = "act", hz: float = 10.0, **more: object) -> dict[float, float]:
    """Return the movement by time, with fixed random numbers."""
    trajectory = Trajectory(kind=kind, **more)  # type: ignore[arg-type]
    t = times(trajectory, hz)
    x = tension_path(trajectory, system, t, np.random.default_rng(3))
    return {round(float(a), 6): float(b) for a, b in zip(t, x, strict=True)}


def test_lengths_and_ranges() -> None:
    assert DURATION_S == {"trapezoid": 12.0, "sinusoid": 100.0, "random": 400.0, "ramp_hold": 60.0, "minor_loops": 60.0, "chirp": 60.0}
    assert RANGE_N == {"act": (1.0, 30.0), "sstl": (0.2, 40.0)}
    for kind, seconds in DURATION_S.items():
        assert len(times(Trajectory(kind=kind), 10.0)) == 10 * seconds
    assert len(times(Trajectory(kind="trapezoid", speed=2.0), 10.0)) == 60


def test_trapezoid() -> None:
    x = path("trapezoid", cycles=2, duration_s=24.0)
    for t, share in {0.0: 0.0, 2.4: 0.5, 4.8: 1.0, 5.4: 1.0, 8.4: 0.5, 11.4: 0.0, 14.4: 0.5, 16.8: 1.0}.items():
        assert x[t] == pytest.approx(1.0 + 29.0 * share), t


def test_sinusoid_of_the_paper() -> None:
    x = path("sinusoid")
    assert [x[t] for t in (0.0, 25.0, 50.0, 75.0)] == pytest.approx([5.0, 10.0, 15.0, 10.0])
    wide = path("sinusoid", low_n=2.0, high_n=20.0, frequency_hz=0.1)
    assert [wide[t] for t in (0.0, 2.5, 5.0, 15.0)] == pytest.approx([2.0, 11.0, 20.0, 20.0])


def test_random_is_eight_sines() -> None:
    x = path("random")
    rng = np.random.default_rng(3)
    f, phi, a = rng.uniform(0.02, 0.15, 8), rng.uniform(0, 2 * np.pi, 8), rng.uniform(0.4, 1.0, 8)
    wave = a @ np.sin(np.outer(2 * np.pi * f, list(x)) + phi[:, None])
    values = np.array(list(x.values()))
    assert np.corrcoef(wave, values)[0, 1] == pytest.approx(1.0)
    assert (values.min(), values.max()) == pytest.approx((1.0, 30.0))


def test_ramp_hold_holds_at_its_levels() -> None:
    x = np.array(list(path("ramp_hold", hz=100.0).values()))
    still = x[1:][np.diff(x) == 0.0]
    levels = sorted({round(float(v), 6) for v in still})
    expected = [1.0 + 29.0 * v for v in (0.03, 0.1, 0.35, 0.4, 0.5, 0.65, 0.7, 1.0)]
    assert levels == pytest.approx(expected)
    # a hold of 2 s behind each of nine ramps of one speed
    assert len(still) == pytest.approx(9 * 200, abs=20)
    speeds = np.abs(np.diff(x))[np.abs(np.diff(x)) > 1e-9]
    assert np.quantile(speeds, 0.9) == pytest.approx(np.quantile(speeds, 0.1), rel=1e-6)


def test_minor_loops_turn_near_their_levels() -> None:
    x = np.array(list(path("minor_loops", hz=200.0).values()))
    d = np.sign(np.diff(x))
    turns = x[1:-1][d[1:] * d[:-1] < 0]
    steps = np.array([1.0, 0.05, 0.8, 0.35, 0.7, 0.02, 0.6, 0.15, 0.9, 0.5, 1.0])
    jitter = np.random.default_rng(3).uniform(-0.03, 0.03, 13)[1:-1]
    assert turns == pytest.approx(1.0 + 29.0 * np.clip(steps + jitter, 0, 1), abs=0.1)


def test_chirp_ends_fifty_times_faster() -> None:
    x = np.array(list(path("chirp", hz=200.0).values()))
    middle = np.flatnonzero(np.diff(np.sign(x - 15.5)) != 0) / 200.0
    # 0.02 Hz to 1 Hz: (f1 - f0) / ln(f1 / f0) * 60 s = 15.03 periods, two crossings each
    assert len(middle) == 30
    assert 0.5 / (middle[-1] - middle[-2]) == pytest.approx(1.0, rel=0.05)
    assert x[0] == pytest.approx(1.0)
