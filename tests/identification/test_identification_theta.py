"""Theta: accuracy, honest errors, nulls with a reason, and invariances."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from identification_loops import ACT, NAMES, SSTL, multisine, play, record, trapezoid
from scipy.stats import binom
from soon import asked

from sstl_cli.core.errors import UsageError
from sstl_cli.core.runs import Run
from sstl_cli.identification import SegmentOptions, segment_run


def values(found):
    return np.array([np.nan if found.theta[n] is None else found.theta[n] for n in NAMES])


def errors(found):
    return np.array([np.nan if found.theta_se[n] is None else found.theta_se[n] for n in NAMES])


def sinusoid(seconds=100.0, rate=500.0, mid=10.0, half=5.0):
    t = np.arange(round(seconds * rate)) / rate
    return t, mid - half * np.cos(2 * np.pi * t / seconds)


@pytest.mark.parametrize("seed", asked(range(3), 0, 2))
def test_trapezoid_within_one_percent(seed):
    found = segment_run(record(*trapezoid(), ACT, seed))
    assert found.status == "ok"
    assert found.loops == 1
    assert np.abs(values(found)[[0, 2]] / np.array(ACT)[[0, 2]] - 1).max() < 0.01
    assert np.abs(values(found)[[1, 3]] - np.array(ACT)[[1, 3]]).max() < 0.03


def test_random_multisine_within_one_percent_with_many_loops():
    found = segment_run(record(*multisine(3), ACT, 1))
    assert found.status == "ok"
    assert found.loops > 10
    assert np.abs(values(found)[[0, 2]] / np.array(ACT)[[0, 2]] - 1).max() < 0.01


def test_sinusoid_finds_pull_and_says_why_not_release():
    # 10 +- 5 N: release needs T_in to fall to (0.58 * 15 - 1.44 + 1.04) / 1.69 = 4.91 N, below the 5 N reached
    found = segment_run(record(*sinusoid(), ACT, 2))
    assert found.theta["gamma_p"] == pytest.approx(0.58, rel=0.01)
    assert found.theta["gamma_r"] is None and found.theta_se["gamma_r"] is None and found.inlier_r is None
    assert found.status.startswith("release: ")


def test_sinusoid_with_weak_friction_finds_both():
    lines = (0.8, 0.0, 1.25, 0.0)
    found = segment_run(record(*sinusoid(), lines, 2))
    assert found.status == "ok"
    assert np.abs(values(found)[[0, 2]] / np.array(lines)[[0, 2]] - 1).max() < 0.01


def test_sstl_release_is_a_small_part_of_the_loop():
    t, x = trapezoid(low=0.2, seconds=60.0)
    found = segment_run(record(t, x, SSTL, 4))
    assert found.status == "ok"
    assert found.theta["gamma_r"] == pytest.approx(3.3, abs=max(3 * found.theta_se["gamma_r"], 0.01))
    assert found.theta_se["gamma_r"] < 0.05


def test_without_noise_the_lines_are_exact():
    found = segment_run(record(*trapezoid(cycles=2), ACT, sd=0.0))
    assert found.status == "ok"
    assert values(found) == pytest.approx(ACT, rel=1e-9)


def test_golden(num_regression):
    t, x = trapezoid(rate=100.0, cycles=2)
    wiggle = 0.02 * np.sin(np.arange(len(t)) * 1.7) + 0.01 * np.cos(np.arange(len(t)) * 2.9)
    found = segment_run(Run("golden", "act", t, x + wiggle, play(x, ACT) - wiggle))
    document = {"theta": values(found), "se": errors(found), "counts": np.bincount(found.phases, minlength=4)}
    num_regression.check({k: np.asarray(v, float) for k, v in document.items()}, default_tolerance={"rtol": 1e-6, "atol": 0})


@settings(max_examples=25, deadline=None)
@given(gp=st.floats(0.3, 0.9), gr=st.floats(1.1, 2.0), bp=st.floats(-2, 0.3), br=st.floats(-0.3, 1.5), seed=st.integers(0, 10**6))
def test_any_lines_are_recovered_within_their_errors(gp, gr, bp, br, seed):
    lines = (gp, bp, gr, br)
    t, x = trapezoid(low=1.0, seconds=24.0, rate=200.0)
    found = segment_run(record(t, x, lines, seed))
    y = play(x, lines)
    for d, name in ((0, "p"), (2, "r")):
        at_line = np.abs(y - lines[d] * x - lines[d + 1]) < 1e-9
        if found.theta[f"gamma_{name}"] is None:
            assert np.ptp(x[at_line]) < 2.0, found.status
        else:
            z = (found.theta[f"gamma_{name}"] - lines[d]) / found.theta_se[f"gamma_{name}"]
            assert abs(z) < 6


def covered(colour, lines, cycles, runs, **movement):
    t, x = trapezoid(rate=100.0, cycles=cycles, **movement)
    y = play(x, lines)
    hits = np.zeros(4)
    for seed in range(runs):
        found = segment_run(record(t, x, lines, seed + 10_000, colour=colour, y=y))
        assert found.status == "ok"
        hits += np.abs(values(found) - lines) < 1.96 * errors(found)
    return hits


@pytest.mark.parametrize("colour", [False, True], ids=["white", "coloured"])
def test_intervals_cover_the_truth(colour):
    runs = 250
    hits = covered(colour, ACT, 3, runs)
    # 93-97 % coverage, with the room that 250 draws need (99.9 % of a binomial)
    low, high = binom.ppf(0.001, runs, 0.93), binom.ppf(0.999, runs, 0.97)
    assert (hits >= low).all() and (hits <= high).all(), hits / runs


def test_naive_errors_would_not_cover():
    """The coloured noise of the coverage test is strong enough to break independent-sample errors."""
    t, x = trapezoid(rate=100.0, cycles=3)
    y = play(x, ACT)
    naive = []
    for seed in range(60):
        run = record(t, x, ACT, seed, colour=True, y=y)
        keep = (np.abs(y - 0.58 * x + 1.44) < 1e-9) & (x < 29.99) & (x > 5.01)
        a = np.c_[run.tension_in_n[keep], np.ones(keep.sum())]
        fit, rss, *_ = np.linalg.lstsq(a, run.tension_out_n[keep], rcond=None)
        se = np.sqrt(rss[0] / (keep.sum() - 2) * np.linalg.inv(a.T @ a)[0, 0])
        naive.append(abs(fit[0] - 0.58) < 1.96 * se)
    assert np.mean(naive) < 0.7


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        (lambda r: replace(r, tension_in_n=np.full(len(r), 7.0)), "tension_in_n is constant"),
        (lambda r: replace(r, tension_out_n=np.full(len(r), 7.0)), "tension_out_n is constant"),
        (lambda r: replace(r, tension_in_n=np.where(np.arange(len(r)) == 9, np.nan, r.tension_in_n)), "1 not-a-number"),
        (lambda r: replace(r, tension_out_n=np.where(np.arange(len(r)) == 9, np.inf, r.tension_out_n)), "1 not-a-number"),
        (lambda r: replace(r, time_s=r.time_s[::-1].copy()), "time repeats or runs backwards"),
        (lambda r: replace(r, time_s=np.repeat(r.time_s[::2], 2)), "time repeats or runs backwards"),
        (lambda r: cut(r, 5), "too few samples (5)"),
        (lambda r: cut(r, 1), "too few samples (1)"),
        (lambda r: cut(r, 0), "too few samples (0)"),
        (lambda r: replace(r, tension_in_n=r.tension_in_n * 0 + np.random.default_rng(0).normal(7, 0.02, len(r))), "input does not move"),
    ],
)
def test_what_cannot_be_identified_is_null_with_a_reason(change, reason):
    run = change(record(*trapezoid(), ACT))
    found = segment_run(run)
    assert reason in found.status
    assert not found.ok
    assert set(found.theta.values()) == {None} and set(found.theta_se.values()) == {None}
    assert len(found.phases) == len(run)


def cut(run, n):
    return replace(run, time_s=run.time_s[:n], tension_in_n=run.tension_in_n[:n], tension_out_n=run.tension_out_n[:n])


def test_a_run_that_stays_in_backlash_has_no_lines():
    t, x = trapezoid(low=10.0, high=14.0)
    y = np.full(len(t), 10.0)
    found = segment_run(record(t, x, ACT, y=y))
    assert set(found.theta.values()) == {None}
    assert "pull: no propagation reached" in found.status and "release: no propagation reached" in found.status
    assert set(found.phases.tolist()) == {0, 2}


def test_an_output_that_falls_when_pulled_has_no_lines():
    run = record(*trapezoid(), ACT)
    found = segment_run(replace(run, tension_out_n=-run.tension_out_n))
    assert set(found.theta.values()) == {None}


def test_single_sample_spikes_do_not_matter():
    run = record(*trapezoid(cycles=2), ACT, 5)
    at = np.arange(100, len(run) - 100, 97)
    dirty = run.tension_out_n.copy()
    dirty[at] += 5.0
    found, clean = segment_run(replace(run, tension_out_n=dirty)), segment_run(run)
    assert found.loops == clean.loops == 2
    assert np.all(np.abs(values(found) - values(clean)) < errors(clean))


@pytest.mark.parametrize("size", [9.0, -9.0, 40.0])
@pytest.mark.parametrize("channel", ["tension_in_n", "tension_out_n"])
def test_spikes_at_both_ends_do_not_matter(channel, size):
    run = record(*trapezoid(cycles=2), ACT, 5)
    dirty = getattr(run, channel).copy()
    dirty[0] += size
    dirty[-1] -= size
    found, clean = segment_run(replace(run, **{channel: dirty})), segment_run(run)
    assert found.loops == clean.loops == 2
    assert np.all(np.abs(values(found) - values(clean)) < errors(clean))
    assert np.mean(found.phases == clean.phases) > 0.999


BASE = record(*trapezoid(rate=200.0, cycles=3), ACT, 8)


@settings(max_examples=12, deadline=None)
@given(c=st.floats(0.01, 100.0))
def test_scaling_tensions_scales_beta_and_leaves_gamma(c):
    scaled = segment_run(replace(BASE, tension_in_n=c * BASE.tension_in_n, tension_out_n=c * BASE.tension_out_n))
    plain = segment_run(BASE)
    factor = np.array([1, c, 1, c])
    assert values(scaled) == pytest.approx(factor * values(plain), rel=1e-6)
    assert errors(scaled) == pytest.approx(factor * errors(plain), rel=1e-4)
    assert np.mean(scaled.phases == plain.phases) > 0.999


@settings(max_examples=8, deadline=None)
@given(shift=st.integers(-100_000, 100_000))
def test_a_constant_added_to_time_changes_nothing(shift):
    moved = segment_run(replace(BASE, time_s=BASE.time_s + shift))
    assert values(moved) == pytest.approx(values(segment_run(BASE)), rel=1e-6)


def test_an_offset_of_both_sensors_goes_into_beta():
    moved = segment_run(replace(BASE, tension_in_n=BASE.tension_in_n + 2.0, tension_out_n=BASE.tension_out_n + 3.0))
    plain = values(segment_run(BASE))
    expected = plain + np.array([0, 3 - 2 * plain[0], 0, 3 - 2 * plain[2]])
    assert values(moved) == pytest.approx(expected, abs=1e-6)


def test_twice_the_sampling_rate_gives_the_same_lines_within_their_errors():
    t, x = trapezoid(rate=400.0, cycles=3)
    run = record(t, x, ACT, 3)
    half = replace(run, time_s=t[::2], tension_in_n=run.tension_in_n[::2], tension_out_n=run.tension_out_n[::2])
    a, b = segment_run(run), segment_run(half)
    assert np.all(np.abs(values(a) - values(b)) < 4 * errors(b))
    assert np.all(errors(a) < errors(b))


def test_the_answer_depends_on_seed_and_run_only():
    again = segment_run(BASE)
    for _ in range(2):
        segment_run(record(*trapezoid(), ACT, 1))
        assert np.array_equal(values(again), values(segment_run(BASE)))


@pytest.mark.parametrize("name", ["cutoff_hz", "prominence_n", "delta_bl_n", "ransac_threshold_n"])
@pytest.mark.parametrize("bad", [0.0, -1.0, float("nan"), float("inf")])
def test_wrong_options_are_refused(name, bad):
    with pytest.raises(UsageError) as caught:
        SegmentOptions(**{name: bad})
    assert name.replace("_", "-") in str(caught.value) and caught.value.exit_code == 2


def test_wrong_trials_and_cutoff_above_nyquist_are_refused():
    with pytest.raises(UsageError, match="E211"):
        SegmentOptions(ransac_trials=0)
    with pytest.raises(UsageError, match="E212"):
        segment_run(BASE, SegmentOptions(cutoff_hz=100.0))


def test_options_override_what_is_derived():
    found = segment_run(BASE, SegmentOptions(cutoff_hz=5.0, prominence_n=1.5, delta_bl_n=0.4, ransac_threshold_n=0.3))
    assert (found.cutoff_hz, found.prominence_n, found.delta_bl_n) == (5.0, 1.5, 0.4)
    assert values(found) == pytest.approx(ACT, abs=0.02)
    tight = segment_run(BASE, SegmentOptions(ransac_threshold_n=0.01))
    assert tight.inlier_p is None or tight.inlier_p < found.inlier_p


def test_noise_level_is_estimated():
    found = segment_run(record(*trapezoid(), ACT, 6, sd=0.05))
    assert found.noise_sd_n == pytest.approx(0.05, rel=0.06)
    assert found.noise_in_sd_n == pytest.approx(0.05, rel=0.06)


@pytest.mark.parametrize("seed", asked(range(8), 0, 3))
def test_slow_noise_around_a_constant_input_is_not_a_loop(seed):
    t = np.arange(6000) / 500.0
    found = segment_run(record(t, np.full(len(t), 10.0), ACT, seed, colour=True, y=np.full(len(t), 5.0)))
    assert set(found.theta.values()) == {None}, found.theta
