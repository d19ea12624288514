"""The white noise of an output from rests, readings and converters, against the pieces it is made of."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from made_fits import simulator

from sstl_cli.diagnosis import white
from sstl_cli.diagnosis.recorder import FOURTHS_ERROR, Faults, fourths, slow_noise, white_noise, white_of_fourths

RECORDS = simulator().problem.records
N = len(RECORDS[0])
SLIDES, RESTS = np.ones(N), np.zeros(N)


def faults(step=0.0):
    none = np.zeros(N, bool)
    return Faults(none, none, none, float("inf"), step, 0.01)


def resting(sd, seed=0, every=1, **more):
    """Return a record whose output is noise about 5 N, read every so many samples."""
    y = 5.0 + sd * np.random.default_rng(seed).standard_normal(N)
    extra = {} if every == 1 else {"known_tension_out_n": (np.arange(N) % every == 0).astype(float)}
    r = RECORDS[0]
    return replace(r, y=y, y_fine=y, raw=replace(r.raw, tension_out_n=y, extra=extra), faults_out=faults(), **more)


def test_the_factor_of_a_mean_is_the_root_of_the_middle_count():
    assert white.averaged([SimpleNamespace(averaged=lambda _, k=k: k) for k in (1, 16, 100)]) == 4.0


def test_a_fast_output_shows_where_it_rests_the_middle_one_of_its_runs():
    runs = [resting(sd, seed) for seed, sd in enumerate((0.01, 0.03, 0.2))]
    half = np.where(np.arange(N) < N // 2, 0.0, 1.0)
    found, off = white.white_of_output([(r, half) for r in runs])
    assert found == pytest.approx(white_noise(runs[1].y_fine, half < 0.5)) and off == 0.05
    # masked samples are no rest, and a louder run is as loud as the others over its factor
    weight = np.where(np.arange(N) < N // 4, 1.0, 0.0)
    one = replace(runs[1], weight_fine=weight, louder=2.0)
    assert white.white_of_output([(one, RESTS)])[0] == pytest.approx(white_noise(one.y_fine, weight > 0.0) / 2.0)


@pytest.mark.parametrize(("share", "rests"), [(0.9e-3, True), (1.1e-3, False)])
def test_a_step_of_which_a_thousandth_slides_is_no_rest(share, rests):
    r = resting(0.02)
    y = np.where(np.arange(N) < N // 2, r.y_fine, r.y_fine + 0.3 * np.random.default_rng(9).standard_normal(N))
    loud = replace(r, y_fine=y)
    slide = np.where(np.arange(N) < N // 2, share, 1.0)
    assert (white.white_of_output([(loud, slide)])[0] < 0.03) is rests


def test_a_slow_output_shows_where_all_its_runs_hold_and_as_well_as_it_is_told_there():
    runs = [resting(0.02, seed, every=5) for seed in (1, 2)]
    slide = np.where(np.arange(N) < N // 2, 0.0, 1.0)
    missed = []
    for r in runs:
        at = np.arange(0, N, 5)
        missed.append(fourths(r.raw.tension_out_n[at], r.raw.time_s[at], at < N // 2))
    whole = np.concatenate(missed)
    found, off = white.white_of_output([(r, slide) for r in runs])
    assert found == pytest.approx(white_of_fourths(whole)) and off == pytest.approx(np.hypot(0.05, FOURTHS_ERROR / np.sqrt(len(whole))))
    # behind a gap nothing rests
    gone = [replace(r, raw=replace(r.raw, extra={**r.raw.extra, "gap": (np.arange(N) < N // 4).astype(float)})) for r in runs]
    assert white.white_of_output([(r, slide) for r in gone])[1] > off
    # sixteen fourths are enough, fifteen are not: then all readings tell, a line that moves as well
    for readings, enough in ((19, True), (18, False)):
        few = np.where(np.arange(N) < 5 * readings, 0.0, 1.0)
        assert (white.white_of_output([(runs[0], few)])[1] > 0.05) is enough
    at = np.arange(0, N, 5)
    assert white.white_of_output([(runs[0], SLIDES)])[0] == pytest.approx(slow_noise(runs[0].raw.tension_out_n[at], runs[0].raw.time_s[at]))


def test_no_white_noise_is_less_than_that_of_its_converter():
    coarse = [replace(resting(0.001, seed, every=5), faults_out=faults(0.6)) for seed in (1, 2)]
    assert white.white_of_output([(r, RESTS) for r in coarse])[0] == pytest.approx(0.6 / np.sqrt(12.0))
    fast = replace(resting(0.001), faults_out=faults(0.6))
    assert white.white_of_output([(fast, RESTS)])[0] == pytest.approx(0.6 / np.sqrt(12.0))
    assert white.white_of(fast.y_fine, replace(fast, faults_in=faults(0.9)), "tension_out_n", RESTS < 0.5) == pytest.approx(
        0.6 / np.sqrt(12.0)
    )
    assert white.least_white(replace(fast, faults_in=faults(0.9)), "tension_in_n") == pytest.approx(0.9 / np.sqrt(12.0))


def test_an_input_shows_where_it_is_known():
    rng = np.random.default_rng(4)
    u = 8.0 + 0.01 * rng.standard_normal(N)
    spoilt = np.arange(N) >= N // 2
    u[spoilt] += 0.5 * rng.standard_normal(N // 2)
    r = replace(RECORDS[0], raw=replace(RECORDS[0].raw, tension_in_n=u), faults_in=replace(faults(), frozen=spoilt))
    assert white.white_of(u, r, "tension_in_n") == pytest.approx(white_noise(u, ~spoilt)) and white_noise(u, ~spoilt) < 0.02
