"""Records laid end to end: what their noise is made of, by hand and by the covariance that it stands for."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from made_fits import simulator

from sstl_cli.diagnosis import laid
from sstl_cli.diagnosis.kalman import BOTH_NEW, MEAN_KEPT, MEAN_NEW, STATE_KEPT, STATE_NEW, TURN
from sstl_cli.diagnosis.records import Start
from sstl_cli.diagnosis.smoother import MOVES
from sstl_cli.diagnosis.whitening import Noise, Sensor, step_of

STEP_S, N = 0.02, 2000
RECORDS = simulator().problem.records
INTO, OUT = Sensor(0.01, 0.004, 0.2), Sensor(0.03, 0.02, 0.1)
NOISE = Noise({"act": INTO}, {"act": OUT}, {"act": 1.5})


def columns(records, noise=NOISE):
    c = laid.constants(records, noise)
    return c, dict(zip(("decay", "fresh", "shown", "both", "mean"), c.own.columns.T, strict=True))


def test_records_begin_where_a_model_does_and_hold_what_is_weighed():
    again = replace(RECORDS[1], again=(Start(700, 1.0, 0.3),), weight=np.where(np.arange(N) < 5, 0.0, 1.0))
    found = laid.layout([RECORDS[0], again, replace(RECORDS[2], told_n=0.1)])
    assert found.begin.tolist() == [0, N, N + 700, 2 * N] and found.whose.tolist() == [0, 1, 1, 2]
    assert np.flatnonzero(found.first).tolist() == found.begin.tolist() and found.slices[2] == slice(2 * N, 3 * N)
    assert found.error_n.tolist() == [RECORDS[0].start_error_n, RECORDS[1].start_error_n, 0.3, RECORDS[2].start_error_n]
    assert np.flatnonzero(~found.keep).tolist() == list(range(N, N + 5))
    assert found.listening[: 2 * N].all() and not found.listening[2 * N :].any()
    # a model begins at a sample of the analysis, several of the simulation
    fewer = {name: getattr(again, name)[: N // 4] for name in ("y", "weight", "readings", "error_law")}
    assert laid.layout([replace(again, factor=4, **fewer)]).begin.tolist() == [0, 175]


def test_slow_noise_of_the_output_is_what_a_step_keeps_of_it():
    c, own = columns(RECORDS[:1])
    step = step_of(1.0, STEP_S / 0.1)
    assert own["decay"][1:] == pytest.approx(np.full(N - 1, np.exp(-0.2))) and own["shown"][1:] == pytest.approx(np.full(N - 1, step.shown))
    assert own["fresh"][1:] == pytest.approx(np.full(N - 1, 0.02**2 * (1.0 - np.exp(-0.4))))
    assert own["both"][1:] == pytest.approx(np.full(N - 1, 0.02**2 * step.both)) and own["mean"][1:] == pytest.approx(0.02**2 * step.mean)
    # before a record it has been what it is: nothing is kept, and all of it is new
    assert (own["decay"][0], own["shown"][0], own["fresh"][0]) == (0.0, 0.0, pytest.approx(0.02**2))
    assert own["mean"][0] == pytest.approx(0.02**2 * step.variance)
    assert c.white_n == pytest.approx(np.full(N, 0.03)) and c.first[0] and not c.first[1:].any()


def test_means_of_several_readings_have_less_white_noise_and_slower_runs_more_of_the_other():
    several = replace(RECORDS[0], readings=np.full(N, 4.0), louder=2.0, slower=3.0)
    c, own = columns([several])
    assert c.white_n == pytest.approx(np.full(N, 2.0 * 0.03 / 2.0))
    step = step_of(4.0, STEP_S / 0.1)
    assert own["fresh"][1:] == pytest.approx(9.0 * 0.02**2 * (1.0 - step.kept**2)) and own["mean"][1:] == pytest.approx(
        9.0 * 0.02**2 * step.mean
    )
    # how much of it a step shows is no size
    assert own["decay"][1:] == pytest.approx(step.kept) and own["shown"][1:] == pytest.approx(step.shown)
    assert c.start[0] == pytest.approx(RECORDS[0].start_error_n ** 2 + 9.0 * 0.02**2) and not c.start[1:].any()
    still = columns([RECORDS[0]], replace(NOISE, output={"act": Sensor(0.0, 0.0, 0.1)}))[0]
    assert np.all(still.white_n > 0.0) and still.white_n.max() < 1e-8


def test_the_law_of_the_input_s_error_is_the_smoother_s_with_the_slow_noise_of_its_sensor():
    r = RECORDS[0]
    law = laid.constants([r], NOISE).error_law
    step = step_of(float(r.factor), STEP_S / 0.2)
    power = 0.004**2
    assert law[1:, STATE_KEPT] == pytest.approx(step.kept) and law[1:, STATE_NEW] == pytest.approx(power * (1.0 - step.kept**2))
    assert law[1:, MEAN_KEPT] == pytest.approx(step.shown) and law[1:, BOTH_NEW] == pytest.approx(power * step.both)
    assert law[1:, MEAN_NEW] == pytest.approx(1.5**2 * r.error_law[1:, MEAN_NEW] + power * step.mean)
    # the end of a step less its mean: what was kept, and what is new
    ends = power * ((step.kept - step.shown) ** 2 + 1.0 - step.kept**2 + step.mean - 2.0 * step.both)
    assert law[1:, TURN] == pytest.approx(1.5**2 * r.error_law[1:, TURN] + ends)
    # how the error moves on is no size, and what the smoother was told of has its noise in the law already
    assert np.array_equal(
        np.delete(law[:, :MOVES], [STATE_KEPT, MEAN_KEPT], axis=1), np.delete(r.error_law[:, :MOVES], [STATE_KEPT, MEAN_KEPT], axis=1)
    )
    told = laid.constants([replace(r, told_n=0.004, told_s=0.2)], NOISE).error_law
    assert told[:, MOVES:] == pytest.approx(1.5**2 * r.error_law[:, MOVES:]) and np.array_equal(told[:, :MOVES], r.error_law[:, :MOVES])


def test_the_scatter_of_an_accepted_model_has_its_size_at_every_sample_and_lasts_as_long_as_it_says():
    size = 0.05 + 0.04 * np.sin(np.arange(N) / 90.0)
    known = replace(RECORDS[0], misfit_n=size, misfit_s=0.5, again=(Start(900, 1.0, 0.1),))
    c, own = columns([known])
    total2 = 0.02**2 + size**2
    variance = 0.0
    for t in range(N):
        variance = own["decay"][t] ** 2 * variance + own["fresh"][t]
        assert variance == pytest.approx(total2[t])
    # as slow as both are together, by their shares of the variance
    share = size**2 / total2
    slow = np.exp(share * np.log(0.5) + (1.0 - share) * np.log(0.1))
    alike = own["decay"][1:] * np.sqrt(total2[:-1] / total2[1:])
    others = np.setdiff1d(np.arange(1, N), [900])
    assert alike[others - 1] == pytest.approx(np.exp(-STEP_S / slow[others])) and own["decay"][0] == own["decay"][900] == 0.0
    # it was measured in means, and is part of what a model begins with
    assert (
        np.array_equal(own["shown"], own["decay"])
        and np.array_equal(own["mean"], own["fresh"])
        and np.array_equal(own["both"], own["fresh"])
    )
    assert c.start[900] == pytest.approx(0.1**2 + 0.02**2 + size[900] ** 2)
    time_s, sd_n = laid.coloured(known, OUT)
    assert time_s == pytest.approx(slow) and sd_n == pytest.approx(np.sqrt(total2))
    plain = laid.coloured(RECORDS[0], OUT)
    assert set(plain[0]) == {0.1} and set(plain[1]) == {0.02}
    # without any noise it is as slow as the sensor's
    assert np.isfinite(laid.coloured(replace(known, misfit_n=np.zeros(N)), Sensor(0.0, 0.0, 0.1))).all()


def test_what_is_known_to_scatter_is_laid_end_to_end_with_its_jerks():
    known = replace(RECORDS[1], misfit_n=np.full(N, 0.3), tail=6.0)
    assert laid.scatter_n([RECORDS[0], known]).tolist() == [0.0] * N + [0.3] * N
    # Student's distribution of six degrees of freedom has a variance of 6 / 4
    assert laid.scatter_rms_n([RECORDS[0], known])[[0, -1]] == pytest.approx([0.0, 0.3 * np.sqrt(1.5)])


def test_a_clock_that_is_off_moves_means_by_the_rate_of_the_input():
    r = replace(RECORDS[0], jitter_s=0.002, rate=np.linspace(-5.0, 5.0, N), readings=np.full(N, 4.0))
    assert laid.late_n(r) == pytest.approx(0.001 * np.abs(r.rate)) and not laid.late_n(RECORDS[0]).any()
    assert laid.constants([r], NOISE).jitter_n == pytest.approx(laid.late_n(r))
