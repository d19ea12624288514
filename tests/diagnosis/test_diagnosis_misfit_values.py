"""Records of several steps a sample, of which some samples say nothing: what counts there, and for how long it does."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest
from made_fits import NOISE_N, made, noise, simulator

from sstl_cli.core.runs import Run
from sstl_cli.diagnosis import discrepancy, louder, misfit, starts
from sstl_cli.diagnosis.clock import Corners
from sstl_cli.diagnosis.kalman import MEAN_NEW, TURN
from sstl_cli.diagnosis.laid import scatter_rms_n
from sstl_cli.diagnosis.recorder import white_of_thirds
from sstl_cli.diagnosis.records import Passes, Problem, passing, prepare
from sstl_cli.diagnosis.residuals import leftover
from sstl_cli.diagnosis.state import turning
from sstl_cli.diagnosis.whitening import white
from sstl_cli.physics.scenario import MisfitSection


@cache
def fast() -> Problem:
    """Return a run of 20 s at 100 Hz: a sample of the analysis is the mean of two steps of the simulation."""
    t, rng = np.arange(0.0, 20.0, 0.01), np.random.default_rng(3)
    u = 12.0 + 9.0 * np.sin(2.0 * np.pi * t / 7.0) + 0.01 * rng.standard_normal(len(t))
    return prepare([Run("r", "act", t, u, 0.6 * u + 0.01 * rng.standard_normal(len(t)), config_id="a")])


R = fast().records[0]
HALF = np.where(np.arange(1000) < 500, 1.0, 0.0)


def section(doubt=None, mean=1.0, sd=0.5, **more):
    """Return a map with knots at 0 and 100 N of the input and at 0 N since the turn: ``mean`` while pulling, its double while releasing."""
    values = {"system": "act", "config_id": "a", "along": "turning", "correlation_s": 2.0, "input_n": (0.0, 100.0), "other": (0.0,)}
    doubts = () if doubt is None else ((doubt,) * 4,)
    return MisfitSection(**{**values, "mean_n": (mean, mean, 2 * mean, 2 * mean), "sd_n": (sd,) * 4, "doubt_n": doubts, **more})


@pytest.mark.parametrize(
    ("weight", "doubt", "seen"),
    # a thousand samples that last 2 s (200 of them as good as one) beside 0.5 N: 20 of the square; half of them 10
    [(np.ones(1000), 0.023, 1), (np.ones(1000), 0.022, 0), (HALF, 0.032, 1), (HALF, 0.031, 0), (np.zeros(1000), 9.0, 0)],
)
@pytest.mark.parametrize("unit_n", [1.0, 4.0])
def test_a_doubt_is_seen_by_the_samples_that_count_and_as_long_as_they_last(weight, doubt, seen, unit_n):
    record = replace(R, weight=weight)
    (known,) = misfit.applied(replace(fast(), records=(record,)), (section(doubt),), unit_n).records
    assert known.wander.bend.shape == (1000, seen)
    assert not seen or np.abs(known.wander.bend) == pytest.approx(np.full((1000, 1), doubt / unit_n))


def test_a_map_is_known_at_every_step_and_its_scatter_at_every_sample():
    (known,) = misfit.applied(fast(), (section(sd=0.5),), 1.0).records
    way = turning(R.u.reshape(-1, 2).mean(axis=1))[0]
    assert known.known == pytest.approx(np.repeat(np.where(way > 0, 1.0, 2.0), 2)) and known.misfit_n == pytest.approx(np.full(1000, 0.5))
    some = replace(fast(), records=(replace(known, weight=HALF),))
    assert misfit.known(some) == pytest.approx(np.where(way > 0, 1.0, 2.0))
    assert misfit.rms_n(some) == pytest.approx(np.sqrt(np.mean(np.where(way[:500] > 0, 1.0, 4.0)) + 0.25))
    assert (
        scatter_rms_n(some.records) == pytest.approx(np.full(1000, 0.5))
        and misfit.rms_n(replace(some, records=(replace(known, weight=0.0 * HALF),))) == 0.0
    )


def test_beyond_its_map_a_model_misses_more_by_rate_and_by_input():
    # inputs of 3 to 21 N, of which the model has seen 10 to 20 N: a span of 10 N
    u = R.u.reshape(-1, 2).mean(axis=1)
    found = misfit._further(section(input_n=(10.0, 20.0)), R, 1.0)
    assert found == pytest.approx(np.maximum(np.maximum(10.0 - u, u - 20.0) / 10.0, 0.0)) and found.max() == pytest.approx(0.7, abs=0.05)
    rate = R.rate.reshape(-1, 2).mean(axis=1)
    fastest = misfit._further(section(rate_n_s=(4.0, 2.0)), R, 1.0)
    assert fastest == pytest.approx(np.maximum(np.abs(rate) / np.where(rate > 0.0, 4.0, 2.0) - 1.0, 0.0))
    # a way in which it has hardly moved counts as a hundredth of the other
    assert misfit._further(section(rate_n_s=(4.0, 0.0)), R, 1.0).max() == pytest.approx(np.abs(rate[rate <= 0.0]).max() / 0.04 - 1.0)
    assert not misfit._further(section(input_n=(10.0, 10.0)), R, 1.0).any()


def test_a_corner_in_the_middle_of_a_step_shows_half_in_its_mean():
    beyond, law = np.zeros(2000), np.ones_like(R.error_law)
    beyond[21] = -0.4
    corner = Corners(np.zeros(2000), beyond, np.zeros(2000))
    record = replace(R, corner=corner, error_law=law, error_n=np.full(1000, 0.5))
    (moved,) = passing(replace(fast(), records=(record,)), Passes(0.0, 1.0 / 12.0)).records
    # a third less a twelfth of the square is known from now on: a quarter of 0.16, of which the mean shows a quarter
    less = law - moved.error_law
    assert less[10, MEAN_NEW] == pytest.approx(0.01) and less[10, TURN] == pytest.approx(0.03) and np.count_nonzero(less) == 2
    assert moved.error_n[10] == pytest.approx(np.sqrt(0.21)) and moved.error_n[11] == 0.5 and moved.u[21] == pytest.approx(R.u[21] - 0.4)


def test_noise_of_a_run_is_read_of_samples_that_count_and_hold():
    rng = np.random.default_rng(8)
    y = 5.0 + 0.03 * rng.standard_normal(1000)
    y[500:] += 9.0 * rng.standard_normal(500)
    record, still = replace(R, y=y, weight=HALF), np.zeros(1000)
    found, error = louder._seen(record, np.zeros(2000), still, 0.0)
    # of one reading, of which a sample is the mean of two
    assert found == pytest.approx(np.log(white_of_thirds(np.abs(np.diff(y[:500], 3))) * np.sqrt(2.0))) and error < 0.1
    assert louder._seen(record, np.zeros(2000), np.where(np.arange(1000) < 500, 1.0, 0.0), 0.0) == (0.0, np.inf)


def test_what_has_no_weight_has_no_part_in_a_test_or_a_span():
    sim, left = simulator(), noise(3)
    counts = np.arange(len(sim.y)) % 4 > 0
    part = replace(
        sim, problem=replace(sim.problem, records=tuple(replace(r, weight=(np.arange(len(r)) % 4 > 0) * 1.0) for r in sim.problem.records))
    )
    f = replace(made(left), whiten=white(NOISE_N, part.weight, [s.start for s in part.slices()]))
    found = leftover(part, replace(f, residual=np.where(counts, left, 77.0)))
    assert found.samples == 6000 and found.chi2 == pytest.approx(np.mean((left[counts] / NOISE_N) ** 2))
    play = SimpleNamespace(parameter=SimpleNamespace(name="gap", least=0.0, most=99.0), effect=SimpleNamespace(plays=("gap",)))
    one = SimpleNamespace(y=np.array([0.0, 4.0, 900.0]), weight=np.array([1.0, 1.0, 0.0]))
    tried = starts.widths(
        one, SimpleNamespace(output={"act": SimpleNamespace(white_n=0.125)}), SimpleNamespace(free=(play,), values=np.zeros(1))
    )
    assert [float(v[0]) for v in tried] == pytest.approx([0.125, 0.25, 0.5, 1.0, 2.0])


def test_a_memory_is_looked_for_within_runs_up_to_a_quarter_of_the_longest():
    slow = np.exp(-np.arange(200) / 40.0)
    one = SimpleNamespace(records=[range(200), range(40)], keep=np.ones(240))
    both = np.concatenate((slow, np.zeros(40)))

    def expected(x, most):
        power = x @ x
        return next((lag for lag in range(1, most) if x[lag:] @ x[:-lag] <= power * np.exp(-1.0)), most)

    assert discrepancy._memory(one, both) == expected(slow, 50) and 1 < expected(slow, 50) < 50
    assert discrepancy._memory(one, np.ones(240)) == 50.0 and discrepancy._memory(one, np.zeros(240)) == 1.0
    assert discrepancy._memory(one, np.tile([1.0, -1.0], 120)) == 1.0


def test_of_a_bend_that_a_model_has_not_seen_the_size_of_the_others_is_known_in_its_unit():
    others = (
        section(config_id="y", mean=2.0, sd=1.0, correlation_path=6.0),
        section(config_id="z", mean=4.0, sd=1.0, correlation_s=4.0, correlation_path=10.0),
    )
    (known,) = misfit.applied(fast(), others, 4.0).records
    # (4 + 16) / 2 and (16 + 64) / 2 of the means, 1 of the scatter each: 26 N^2 on the mean
    assert known.known is None and known.misfit_n == pytest.approx(np.full(1000, np.sqrt(26.0) / 4.0))
    # a path of 8 N is one of 2 in the unit of the record
    speed = np.abs(R.rate).reshape(-1, 2).mean(axis=1)
    assert known.misfit_s == pytest.approx(1.0 / (1.0 / 3.0 + speed / 2.0))
