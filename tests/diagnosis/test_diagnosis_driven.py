"""The input that drives the simulation, and what is open of it at corners, by hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from rig_logs import sound

from sstl_cli.core.runs import Run
from sstl_cli.diagnosis import driven
from sstl_cli.diagnosis.clock import cornered, tops
from sstl_cli.diagnosis.kalman import MEAN_NEW, TURN
from sstl_cli.diagnosis.latent import Told
from sstl_cli.diagnosis.means import latent_means
from sstl_cli.diagnosis.recorder import Faults
from sstl_cli.diagnosis.smoother import error_of_means

N, DT, FACTOR, NOISE_N = 400, 0.01, 4, 1e-3
T = DT * np.arange(N)
# up and down by 5 N/s each second, with corners between samples
RAMPS = 10.0 + 5.0 * np.abs((T + 0.5034) % 2.0 - 1.0)
READ = RAMPS + NOISE_N * np.random.default_rng(6).standard_normal(N)
EVERY = np.ones(N, bool)


def run(tension=READ, **extra):
    return Run("r", "act", T, tension, 0.5 * tension, extra=extra)


def smoothed(told):
    """Return the latent input, and the law and size of its error without corners."""
    into = latent_means(READ, EVERY, EVERY, 0.0, 1, N, DT, told)
    return into, *error_of_means(into.chain, FACTOR)


def test_a_reading_says_what_the_input_was_unless_it_is_spoilt_at_a_limit_or_bridged():
    spike, frozen, clipped = np.eye(6, dtype=bool)[:3]
    faults = Faults(spike, frozen, clipped, 9.0, 0.0, NOISE_N)
    gap = np.array([0.0, 0.0, 0.0, 1.0, 0.0, 0.0])
    few = Run("r", "act", T[:6], READ[:6], READ[:6], extra={"gap": gap})
    assert driven.known_input(few, faults).tolist() == [False, False, False, False, True, True]


def test_anywhere_between_sample_and_corner_leaves_a_third_of_the_square_open():
    into, law, error_n = smoothed(Told())
    found = driven.input_of(run(), sound(N, NOISE_N), 1, FACTOR, N, DT)
    corner = cornered(into.value, DT)
    at = np.flatnonzero(corner.beyond)
    # corners of 10 N/s in all, at most half a sample away: up to 0.025 N
    assert len(at) >= 3 and np.all(np.abs(corner.beyond[at]) < 0.03) and np.abs(corner.beyond[at]).max() > 5.0 * NOISE_N
    assert np.array_equal(found.u, into.value) and np.array_equal(found.rate, into.rate) and np.array_equal(found.rounds, into.rounds)
    assert np.array_equal(found.corner.beyond, corner.beyond)
    for k in at:
        step, behind = divmod(k, FACTOR)
        # only the part of the step behind a corner shows it in its mean; the end of the step holds all of it
        shown, open_n2 = 1.0 - behind / FACTOR, corner.beyond[k] ** 2 / 3.0 + into.doubt[k] ** 2
        assert (found.error_law - law)[step, MEAN_NEW] == pytest.approx(shown**2 * open_n2, rel=1e-6)
        assert (found.error_law - law)[step, TURN] == pytest.approx((1.0 - shown**2) * open_n2, rel=1e-6, abs=1e-14)
        assert found.error_n[step] == pytest.approx(np.sqrt(error_n[step] ** 2 + open_n2), rel=1e-6)
    # elsewhere all that is open is whether corners are sharp at all
    others = np.setdiff1d(np.arange(N // FACTOR), at // FACTOR)
    doubt = into.doubt.reshape(-1, FACTOR).max(axis=1)
    assert found.error_n[others] == pytest.approx(np.hypot(error_n, doubt)[others])
    changed = found.error_law - law
    changed[:, [MEAN_NEW, TURN]] = 0.0
    assert not changed.any()


def test_a_rounded_input_is_highest_between_samples_and_half_of_that_is_open():
    told = Told(rounded=2.0)
    into, law, error_n = smoothed(told)
    found = driven.input_of(run(), sound(N, NOISE_N), 1, FACTOR, N, DT, told)
    top, most = tops(into.value)
    assert found.corner is None and np.count_nonzero(top) >= 3 and np.array_equal(found.u, into.value + top)
    open_n = 0.5 * most.reshape(-1, FACTOR).max(axis=1)
    assert found.error_n == pytest.approx(np.hypot(error_n, open_n)) and open_n.max() > 0.0
    at = int(np.argmax(most))
    shown = 1.0 - (at % FACTOR) / FACTOR
    assert (found.error_law - law)[at // FACTOR, MEAN_NEW] == pytest.approx((shown * 0.5 * most[at]) ** 2, rel=1e-6)
    assert (found.error_law - law)[at // FACTOR, TURN] == pytest.approx((1.0 - shown**2) * (0.5 * most[at]) ** 2, rel=1e-6, abs=1e-14)


def test_a_reading_that_was_moved_where_the_input_turned_leaves_it_open():
    early = np.zeros(N)
    at = int(np.argmax(RAMPS))
    early[at] = 0.004
    plain = driven.input_of(run(), sound(N, NOISE_N), 1, FACTOR, N, DT)
    moved = driven.input_of(run(early_s=early), sound(N, NOISE_N), 1, FACTOR, N, DT)
    more = moved.error_n**2 - plain.error_n**2
    # half of 4 ms times a turn of up to 10 N/s, in the step of that reading alone
    assert np.flatnonzero(more > 1e-9).tolist() == [at // FACTOR] and np.sqrt(more.max()) <= 0.5 * 0.004 * 10.1


def test_what_is_spoilt_is_bridged_and_means_of_readings_are_taken():
    spoilt, faults = READ.copy(), replace(sound(N, NOISE_N), spike=np.arange(N) == 50)
    spoilt[50] = 99.0
    found = driven.input_of(run(spoilt), faults, 2, 2, N // 2, 2.0 * DT)
    assert len(found.u) == N // 2 and len(found.error_n) == N // 4
    assert found.u == pytest.approx(RAMPS.reshape(-1, 2).mean(axis=1), abs=0.03)
