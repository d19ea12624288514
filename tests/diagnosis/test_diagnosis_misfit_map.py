"""The map of what a model leaves: hat functions, its weights and its places, against dense linear algebra and by hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from made_fits import NOISE_N, THETA, made, noise, simulator

from sstl_cli.diagnosis import misfit
from sstl_cli.diagnosis.constants import INPUT_KNOTS, OTHER_KNOTS
from sstl_cli.diagnosis.misfit import applied, beyond, known, learned, rescaled, rms_n, turning
from sstl_cli.diagnosis.simulator import Simulator
from sstl_cli.diagnosis.whitening import Noise, Sensor
from sstl_cli.physics.scenario import MisfitSection

SIM = simulator()
QUIET = Sensor(NOISE_N, 1e-4, 0.1)
NOISE = Noise({"act": Sensor(1e-4, 1e-6, 0.1)}, {"act": QUIET}, {"act": 1.0})


def section(config="a", mean=1.0, sd=0.5, **more):
    """Return a map with knots at 0 and 10 N of the input and at 0 N since the turn: ``mean`` while pulling, its double while releasing."""
    values = {"system": "act", "config_id": config, "along": "turning", "correlation_s": 2.0, "input_n": (0.0, 10.0), "other": (0.0,)}
    return MisfitSection(**{**values, "mean_n": (mean, mean, 2 * mean, 2 * mean), "sd_n": (sd,) * 4, **more})


def test_direction_and_way_since_the_turn_by_hand():
    u = np.array([1.0, 0.0, 5.0, 10.0, 9.8, 10.0, 6.0, 2.0, 3.0, 8.0])
    way, last = turning(u)
    # the first step is a turn of its own; 0.2 of 10 is none
    assert way.tolist() == [-1, -1, 1, 1, 1, 1, -1, -1, 1, 1]
    assert last == pytest.approx([0.0, 1.0, 5.0, 10.0, 9.8, 10.0, 4.0, 8.0, 1.0, 6.0])
    assert turning(np.array([0.0, 1.0, 3.0, 2.9]))[0].tolist() == [1, 1, 1, 1]
    # what never moves pulls
    assert turning(np.full(4, 3.0))[0].tolist() == [1, 1, 1, 1]


def test_hats_share_a_place_between_its_knots_and_stay_beyond_the_ends():
    hats = misfit._hats(np.array([-1.0, 0.0, 0.5, 2.0, 9.0]), np.array([0.0, 2.0, 4.0]))
    assert hats.tolist() == [[1, 0, 0], [1, 0, 0], [0.75, 0.25, 0], [0, 1, 0], [0, 0, 1]]
    assert misfit._hats(np.array([3.0, 4.0]), np.array([1.0])).tolist() == [[1.0], [1.0]]
    knots = misfit._knots(np.linspace(0.0, 100.0, 101), 3)
    assert knots == pytest.approx([1.0, 50.0, 99.0]) and misfit._knots(np.full(5, 2.0), 3).tolist() == [2.0]


def test_a_place_of_the_map_is_input_then_the_other_pulling_then_releasing():
    design = misfit._design(np.array([1.0, 2.0]), np.array([0.0, 1.0]), np.array([1.0, -1.0]), np.array([0.0, 2.0]), np.array([0.0, 1.0]))
    assert design.tolist() == [[0.5, 0, 0.5, 0, 0, 0, 0, 0], [0, 0, 0, 0, 0, 0, 0, 1.0]]


def test_weights_are_ridge_regression_and_memory_is_the_lag_of_one_over_e():
    rng = np.random.default_rng(1)
    design, e = rng.standard_normal((30, 4)), rng.standard_normal(30)
    stacked = np.vstack((design, np.sqrt(3.0) * np.eye(4)))
    assert misfit._weights(design, e, 3.0) == pytest.approx(np.linalg.lstsq(stacked, np.concatenate((e, np.zeros(4))), rcond=None)[0])
    # blocks of 10 equal numbers: alike by 1 - lag / 10
    blocks = np.repeat(rng.standard_normal(200), 10)
    records = [replace(r, weight=np.ones(len(r))) for r in SIM.problem.records[:1]]
    assert misfit._memory([blocks], records) == pytest.approx(7.0, abs=1.0)
    assert misfit._memory([np.zeros(2000)], records) == 1.0 and misfit._memory([rng.standard_normal(2000)], records) == 1.0
    # no longer than a quarter of a run
    assert misfit._memory([np.ones(2000)], records) == 500.0


def test_records_know_the_map_of_their_own_bend_and_only_the_size_of_another_s():
    sections = (section("a", 1.0), section("b", 10.0, 0.25))
    found = applied(SIM.problem, sections, 2.0)
    for r, size in zip(found.records, (1.0, 10.0, 1.0, 10.0), strict=True):
        way = turning(r.u)[0]
        assert r.known == pytest.approx(np.where(way > 0, size, 2.0 * size) / 2.0)
        assert r.misfit_n == pytest.approx(np.full(len(r), (0.5 if size == 1.0 else 0.25) / 2.0)) and r.misfit_s == 2.0
    other = applied(SIM.problem, (section("a"), section("z", 3.0, correlation_s=4.0)), 1.0).records[1]
    # 2.5 and 22.5 of the means, 0.25 of the scatter
    assert other.known is None and other.misfit_n == pytest.approx(np.full(2000, np.sqrt(12.5 + 0.25))) and other.misfit_s == 3.0
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
    assert (there.input_n, there.other, there.mean_n, there.sd_n) == ((0.0, 100.0), (30.0,), (10.0, 10.0, 20.0, 20.0), (5.0,) * 4)
    # a place along the stroke is in mm
    assert rescaled(section(along="position", other=(3.0,)), 10.0).other == (3.0,) and there.correlation_s == 2.0


def test_what_comes_again_is_mapped_and_what_does_not_is_scatter():
    rng = np.random.default_rng(2)
    u = np.concatenate([r.u for r in SIM.problem.records])
    way = np.concatenate([turning(r.u)[0] for r in SIM.problem.records])
    pattern = np.where(way > 0, 0.02 * (u - 12.0), -0.1)
    scatter = 0.05 * np.repeat(rng.standard_normal(400), 20)
    phases = SIM.phases(THETA, {}, NOISE)
    sections, left = learned(SIM.problem, noise(3) + pattern + scatter, phases, NOISE)
    assert [s.config_id for s in sections] == ["a", "b"] and {s.along for s in sections} == {"turning"}
    assert {(len(s.input_n), len(s.other)) for s in sections} == {(INPUT_KNOTS, OTHER_KNOTS)}
    # of parts that the map was not made from it leaves noise and scatter, and what its knots do not know
    assert 1.0 < np.sqrt(np.mean(left**2)) / np.hypot(0.05, NOISE_N) < 1.25
    knowing = applied(SIM.problem, sections, 1.0)
    assert np.sqrt(np.mean((known(knowing) - pattern) ** 2)) < 0.3 * np.std(pattern)
    for s in sections:
        assert np.median(s.sd_n) == pytest.approx(0.05, rel=0.35) and 0.1 < s.correlation_s < 1.2


def part(n=400, factor=1):
    """Return a record whose input goes up and down between 0 and 100 N, four times."""
    u = 100.0 * np.abs((np.arange(n * factor) / (n * factor) * 4.0) % 1.0 * 2.0 - 1.0)
    return replace(SIM.problem.records[0], u=u, y=np.zeros(n), weight=np.ones(n), factor=factor, dt_s=0.02 / factor)


def test_a_section_holds_what_comes_again_and_the_places_of_the_scatter():
    r = part()
    u, since, way = misfit.state(r)
    rng = np.random.default_rng(8)
    # an error of 1 N while pulling, known to 0.1 N below 50 N and to 0.4 N above
    sd = np.where(u < 50.0, 0.1, 0.4)
    e = np.where(way > 0, 1.0, 0.0) + sd * rng.standard_normal(400)
    found, left = misfit._section([r], [e], [np.full(400, 0.01)], "b")
    assert (found.system, found.config_id, found.along) == ("act", "b", "turning") and found.correlation_s == pytest.approx(0.02)
    assert found.input_n == pytest.approx(np.linspace(*np.quantile(u, (0.01, 0.99)), INPUT_KNOTS)) and found.other == pytest.approx(
        np.linspace(*np.quantile(since, (0.01, 0.99)), OTHER_KNOTS)
    )
    place = misfit._place(found, r, 1.0)
    assert np.mean(np.abs(place @ np.array(found.mean_n) - np.where(way > 0, 1.0, 0.0))) < 0.15
    beyond = np.array(found.sd_n) @ place.T
    assert np.mean(beyond[u > 60.0]) > 1.5 * np.mean(beyond[u < 40.0])
    # mean squares of what is left, less what was expected; and no place is quieter than a twentieth of that
    usual = np.mean(left**2) - 0.01
    assert min(found.sd_n) >= np.sqrt(0.05 * usual) * (1.0 - 1e-9) and np.sqrt(np.mean(np.square(found.sd_n))) == pytest.approx(
        np.sqrt(usual), rel=0.3
    )
    # a scatter that was expected is none
    quiet, _ = misfit._section([r], [e], [sd**2 + 0.1], "b")
    assert max(quiet.sd_n) == 0.0


def test_every_place_is_judged_by_a_map_that_it_took_no_part_in():
    r = part()
    way = misfit.state(r)[2]
    e = np.where(way > 0, 1.0, -1.0)
    # a part of the run is off the other way: the others say what it should have been
    e[100:130] *= -1.0
    _, left = misfit._section([r], [e], [np.zeros(400)], "b")
    assert np.abs(left[100:130]).mean() > 1.5 and np.abs(left[130:]).mean() < 0.4
    # what has no weight has no part
    weight = np.ones(400)
    weight[100:200] = 0.0
    _, left = misfit._section([replace(r, weight=weight)], [e], [np.zeros(400)], "b")
    assert np.abs(left[weight > 0]).mean() < 0.2


def test_the_state_of_a_record_is_averaged_and_along_the_stroke_where_a_motion_drives_it():
    fine = part(200, 2)
    u, since, way = misfit.state(fine)
    assert u == pytest.approx(fine.u.reshape(-1, 2).mean(axis=1)) and all(
        np.array_equal(a, b) for a, b in zip((way, since), turning(u), strict=True)
    )
    slip = np.repeat([1.0, 0.5, -0.5, -1.0], 100)
    raw = replace(fine.raw, position_in_mm=np.arange(2000.0))
    u, place, way = misfit.state(replace(fine, slip=slip, raw=raw))
    assert place[:2] == pytest.approx([0.5, 2.5]) and way.tolist() == [1.0] * 100 + [-1.0] * 100


def test_noise_alone_has_no_map_and_too_few_samples_have_none():
    phases = SIM.phases(THETA, {}, NOISE)
    sections, left = learned(SIM.problem, 0.5 * noise(4), phases, NOISE)
    assert sections == () or all(np.abs(s.mean_n).max() < 0.01 for s in sections)
    few = replace(SIM.problem, records=tuple(replace(r, weight=np.where(np.arange(len(r)) < 20, 1.0, 0.0)) for r in SIM.problem.records))
    residual = noise(5)
    none, left = learned(few, residual, phases, NOISE)
    assert none == () and np.array_equal(left, residual)


def test_a_simulator_beyond_what_it_leaves_has_the_map_and_the_scatter_and_nothing_from_before():
    sections = (section("a", 0.1, 0.2), section("b", 0.2, 0.2))
    records = tuple(replace(r, known=np.ones(len(r.u))) for r in SIM.problem.records)
    before = Simulator(replace(SIM.problem, records=records), SIM.mechanics)
    knowing, whiten = beyond(before, made(), sections, NOISE)
    own = np.concatenate([r.known for r in knowing.problem.records])
    assert knowing.predict(THETA, {}) == pytest.approx(SIM.predict(THETA, {}) + own)
    # a constant of 0.2 N within a scatter of as much is next to nothing
    assert np.mean(whiten(np.full(len(SIM.y), 0.2)) ** 2) < 0.1 * np.mean((0.2 / NOISE_N) ** 2)
