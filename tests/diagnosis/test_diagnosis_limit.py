"""Distances between models, and what a log would have shown, against linear algebra on small made records."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from made_fits import NOISE_N, THETA, made, simulator

from sstl_cli.diagnosis.constants import DECIDABLE
from sstl_cli.diagnosis.evidence import Weighed
from sstl_cli.diagnosis.found import Search
from sstl_cli.diagnosis.hypotheses import full, variants
from sstl_cli.diagnosis.limit import _linear, distance2, least_shown
from sstl_cli.diagnosis.whitening import Noise, Sensor

# of one parameter: with white noise the gaps of several are equal
OFFSET = next(h for h in variants("zero_offset", ("act",)) if [f.parameter.name for f in h.free] == ["z_out_act_n"])
Z_OUT = (0.02,)


def columns(f):
    """Whitened columns of one theta a configuration, shape (samples, 2)."""
    sim = simulator()
    own = np.zeros((len(sim.y), len(THETA)))
    own[np.arange(len(sim.y)), sim.config] = f.jacobian[:, 0]
    return f.whiten(own)


def outside(x, j):
    """Squared length of what is left of ``x`` outside the span of ``j``."""
    return float(np.sum((x - j @ np.linalg.lstsq(j, x, rcond=None)[0]) ** 2))


def search(noise_n):
    quiet = Sensor(noise_n, 0.0, 0.1)
    noise = Noise({"act": quiet}, {"act": quiet}, {"act": 1.0})
    base, one = made(0.0, noise_n=noise_n), made(0.0, OFFSET, Z_OUT, noise_n)
    return Search(simulator(), noise, noise, base, {"zero_offset": (Weighed(one, 0.0, 0.0),)}, {})


def test_a_model_is_at_no_distance_from_itself_nor_the_base_from_what_contains_it():
    truth = made(0.0, OFFSET, Z_OUT)
    assert distance2(simulator(), truth, truth) == 0.0
    assert distance2(simulator(), made(), truth) == pytest.approx(0.0, abs=0.05)


def test_what_readings_say_of_the_moments_of_a_line_is_no_distance():
    """A whitener knows where the line has rested, and what it then expects of the readings: a made output has none of it."""
    f = made(0.0, full("zero_offset", ("act",)), (0.2, 0.0))
    count = np.arange(len(f.residual))
    rested = replace(f.whiten, place=np.where(count % 7 < 3, count, count - count % 7 + 2), shift_n=0.5 * np.sin(count))
    assert distance2(simulator(), replace(f, whiten=rested), replace(f, whiten=rested)) == pytest.approx(0.0, abs=1e-6)


def test_the_distance_to_the_base_is_the_whitened_norm_of_what_theta_cannot_take_up():
    truth, base = made(0.0, OFFSET, Z_OUT), made()
    response = base.whiten(truth.prediction - base.prediction)
    expected = outside(response, columns(base))
    assert 0.0 < expected < 0.999 * float(response @ response)
    assert distance2(simulator(), truth, base) == pytest.approx(expected, rel=0.02)


def test_the_distance_grows_with_the_square_of_size_over_noise():
    one = distance2(simulator(), made(0.0, OFFSET, Z_OUT), made())
    twice = distance2(simulator(), made(0.0, OFFSET, (2.0 * Z_OUT[0],)), made())
    noisy = distance2(simulator(), made(0.0, OFFSET, Z_OUT, 2.0 * NOISE_N), made(noise_n=2.0 * NOISE_N))
    assert twice == pytest.approx(4.0 * one, rel=0.05) and noisy == pytest.approx(one / 4.0, rel=0.01)


def test_what_a_log_would_have_shown_scales_with_its_noise_and_leaves_the_distance_that_decides():
    (quiet,), (loud,) = least_shown(search(NOISE_N), DECIDABLE), least_shown(search(3.0 * NOISE_N), DECIDABLE)
    assert (quiet.effect, quiet.unit) == ("zero_offset", "N")
    assert loud.size == pytest.approx(3.0 * quiet.size)
    # theta follows a larger offset by a curve, no longer by a line
    assert loud.gap_n == pytest.approx(3.0 * quiet.gap_n, rel=1e-3)
    # D^2 = sum of (gap over noise)^2
    assert (quiet.gap_n / NOISE_N) ** 2 * np.sum(simulator().weight > 0) == pytest.approx(DECIDABLE, rel=0.02)


def test_the_least_size_is_indeed_at_the_distance_that_decides():
    (shown,) = least_shown(search(NOISE_N), DECIDABLE)
    assert distance2(simulator(), made(0.0, OFFSET, (shown.size,)), made()) == pytest.approx(DECIDABLE, rel=0.1)


def test_no_size_is_promised_that_the_effect_cannot_have():
    sane = search(NOISE_N)
    loud = search(1e5 * NOISE_N)
    assert least_shown(sane, DECIDABLE) and least_shown(loud, DECIDABLE) == []


def test_a_response_that_theta_takes_up_needs_a_size_beyond_the_linear_one():
    noise_n = 20.0 * NOISE_N
    quiet = Sensor(noise_n, 0.0, 0.1)
    friction = next(h for h in variants("const_friction", ("act",)) if [f.parameter.name for f in h.free] == ["w_l_n"])
    base, one = made(noise_n=noise_n), made(0.0, friction, (0.3,), noise_n)
    found = Search(
        simulator(),
        Noise({"act": quiet}, {"act": quiet}, {"act": 1.0}),
        Noise({}, {}, {}),
        base,
        {"const_friction": (Weighed(one, 0.0, 0.0),)},
        {},
    )
    (shown,) = least_shown(found, DECIDABLE)
    at = made(0.0, friction, (shown.size,), noise_n)
    assert distance2(simulator(), at, base) == pytest.approx(DECIDABLE, rel=0.1)


def test_the_linear_size_is_that_of_the_strength_that_shows_beside_theta():
    f = made(0.0, full("zero_offset", ("act",)), (0.02, 0.02))
    for i in (0, 1):
        # the other one shows nowhere
        jacobian = f.jacobian.copy()
        jacobian[:, 2 - i] = 0.0
        alone = replace(f, jacobian=jacobian)
        information = outside(alone.whiten(jacobian[:, 1 + i]), columns(alone))
        assert _linear(simulator(), alone, DECIDABLE) == (i, pytest.approx(np.sqrt(DECIDABLE / information)))
    assert _linear(simulator(), replace(f, jacobian=f.jacobian * [1.0, 0.0, 0.0]), DECIDABLE) is None
    # a shape is no size
    slow = next(h for h in variants("stribeck", ("act",)) if [x.parameter.name for x in h.free] == ["mean_ratio", "mean_mm_s"])
    assert _linear(simulator(), made(0.0, slow, (1.3, 2.0)), DECIDABLE)[0] == 0


def test_an_effect_without_a_response_promises_nothing():
    found = search(NOISE_N)
    one = found.singles["zero_offset"][0]
    silent = Weighed(replace(one.fit, jacobian=one.fit.jacobian * [1.0, 0.0]), 0.0, 0.0)
    assert least_shown(replace(found, singles={"zero_offset": (silent,)}), DECIDABLE) == []
