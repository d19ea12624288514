"""Noise through a play: the filter against the dense covariance, and its innovations on made records."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
import pytest
from made_chain import posterior

from sstl_cli.diagnosis.laid import constants
from sstl_cli.diagnosis.records import Start
from sstl_cli.diagnosis.smoother import Reading, chain, error_of_means
from sstl_cli.diagnosis.wander import Wander
from sstl_cli.diagnosis.whitening import Noise, Phases, Sensor, white, whitener

N, FACTOR, DT = 120, 5, 0.004


@dataclass
class Made:
    """What the filter reads of a record."""

    system: str = "act"
    config: int = 0
    factor: int = FACTOR
    dt_s: float = DT
    error_law: np.ndarray = field(default_factory=lambda: error_of_means(LAW, FACTOR)[0])
    start_n: float = 1.0
    start_error_n: float = 0.02
    again: tuple[Start, ...] = ()
    weight: np.ndarray = field(default_factory=lambda: np.ones(N))
    misfit_n: np.ndarray | None = None
    wander: Wander | None = None
    told_n: float = 0.0
    louder: float = 1.0
    slower: float = 1.0
    jitter_s: float = 0.0
    rate: np.ndarray = field(default_factory=lambda: 3.0 + np.arange(N * FACTOR) / 100.0)

    @property
    def readings(self):
        return np.full(N, float(FACTOR))

    def __len__(self) -> int:
        return N


TIMES = np.arange(N * FACTOR) * DT
READ = 2.0 * np.sin(6.0 * TIMES) + 0.05 * np.random.default_rng(9).standard_normal(N * FACTOR)
KNOWN = np.random.default_rng(8).random(N * FACTOR) > 0.1
CORNERS, BENDS = (np.exp(np.random.default_rng(k).normal(-14.0, 2.0, N * FACTOR)) for k in (1, 2))
PLAIN, TOLD = Reading(0.05**2), Reading(0.05**2, 0.015**2, float(np.exp(-DT / 0.3)))
LAW, _ = chain(READ, KNOWN, PLAIN, CORNERS, BENDS)
NOISE = Noise({"act": Sensor(0.02, 0.015, 0.3)}, {"act": Sensor(0.03, 0.02, 0.1)}, {"act": 1.0})


def phases():
    slide = np.zeros(N)
    slide[20:50] = slide[80:] = 1.0
    left = slide.copy()
    # a slide that ends within a step and one that begins within it: the end of a step is farther than its mean
    slide[50], left[50], slide[79], left[79] = 0.4, 0.7, 0.3, 1.0
    gain = np.where(np.arange(N) < 60, 0.6, 1.7)
    return Phases(slide, left, gain, np.zeros(N))


def dense(ph, told=False):
    """Covariance of h + c + white noise by linear algebra: every sample is a known mix of the input's errors."""
    means = np.kron(np.eye(N), np.full((1, FACTOR), 1.0 / FACTOR))

    def colour(sd, tau):
        lag = np.abs(np.subtract.outer(np.arange(N * FACTOR), np.arange(N * FACTOR))) * DT
        return sd**2 * np.exp(-lag / tau)

    error = posterior(KNOWN, TOLD if told else PLAIN, CORNERS, BENDS)[1] + (0.0 if told else colour(0.015, 0.3))
    into = means @ error @ means.T
    # the end of a step less its mean
    apart = np.kron(np.eye(N), np.eye(FACTOR)[-1:]) - means
    ends = np.diag(apart @ error @ apart.T)
    held = ph.gain[0] ** 2 * into[0, 0]
    mix, start, turned = np.zeros((N, N)), np.zeros(N), np.zeros((N, N))
    # what the line holds at the end of a step, as the same mixes
    kept, began, ended = np.zeros(N), 1.0, np.zeros(N)
    for t in range(N):
        s, r, g = ph.slide[t], ph.left[t], ph.gain[t]
        mix[t], start[t], turned[t] = (1.0 - s) * kept, (1.0 - s) * began, (1.0 - s) * ended
        kept, began, ended = (1.0 - r) * kept, (1.0 - r) * began, (1.0 - r) * ended
        mix[t, t] += s * g
        kept[t] += r * g
        if t and s < ph.slide[t - 1]:
            turn = np.sqrt(1.0 - s / ph.slide[t - 1]) * ph.gain[t - 1]
            turned[t, t] += turn
            ended[t] += turn
    white_n = 0.03 / np.sqrt(FACTOR)
    begin = np.outer(start, start) * (0.02**2 + 0.02**2 + held)
    held_on = turned @ np.diag(np.roll(ends, 1)) @ turned.T
    return mix @ into @ mix.T + held_on + begin + means @ colour(0.02, 0.1) @ means.T + white_n**2 * np.eye(N)


def test_the_filter_is_the_inverse_root_of_the_dense_covariance():
    ph = phases()
    w, sigma = whitener(constants([Made()], NOISE), ph), dense(ph)
    x = np.random.default_rng(0).standard_normal((N, 4))
    z = w(x)
    assert z.T @ z == pytest.approx(x.T @ np.linalg.solve(sigma, x), rel=1e-8)
    assert w.log_det == pytest.approx(np.linalg.slogdet(sigma)[1], rel=1e-10)


@pytest.mark.slow
def test_a_smoother_that_was_told_of_slow_noise_has_it_in_its_error():
    ph, law = phases(), error_of_means(chain(READ, KNOWN, TOLD, CORNERS, BENDS)[0], FACTOR)[0]
    w, sigma = whitener(constants([Made(error_law=law, told_n=0.015)], NOISE), ph), dense(ph, told=True)
    x = np.random.default_rng(0).standard_normal((N, 4))
    z = w(x)
    assert z.T @ z == pytest.approx(x.T @ np.linalg.solve(sigma, x), rel=1e-8)
    assert w.log_det == pytest.approx(np.linalg.slogdet(sigma)[1], rel=1e-10)


def test_masked_samples_count_for_nothing():
    ph = phases()
    keep = np.ones(N)
    keep[30:45] = 0.0
    w = whitener(constants([Made(weight=keep)], NOISE), ph)
    x = np.random.default_rng(1).standard_normal(N)
    other = np.where(keep > 0, x, 1e6)
    used = keep > 0
    sigma = dense(ph)[np.ix_(used, used)]
    assert np.array_equal(w(x), w(other)) and not w(x)[~used].any()
    assert w(x) @ w(x) == pytest.approx(x[used] @ np.linalg.solve(sigma, x[used]), rel=1e-8)


def test_runs_do_not_touch_one_another():
    ph = phases()
    twice = ph.at(np.tile(np.arange(N), 2))
    w, alone = whitener(constants([Made(), Made()], NOISE), twice), whitener(constants([Made()], NOISE), ph)
    x = np.random.default_rng(2).standard_normal(2 * N)
    assert np.allclose(w(x), np.concatenate((alone(x[:N]), alone(x[N:]))))
    assert w.log_det == pytest.approx(2.0 * alone.log_det)


def test_what_a_law_may_be_off_adds_to_the_noise():
    ph = phases()
    off = np.linspace(0.0, 0.1, N)
    w = whitener(constants([Made()], NOISE), ph, off)
    x = np.random.default_rng(3).standard_normal(N)
    assert w(x) @ w(x) == pytest.approx(x @ np.linalg.solve(dense(ph) + np.diag(off**2), x), rel=1e-8)


def test_a_clock_that_is_off_shows_where_the_line_slides_as_much_as_the_input_moves_meanwhile():
    ph = phases()
    w = whitener(constants([Made(jitter_s=0.002)], NOISE), ph)
    late = 0.002 * ph.slide * ph.gain * Made().rate.reshape(N, FACTOR).mean(axis=1) / np.sqrt(FACTOR)
    x = np.random.default_rng(6).standard_normal(N)
    assert w(x) @ w(x) == pytest.approx(x @ np.linalg.solve(dense(ph) + np.diag(late**2), x), rel=1e-8)


def test_white_noise_is_only_scaled():
    w = white(0.5, np.ones(4), [0])
    assert w(np.array([1.0, -2.0, 0.0, 3.0])).tolist() == [2.0, -4.0, 0.0, 6.0]
    assert w.log_det == pytest.approx(8.0 * np.log(0.5))


def test_a_hold_that_nearly_slid_is_off_by_one_number_until_the_next_slide():
    ph = phases()
    touched = (np.arange(N) >= 55) & (np.arange(N) < 79)
    w = whitener(constants([Made()], NOISE), replace(ph, doubt_n=0.05 * touched))
    # the slide that begins within the next step leaves its mean a part of that
    touched = touched + (1.0 - ph.slide) * (np.arange(N) == 79)
    x = np.random.default_rng(4).standard_normal(N)
    assert w(x) @ w(x) == pytest.approx(x @ np.linalg.solve(dense(ph) + 0.05**2 * np.outer(touched, touched), x), rel=1e-8)
