"""Edges of what is a fault of the recorder and of what data hold, met exactly."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from sstl_cli.diagnosis import recorder
from sstl_cli.diagnosis.recorder import four_in_a_row, fourths, quiet, white_noise
from sstl_cli.diagnosis.shrink import Interval, identifiability


@pytest.mark.parametrize(("held", "limit"), [(50, True), (49, False)])
def test_on_a_coarse_grid_a_limit_is_held_twice_as_often_as_any_rest(monkeypatch, held, limit):
    y = np.repeat([0.0, 1.0, 2.0, 3.0], [20, 25, 15, held])
    flat, noise = y == 3.0, float(np.hypot(0.4, 1.0 / np.sqrt(12.0)))
    monkeypatch.setattr(recorder, "white_noise", lambda *_: noise)
    monkeypatch.setattr(recorder, "quantisation", lambda _: 1.0)
    monkeypatch.setattr(recorder, "_clipped", lambda *_: (flat, 3.0))
    found = recorder.scan(y)
    assert np.array_equal(found.clipped, flat & limit) and found.clip_level_n == (3.0 if limit else np.inf)


def test_a_frozen_stretch_has_no_noise_and_what_is_at_a_limit_is_not_frozen(monkeypatch):
    rng = np.random.default_rng(3)
    y = np.cumsum(rng.standard_normal(1200)) * 0.001 + 0.05 * rng.standard_normal(1200)
    y[100:400] = y[100]
    found = recorder.scan(y)
    assert np.flatnonzero(found.frozen).tolist() == list(range(101, 400))
    assert found.noise_n == pytest.approx(white_noise(y, ~found.frozen)) and found.noise_n > white_noise(y)
    # where only a part was recorded noise is that of the part
    part = np.arange(1200) >= 380
    assert recorder.scan(y, None, part).noise_n == pytest.approx(white_noise(y, part & ~found.frozen))
    monkeypatch.setattr(recorder, "_clipped", lambda *_: (np.arange(1200) < 250, 9.0))
    limited = recorder.scan(y)
    assert np.flatnonzero(limited.frozen).tolist() == list(range(250, 400)) and np.flatnonzero(limited.clipped).tolist() == list(range(250))


def test_noise_is_the_mean_size_of_all_but_the_loudest_twentieth():
    sizes = np.concatenate((np.linspace(0.0, 1.0, 96), [50.0, 60.0, 70.0, 80.0, 90.0]))
    assert quiet(sizes) == pytest.approx(0.5 / 0.717) and quiet(np.full(7, 0.717)) == pytest.approx(1.0)


def test_four_in_a_row_are_all_set():
    where = np.array([1, 1, 1, 1, 0, 1, 1, 1, 1, 1], bool)
    assert four_in_a_row(where).tolist() == [True, False, False, False, False, True, True]
    signal, time = np.random.default_rng(1).standard_normal(10), np.array([0.0, 1.0, 3.0, 4.0, 5.0, 7.0, 8.0, 9.0, 11.0, 12.0])
    every = fourths(signal, time)
    assert fourths(signal, time, where) == pytest.approx(every[[0, 5, 6]]) and len(fourths(signal[:4], time[:4])) == 0
    # a parabola misses nothing, whatever its instants
    assert fourths(3.0 - time + 0.5 * time**2, time) == pytest.approx(np.zeros(7), abs=1e-9)


def test_a_sample_is_back_within_eight_noises_or_a_fifth_of_what_stood_off():
    def spiked(beside, height=10.0):
        y = np.zeros(20)
        y[[9, 10]] = beside, height
        return bool(recorder._back(y, 10, 11, 0.1))

    assert spiked(0.8, 1.0) and not spiked(0.9, 1.0) and spiked(1.9) and not spiked(2.1) and spiked(-1.9) and not spiked(-2.1)


@pytest.mark.parametrize(
    ("low", "high", "neutral", "shape", "label"),
    [
        # a range of 4: twice as wide says nothing, half as wide is needed, clear of neutral unless it is a shape
        (1.0, 9.1, 0.0, False, "not_identifiable"), (1.0, 8.9, 0.0, False, "weak"), (1.0, 2.9, 0.0, False, "identifiable"), (1.0, 3.1, 0.0, False, "weak"),
        (-0.1, 1.0, 0.0, False, "weak"), (-0.1, 1.0, 0.0, True, "identifiable"), (-2.0, -0.1, 0.0, False, "identifiable"), (0.0, 1.0, 0.0, False, "weak"),
        (-1.0, 0.0, 0.0, False, "weak"), (2.5, 3.5, 3.0, False, "weak"), (1.0, 3.0, 0.0, False, "weak"), (1.0, 9.0, 0.0, False, "weak"),
    ],
)  # fmt: skip
def test_a_number_is_identifiable_within_half_of_its_range(low, high, neutral, shape, label):
    f = SimpleNamespace(free=[SimpleNamespace(width=4.0, parameter=SimpleNamespace(neutral=neutral, shape=shape))])
    assert identifiability(f, 0, Interval(0.5 * (low + high), low, high)) == label
    assert identifiability(f, 0, None) == "not_identifiable"
