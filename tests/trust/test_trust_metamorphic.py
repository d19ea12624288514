"""What must not change an answer, or must change it in a known way; tolerances are stated in each test."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from program import inside

from sstl_cli.core.runs import Run
from sstl_cli.identification import Segmentation, segment_run

LINES = {"gamma_p": 0.58, "beta_p": -0.4, "gamma_r": 1.69, "beta_r": 0.5}


def loops(rate: float = 200.0, seed: int = 0, scale: float = 1.0, noise: float = 0.02) -> Run:
    """Return three trapezoids of 12 s through a play operator written here, noise drawn at 200 Hz whatever the rate."""
    fine = np.arange(7200) / 200.0
    t = np.arange(round(36 * rate)) / rate
    x = np.interp(t % 12.0, [0, 4.8, 5.4, 11.4, 12.0], [5.0, 30.0, 30.0, 5.0, 5.0])
    y, held = np.empty(len(t)), LINES["gamma_p"] * x[0] + LINES["beta_p"]
    for k, v in enumerate(x):
        held = min(max(held, LINES["gamma_p"] * v + LINES["beta_p"]), LINES["gamma_r"] * v + LINES["beta_r"])
        y[k] = held
    rng = np.random.default_rng(seed)
    a, b = (np.interp(t, fine, rng.normal(0, noise, len(fine))) for _ in range(2))
    return Run(f"r{seed}", "act", t, scale * (x + a), scale * (y + b))


def assert_same(a: Segmentation, b: Segmentation, scale: float = 1.0, share_of_se: float = 1e-6) -> None:
    """Compare lines within a share of their standard errors; the biases of ``b`` are ``scale`` times those of ``a``."""
    assert a.status == b.status == "ok"
    for name in LINES:
        factor = scale if name.startswith("beta") else 1.0
        assert b.theta[name] == pytest.approx(factor * a.theta[name], abs=share_of_se * factor * a.theta_se[name]), name
        assert b.theta_se[name] == pytest.approx(factor * a.theta_se[name], rel=max(1e-6, 0.5 * share_of_se)), name


@pytest.mark.parametrize("scale", [0.01, 0.5, 3.0, 1000.0])
def test_tensions_scaled(scale: float) -> None:
    assert_same(segment_run(loops()), segment_run(loops(scale=scale)), scale, 0.01)


def test_a_power_of_two_changes_no_digit() -> None:
    a, b = segment_run(loops()), segment_run(loops(scale=4.0))
    assert [b.theta[n] for n in ("gamma_p", "gamma_r")] == [a.theta[n] for n in ("gamma_p", "gamma_r")]
    assert [b.theta[n] for n in ("beta_p", "beta_r")] == [4.0 * a.theta[n] for n in ("beta_p", "beta_r")]
    assert np.array_equal(a.phases, b.phases)


@pytest.mark.parametrize("offset", [4.0, 1024.0, -8.0])
def test_a_constant_added_to_time(offset: float) -> None:
    run = loops()
    # rounded to what both clocks can say, so that the offset itself moves no sample
    time = np.round(run.time_s * 2**20) / 2**20
    a, b = segment_run(replace(run, time_s=time)), segment_run(replace(run, time_s=time + offset))
    assert a.theta == b.theta and np.array_equal(a.phases, b.phases)


def test_a_clock_in_unix_time() -> None:
    run = loops()
    assert_same(segment_run(run), segment_run(replace(run, time_s=run.time_s + 1.7e9)), share_of_se=0.05)


def test_recorded_at_twice_the_rate() -> None:
    a, b = segment_run(loops()), segment_run(loops(rate=400.0))
    # other samples: the same lines within one standard error
    for name in LINES:
        assert abs(a.theta[name] - b.theta[name]) < max(a.theta_se[name], b.theta_se[name]), name
        assert abs(b.theta[name] - LINES[name]) < 4 * b.theta_se[name], name


def test_mirrored_in_tension_lines_swap() -> None:
    """Minus tension makes pulling of releasing: the lines swap their roles, the biases their signs."""
    run = loops()
    top = float(run.tension_in_n.max() + run.tension_in_n.min())
    flipped = replace(run, tension_in_n=top - run.tension_in_n, tension_out_n=top - run.tension_out_n)
    a, b = segment_run(run), segment_run(flipped)
    for s, other in (("p", "r"), ("r", "p")):
        gamma, beta = a.theta[f"gamma_{s}"], a.theta[f"beta_{s}"]
        assert b.theta[f"gamma_{other}"] == pytest.approx(gamma, abs=0.5 * a.theta_se[f"gamma_{s}"])
        expected, se = top - gamma * top - beta, np.hypot(a.theta_se[f"beta_{s}"], top * a.theta_se[f"gamma_{s}"])
        assert b.theta[f"beta_{other}"] == pytest.approx(expected, abs=se)


def write(path: Path, runs: list[Run], configs: bool = True) -> Path:
    """Write runs with pyarrow alone."""
    tables = []
    for run in runs:
        n = len(run)
        label = {"run_id": [run.run_id] * n, "config_id": [f"c-{run.run_id}"] * n, "system": ["act"] * n}
        values = {"time_s": run.time_s, "tension_in_n": run.tension_in_n, "tension_out_n": run.tension_out_n}
        tables.append(pa.table({**label, **values}))
    pq.write_table(pa.concat_tables(tables), path)
    return path


def rows(*logs: Path, out: Path) -> dict[str, dict[str, object]]:
    """Return the rows of ``sstl segment`` by run."""
    done = inside("segment", *logs, "--out", out)
    assert done.returncode == 0, done.stderr
    return {row["run_id"]: row for row in pq.read_table(out).to_pylist()}


def test_order_of_runs_and_files_they_stand_in(tmp_path: Path) -> None:
    runs = [loops(seed=i, noise=0.02 + 0.01 * i) for i in range(3)]
    whole = rows(write(tmp_path / "a.parquet", runs), out=tmp_path / "ta.parquet")
    turned = rows(write(tmp_path / "b.parquet", runs[::-1]), out=tmp_path / "tb.parquet")
    parts = [write(tmp_path / f"p{i}.parquet", [run]) for i, run in enumerate(runs)]
    split = rows(*parts, out=tmp_path / "tc.parquet")
    assert whole == turned == split and len(whole) == 3


def test_a_run_cut_in_two_gives_the_lines_of_the_whole() -> None:
    run = loops()
    halves = []
    for half in (slice(0, 4800), slice(2400, None)):
        names = ("time_s", "tension_in_n", "tension_out_n")
        halves.append(segment_run(replace(run, **{n: getattr(run, n)[half] for n in names})))
    whole = segment_run(run)
    for part in halves:
        for name in LINES:
            assert abs(part.theta[name] - whole.theta[name]) < 3 * part.theta_se[name], name
            assert part.theta_se[name] > whole.theta_se[name]


@pytest.fixture(scope="module")
def diagnosed():  # type: ignore[no-untyped-def]
    """A rig with a lossy pulley, recorded in two bends, and its diagnosis."""
    from sstl_cli.physics.scenario import Configuration, NoiseSection, Scenario, Trajectory
    from sstl_cli.steps import diagnose, simulate

    scenario = Scenario(
        simulator="rig", sampling_hz=25.0, noise=NoiseSection(white_n=0.02),
        configurations=tuple(Configuration(id=f"c{i}", theta=t) for i, t in enumerate((0.45, 0.6))),
        trajectories=(
            Trajectory(kind="trapezoid", drive="tension", duration_s=12.0),
            Trajectory(kind="random", duration_s=30.0, low_n=2.0),
        ),
    )  # fmt: skip
    runs = list(simulate.run(scenario, {"pulley_friction": {"m_p": 0.06, "m_r": 0.05}}, 1))
    options = diagnose.DiagnoseOptions(physics=False, effects=("pulley_friction", "const_friction"), max_effects=1)

    def answer(changed: list[Run]) -> dict:  # type: ignore[type-arg]
        return diagnose.run(changed, options).document()

    return runs, answer, answer(runs)


def parameters(document: dict) -> dict[str, float]:  # type: ignore[type-arg]
    """Return the estimates of the first candidate."""
    return {p["name"]: p["estimate"] for p in document["candidates"][0]["parameters"]}


def test_diagnosis_of_other_orders_and_clocks(diagnosed) -> None:  # type: ignore[no-untyped-def]
    runs, answer, first = diagnosed
    assert first["verdict"]["effects"] == ["pulley_friction"]
    second = answer(list(reversed(runs)))
    assert second["verdict"] == first["verdict"] and second["gap"] == first["gap"]
    assert parameters(second) == parameters(first)
    # another clock rounds the sampling period otherwise: the fit may stop elsewhere within its tolerance
    third = answer([replace(r, time_s=r.time_s + 64.0) for r in runs])
    assert third["verdict"]["effects"] == first["verdict"]["effects"]
    assert third["gap"]["shrink_pct"] == pytest.approx(first["gap"]["shrink_pct"], abs=0.5)
    for p in first["candidates"][0]["parameters"]:
        assert p["ci95"][0] <= parameters(third)[p["name"]] <= p["ci95"][1]


def test_diagnosis_of_scaled_tensions(diagnosed) -> None:  # type: ignore[no-untyped-def]
    runs, answer, first = diagnosed
    # a hundredfold is fitted in units of its own; a pulley's proportional loss has no unit
    scaled = [replace(r, tension_in_n=100.0 * r.tension_in_n, tension_out_n=100.0 * r.tension_out_n) for r in runs]
    second = answer(scaled)
    assert second["verdict"]["effects"] == ["pulley_friction"]
    assert second["gap"]["rmse_retuned_n"] == pytest.approx(100.0 * first["gap"]["rmse_retuned_n"], rel=0.02)
    assert second["gap"]["shrink_pct"] == pytest.approx(first["gap"]["shrink_pct"], abs=1.0)
    for name in ("m_p", "m_r"):
        assert parameters(second)[name] == pytest.approx(parameters(first)[name], abs=0.003)
