"""Scores against worked numbers, references against the paper's description."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sstl_cli.control import references
from sstl_cli.control.scoring import reduction_pct, score, windows
from sstl_cli.core.errors import SstlError


def test_worked_example():
    s = score(np.array([10.0, 20.0, 0.1]), np.array([9.0, 22.0, 0.1]), floor_n=0.5)
    assert s.rmse_n == pytest.approx(np.sqrt(5 / 3))
    assert s.std_n == pytest.approx(np.sqrt(5 / 3 - 1 / 9))
    assert s.mape_pct == pytest.approx(10.0)
    assert s.masked_pct == pytest.approx(100 / 3)


def test_mape_is_null_where_every_reference_is_below_the_floor():
    s = score(np.array([0.1, 0.2]), np.array([1.0, 1.0]))
    assert s.mape_pct is None and s.masked_pct == 100.0 and s.rmse_n > 0


pairs = st.lists(st.tuples(st.floats(0.5, 50), st.floats(-50, 50)), min_size=1, max_size=50)


@given(pairs)
def test_mape_never_exceeds_its_bound_and_std_never_rmse(values):
    reference, output = np.array(values).T
    s = score(reference, output)
    assert s.mape_pct <= s.mape_bound_pct * (1 + 1e-9) + 1e-12
    assert s.std_n <= s.rmse_n * (1 + 1e-9) + 1e-9


def test_published_mape_without_bias_is_above_the_bound():
    reference = references.sinusoid().tension_n
    rms_inverse = float(np.sqrt(np.mean(1 / reference**2)))
    assert rms_inverse == pytest.approx(0.1241, abs=1e-4)
    assert 100 * 2.27 * rms_inverse < 35.84


@pytest.mark.parametrize("output", [np.array([1.0]), np.array([1.0, np.nan])])
def test_unusable_output_is_refused(output):
    with pytest.raises(SstlError, match="E409"):
        score(np.array([1.0, 2.0]), output)


def test_windows_leave_out_the_first_cycle_only_where_something_is_left():
    time = np.arange(100) * 0.1
    assert windows(time, 5.0)["without first cycle"] == slice(50, None)
    assert list(windows(time, 10.0)) == ["all"]


def test_reduction():
    assert reduction_pct(1.0, 4.0) == 75.0
    assert reduction_pct(1.0, None) is None


def test_random_reference_is_seeded_and_spans_5_to_30():
    a, b, c = (references.random(np.random.default_rng(s)) for s in (1, 1, 2))
    assert np.array_equal(a.tension_n, b.tension_n) and not np.array_equal(a.tension_n, c.tension_n)
    assert (a.tension_n.min(), a.tension_n.max()) == (5.0, 30.0)
    assert len(a.tension_n) == 200_000 and a.dt_s == 0.002
    spectrum = np.abs(np.fft.rfft(a.tension_n - a.tension_n.mean())) ** 2
    inside = (np.fft.rfftfreq(len(a.tension_n), 0.002) > 0.015) & (np.fft.rfftfreq(len(a.tension_n), 0.002) < 0.155)
    assert spectrum[inside].sum() > 0.99 * spectrum.sum()


def test_sinusoid_is_the_papers():
    r = references.sinusoid(cycles=1)
    assert (r.tension_n.min(), r.tension_n.max(), len(r.tension_n)) == (pytest.approx(5.0), pytest.approx(15.0), 50_000)


def test_trapezoid_holds_and_ramps():
    r = references.trapezoid(cycles=1)
    at = dict(zip(r.time_s.round(3).tolist(), r.tension_n.tolist(), strict=True))
    assert [at[t] for t in (0.0, 2.4, 5.0, 8.4, 11.5)] == pytest.approx([5.0, 10.0, 15.0, 10.0, 5.0])


def test_recorded_samples_are_resampled_and_their_first_cycle_found():
    time = np.arange(0, 40, 0.1)
    r = references.from_samples("mine", time, 10 - 5 * np.cos(2 * np.pi * time / 10), 0.02)
    assert r.dt_s == pytest.approx(0.02)
    assert r.cycle_s == pytest.approx(10.0, abs=0.05)
    np.testing.assert_allclose(r.tension_n, 10 - 5 * np.cos(2 * np.pi * r.time_s / 10), atol=0.01)


@pytest.mark.parametrize(("time", "tension"), [([0.0], [1.0]), ([0.0, 0.0], [1.0, 2.0]), ([0.0, 1.0], [1.0, np.nan])])
def test_unusable_samples_are_refused(time, tension):
    with pytest.raises(SstlError, match="E407"):
        references.from_samples("mine", np.array(time), np.array(tension), 0.002)
