"""Whole segmentations against the numbers of the version whose results are published, and refusals near their limits.

That the numbers are right is the matter of the other tests; these notice a threshold that moved. After a change that is
meant: ``python tests/identification/test_identification_golden.py`` writes the numbers anew.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from identification_loops import ACT, SSTL, coloured, multisine, record, trapezoid

from sstl_cli.core.errors import UsageError
from sstl_cli.core.runs import Run
from sstl_cli.identification import SegmentOptions, label_phases, segment_run
from sstl_cli.identification.covariance import Line
from sstl_cli.identification.segment import _doubt, _Fit

GOLDEN = Path(__file__).with_suffix(".csv")


def spiked(run: Run) -> Run:
    """Spikes of 12 and 8 standard deviations in both channels: the rule is 10."""
    x, y = run.tension_in_n.copy(), run.tension_out_n.copy()
    for k, size in ((400, 12.0), (900, 8.0), (2500, -12.0), (2900, -8.0)):
        x[k] += size * 0.05
        y[k + 7] += size * 0.05
    return replace(run, tension_in_n=x, tension_out_n=y)


def steps(run: Run) -> Run:
    return replace(run, tension_in_n=np.round(run.tension_in_n / 0.1) * 0.1, tension_out_n=np.round(run.tension_out_n / 0.1) * 0.1)


def swelling() -> Run:
    """Loops that grow from nothing, with pauses, and noise that is slower than the filter."""
    t = np.arange(8000) / 200.0
    x = 12.0 + t / 5.0 * np.clip(2.0 * np.sin(2 * np.pi * t / 8.0), -1.0, 1.0)
    run = record(t, x, (0.8, -0.5, 1.25, 0.4), 6, sd=0.01)
    return replace(run, tension_out_n=run.tension_out_n + coloured(8000, 200.0, np.random.default_rng(7), 0.04))


CASES = {
    "trapezoid": (lambda: record(*trapezoid(), ACT, 1), None),
    "slow noise": (lambda: record(*trapezoid(rate=100.0, cycles=3), ACT, 2, colour=True), None),
    "loud": (lambda: record(*trapezoid(rate=200.0, cycles=2), ACT, 3, sd=0.3), None),
    "spiked": (lambda: spiked(record(*trapezoid(cycles=2), ACT, 4, sd=0.05)), None),
    "converter": (lambda: steps(record(*trapezoid(cycles=2), ACT, 5, sd=0.01)), None),
    "sensing": (lambda: record(*trapezoid(low=0.2, seconds=60.0, rate=100.0), SSTL, 4), None),
    "random": (lambda: record(*multisine(3, seconds=150.0), ACT, 1), None),
    "slow clock": (lambda: record(*multisine(8, rate=8.0, seconds=300.0), ACT, 1, sd=0.01), None),
    "swelling": (swelling, None),
    "options": (lambda: record(*trapezoid(rate=200.0), ACT, 8), SegmentOptions(5.0, 1.5, 0.4, 0.05, 9, 3)),
    "outliers": (lambda: outliers(), None),
    "two lines": (lambda: two_lines(), None),
    "hardly moves": (lambda: record(*trapezoid(low=9.0, high=9.6, rate=200.0, cycles=3), (0.9, 0.0, 1.1, 0.0), 3), None),
}


def outliers() -> Run:
    run = record(*trapezoid(rate=200.0, cycles=4), ACT, 9)
    bump = np.where(np.sin(np.arange(len(run)) / 97.0) > 0.8, 0.5, 0.0)
    return replace(run, tension_out_n=run.tension_out_n + bump)


def two_lines() -> Run:
    """The slope changes with every loop, so that no line holds most of the points."""
    t, x = trapezoid(rate=200.0, cycles=5)
    run = record(t, x, ACT, 9)
    return replace(run, tension_out_n=run.tension_out_n * (1.0 + 0.08 * np.floor(t / 12.0)))


def numbers(name: str) -> tuple[str, list[float]]:
    make, options = CASES[name]
    run = make()
    found = segment_run(run, options)
    k = np.arange(len(run))
    plain = label_phases(run.time_s, run.tension_in_n, run.tension_out_n)
    values = [
        *found.theta.values(), *found.theta_se.values(), found.inlier_p, found.inlier_r, found.rmse_p_n, found.rmse_r_n,
        found.noise_sd_n, found.noise_in_sd_n, found.cutoff_hz, found.prominence_n, found.delta_bl_n, found.loops,
        float(found.filtered_in_n @ np.cos(k)), float(found.filtered_out_n @ np.cos(k)),
        float(np.sum((k + 1) * found.phases)), float(np.sum((k + 1) * plain)),
    ]  # fmt: skip
    return found.status, [np.nan if v is None else float(v) for v in values]


def read() -> dict[str, tuple[str, list[float]]]:
    lines = GOLDEN.read_text(encoding="utf-8").splitlines() if GOLDEN.exists() else []
    return {c[0]: (c[1], [float(v) for v in c[2:]]) for c in (line.split(",") for line in lines)}


KNOWN = read()


@pytest.mark.parametrize("name", KNOWN)
def test_the_same_numbers_as_published(name: str) -> None:
    status, found = numbers(name)
    assert status == KNOWN[name][0]
    assert found == pytest.approx(KNOWN[name][1], rel=1e-6, abs=1e-7, nan_ok=True)


def fit(share: float = 1.0) -> _Fit:
    points = (np.zeros(3), np.array([1.0, 2.0, 3.0]), np.array([0.6, 1.5, 1.8]))
    return _Fit(0.6, 0.0, share, points, on_line=share)


@pytest.mark.parametrize(
    ("share", "gamma", "error", "words"),
    [
        (0.49, 0.6, 0.01, "pull: no consistent line (49 % of the output's travel on it)"),
        (0.5, 0.6, 0.01, ""),
        (1.0, None, None, "pull: noise of the input too large for the range in propagation"),
        (1.0, -0.1, 0.01, "pull: slope is not positive"),
        (1.0, 0.0, 0.0, "pull: slope is not positive"),
        (1.0, 0.6, 0.29, ""),
        (1.0, 0.6, 0.31, "pull: slope uncertain by 52 %"),
    ],
)
def test_what_is_not_reported(share: float, gamma: float | None, error: float | None, words: str) -> None:
    line = None if gamma is None or error is None else Line(gamma, 0.0, error, 0.0)
    assert _doubt(0, fit(share), line) == words
    assert _doubt(1, fit(share), line) == words.replace("pull", "release")


def test_spread_of_the_inliers() -> None:
    # residuals 0, 0.3, 0: mean 0.1
    assert fit().spread == pytest.approx(np.sqrt((0.1**2 + 0.2**2 + 0.1**2) / 3))


def test_sixteen_samples_are_enough_to_try() -> None:
    t = np.arange(17.0)
    run = Run("r", "act", t, np.sin(t), np.cos(t))
    for n in (15, 16):
        part = replace(run, time_s=t[:n], tension_in_n=run.tension_in_n[:n], tension_out_n=run.tension_out_n[:n])
        found = segment_run(part)
        assert ("too few samples" in found.status) == (n < 16) and found.loops == 0


def test_what_is_too_large_to_add_up_is_told() -> None:
    run = record(*trapezoid(rate=50.0), ACT)
    with np.errstate(over="ignore"):
        assert segment_run(replace(run, tension_in_n=np.full(len(run), 1e306))).status == "tension_in_n is too large"


def test_trials_and_options_at_their_limits() -> None:
    assert SegmentOptions(ransac_trials=1).ransac_trials == 1 and SegmentOptions(ransac_trials=100_000)
    assert SegmentOptions(cutoff_hz=9.9e8) and (SegmentOptions().ransac_trials, SegmentOptions().seed) == (64, 0)
    for wrong in ({"ransac_trials": 100_001}, {"ransac_trials": 0}, {"cutoff_hz": 1.1e9}, {"delta_bl_n": 0.0}):
        with pytest.raises(UsageError, match="must be"):
            SegmentOptions(**wrong)  # type: ignore[arg-type]


if __name__ == "__main__":
    lines = [",".join([name, status, *(f"{v:.9g}" for v in values)]) for name in CASES for status, values in [numbers(name)]]
    GOLDEN.write_text("\n".join(lines) + "\n", encoding="utf-8")
