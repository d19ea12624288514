"""Jitter of a clock that its stamps do not tell: found from what a smooth input leaves."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from sstl_cli.diagnosis.jitter import Piece, unstamped

RNG = np.random.default_rng(21)
N, DT = 6000, 0.02
RATE = 8.0 * np.sin(np.arange(N) * 0.01)


def piece(jitter_s, sensor="act", white_n=0.01):
    return Piece(sensor, white_n * RNG.standard_normal(N) + jitter_s * RATE * RNG.standard_normal(N), RATE, DT)


@pytest.mark.parametrize("jitter_s", [0.001, 0.002])
def test_jitter_is_what_grows_with_the_rate_whatever_the_noise_of_each_sensor(jitter_s):
    assert unstamped([piece(jitter_s), piece(jitter_s, "sstl", 0.02)]) == pytest.approx(jitter_s, rel=0.1)


def test_an_even_clock_has_none():
    assert unstamped([piece(0.0), piece(0.0, "sstl", 0.03)]) == 0.0
    # too few readings, and none
    assert unstamped([replace(p, left_n=p.left_n[:100], rate=p.rate[:100]) for p in [piece(0.002)]]) == 0.0 == unstamped([])


def test_no_clock_is_off_by_more_than_it_can_be():
    assert unstamped([piece(0.4 * DT)]) == pytest.approx(0.2 * DT)
