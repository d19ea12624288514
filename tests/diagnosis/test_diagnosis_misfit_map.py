"""What a model is known to leave, applied to records: map, doubt and scatter, by hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from made_fits import NOISE_N, THETA, made, simulator

from sstl_cli.diagnosis.misfit import applied, beyond, known, rescaled, rms_n
from sstl_cli.diagnosis.simulator import Simulator
from sstl_cli.diagnosis.state import turning
from sstl_cli.diagnosis.whitening import Noise, Sensor
from sstl_cli.physics.scenario import MisfitSection

SIM = simulator()
QUIET = Sensor(NOISE_N, 1e-4, 0.1)
NOISE = Noise({"act": Sensor(1e-4, 1e-6, 0.1)}, {"act": QUIET}, {"act": 1.0})


def section(config="a", mean=1.0, sd=0.5, **more):
    """Return a map with knots at 0 and 100 N of the input and at 0 N since the turn: ``mean`` while pulling, its double while releasing."""
    values = {"system": "act", "config_id": config, "along": "turning", "correlation_s": 2.0, "input_n": (0.0, 100.0), "other": (0.0,)}
    return MisfitSection(**{**values, "mean_n": (mean, mean, 2 * mean, 2 * mean), "sd_n": (sd,) * 4, **more})


def test_records_know_the_map_of_their_own_bend_and_only_the_size_of_another_s():
    sections = (section("a", 1.0), section("b", 10.0, 0.25))
    found = applied(SIM.problem, sections, 2.0)
    for r, size in zip(found.records, (1.0, 10.0, 1.0, 10.0), strict=True):
        way = turning(r.u)[0]
        assert r.known == pytest.approx(np.where(way > 0, size, 2.0 * size) / 2.0)
        assert r.misfit_n == pytest.approx(np.full(len(r), (0.5 if size == 1.0 else 0.25) / 2.0))
        assert np.array_equal(r.misfit_s, np.full(len(r), 2.0)) and r.tail == float("inf") and r.wander.bend.shape == (len(r), 0)
    other = applied(SIM.problem, (section("a"), section("z", 3.0, correlation_s=4.0)), 1.0).records[1]
    # 2.5 and 22.5 of the means, 0.25 of the scatter
    assert other.known is None and other.misfit_n == pytest.approx(np.full(2000, np.sqrt(12.5 + 0.25))) and np.all(other.misfit_s == 3.0)
    assert applied(SIM.problem, (), 1.0) is SIM.problem
    assert applied(SIM.problem, (section(system="sstl"),), 1.0).records[0].misfit_n is None
    # a map along the stroke says nothing of where a line that no motion drives stands
    along = applied(SIM.problem, (section("a", along="position"),), 1.0).records[0]
    assert along.known is None and along.misfit_n[0] == pytest.approx(np.sqrt(2.5 + 0.25))


def test_what_is_known_is_laid_end_to_end_and_has_a_size():
    first, *rest = applied(SIM.problem, (section("a"), section("b", 10.0)), 1.0).records
    some = replace(SIM.problem, records=(replace(first, known=None, misfit_n=None), *rest))
    assert np.array_equal(known(some)[:2000], np.zeros(2000)) and known(some)[2000:4000] == pytest.approx(rest[0].known)
    total = sum(np.sum(r.known**2 + 0.25) for r in rest)
    assert rms_n(some) == pytest.approx(np.sqrt(total / 8000)) and rms_n(SIM.problem) == 0.0


def test_sections_are_kept_in_the_units_of_the_recording():
    there = rescaled(section(mean=1.0, sd=0.5, other=(3.0,)), 10.0)
    assert (there.input_n, there.other, there.mean_n, there.sd_n) == ((0.0, 1000.0), (30.0,), (10.0, 10.0, 20.0, 20.0), (5.0,) * 4)
    # a place along the stroke is in mm
    assert rescaled(section(along="position", other=(3.0,)), 10.0).other == (3.0,) and there.correlation_s == 2.0
    # the path of a scatter, the size of the map, its doubt and the fastest input are kept as well
    more = {"correlation_path": 4.0, "size_n": 0.5, "doubt_n": ((1.0,) * 4,), "rate_n_s": (7.0, 8.0), "tail": 3.0}
    there = rescaled(section(**more), 10.0)
    assert (there.correlation_path, there.size_n, there.rate_n_s, there.tail) == (40.0, 5.0, (70.0, 80.0), 3.0)
    assert there.doubt_n == ((10.0,) * 4,) and rescaled(section(along="position", **more), 10.0).correlation_path == 4.0


def test_what_is_not_known_of_a_map_is_a_direction_common_to_all_records_of_its_bend():
    # nothing is known of the map while pulling but that it is one, and all of it while releasing
    doubt = ((0.3, 0.3, 0.0, 0.0),)
    found = applied(SIM.problem, (section("a", doubt_n=doubt), section("b")), 1.0).records
    for r, bend in zip(found, "abab", strict=True):
        expected = np.where(turning(r.u)[0] > 0, 0.3, 0.0) if bend == "a" else np.zeros(len(r))
        assert np.abs(r.wander.bend[:, 0]) == pytest.approx(expected)
    # a doubt that no sample shows beside the scatter is left out
    assert applied(SIM.problem, (section("a", doubt_n=((1e-6,) * 4,)),), 1.0).records[0].wander.bend.shape[1] == 0


def test_beyond_what_a_model_has_seen_it_may_miss_more_in_proportion():
    r = SIM.problem.records[0]
    fastest = max(np.abs(r.rate).max(), 1e-9)
    total = np.sqrt(2.5 + 0.25)
    slow = applied(SIM.problem, (section("a", rate_n_s=(fastest / 3.0,) * 2),), 1.0).records[0]
    at = int(np.argmax(np.abs(r.rate)))
    assert slow.misfit_n[at] == pytest.approx(np.hypot(0.5, 2.0 * total)) and slow.misfit_n.min() == pytest.approx(0.5)
    low = applied(SIM.problem, (section("a", input_n=(0.0, 10.0)),), 1.0).records[0]
    top = int(np.argmax(r.u))
    assert low.misfit_n[top] == pytest.approx(np.hypot(0.5, total * (r.u[top] / 10.0 - 1.0)))


def test_a_simulator_beyond_what_it_leaves_has_the_map_and_the_scatter_and_nothing_from_before():
    sections = (section("a", 0.1, 0.2, doubt_n=((9.0,) * 4,)), section("b", 0.2, 0.2, size_n=1.0))
    records = tuple(replace(r, known=np.ones(len(r.u))) for r in SIM.problem.records)
    before = Simulator(replace(SIM.problem, records=records), SIM.mechanics)
    knowing, left = beyond(before, made(), sections, NOISE, told=True)
    own = known(knowing.problem)
    assert knowing.predict(THETA, {}) == pytest.approx(SIM.predict(THETA, {}) + own)
    # all it left, less the map; of its own map there is no doubt
    assert left.residual == pytest.approx(made().residual + 1.0 - own)
    assert all(r.wander.bend.shape[1] == 0 for r in knowing.problem.records)
    # a constant of 0.2 N within a scatter of as much is next to nothing
    assert np.mean(left.whiten(np.full(len(SIM.y), 0.2)) ** 2) < 0.1 * np.mean((0.2 / NOISE_N) ** 2)
    # before it was learned it was only known how large such maps are
    knowing, left = beyond(before, made(), sections, NOISE, told=False)
    assert known(knowing.problem) == pytest.approx(0.0) and left.residual == pytest.approx(made().residual + 1.0)
    prior = knowing.problem.records[1].wander.bend
    assert np.sum(prior**2, axis=1) == pytest.approx(np.ones(len(prior)), abs=0.1)
