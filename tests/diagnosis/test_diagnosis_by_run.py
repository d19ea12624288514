"""Friction that differs from run to run: its likelihood by dense algebra, what it is named beside, and what is kept of it."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from made_fits import NOISE_N, THETA, made, named, noise, simulator
from rig_logs import scenario
from scipy.stats import chi2, multivariate_normal
from scipy.stats import f as f_ratio

from sstl_cli.diagnosis import by_run
from sstl_cli.diagnosis.evidence import Weighed
from sstl_cli.diagnosis.fit import fit, settle
from sstl_cli.diagnosis.found import Search
from sstl_cli.diagnosis.heldout import HeldOut
from sstl_cli.diagnosis.hypotheses import full
from sstl_cli.diagnosis.shrink import parameter_intervals
from sstl_cli.diagnosis.whitening import Noise, Sensor, white
from sstl_cli.steps import simulate
from sstl_cli.steps.diagnose import DiagnoseOptions, run

SIM = simulator()
QUIET = Sensor(NOISE_N, 0.0, 0.1)
NOISE = Noise({"act": QUIET}, {"act": QUIET}, {"act": 1.0})
OWN = np.array([0.04, -0.03, -0.05, 0.02])
FEW = ("friction_drift", "pulley_friction", "gain_error", "zero_offset", "asymmetric_friction")


def search(base, *singles, sim=SIM):
    return Search(sim, NOISE, NOISE, base, {w.ids[0]: (w,) for w in singles}, {})


def scattered(own=OWN, seed=3):
    """A simulator of outputs that have friction of their own in each run, and its base."""
    places = np.array([r.config for r in SIM.problem.records])
    y = by_run.each_alone(SIM).predict(THETA[places] * (1.0 + own), {}) + noise(seed)
    return read_as(y)


def read_as(y):
    """A simulator whose outputs read so, and its base."""
    read = tuple(replace(r, y=y[at]) for r, at in zip(SIM.problem.records, SIM.slices(), strict=True))
    sim = replace(SIM, problem=replace(SIM.problem, records=read))
    start = fit(sim, made().whiten, made().hypothesis, THETA, np.zeros(0))
    return sim, settle(sim, NOISE, start)


@pytest.mark.parametrize("kind", [by_run.OUTPUT, by_run.INPUT])
def test_zeros_that_differ_are_told_by_the_sensor(kind):
    zeros = np.array([0.1, -0.2, 0.15, 0.05])
    if kind is by_run.OUTPUT:
        y = SIM.predict(THETA, {}) + zeros[SIM.run]
    else:
        # an input that reads so much more than what drives the line
        less = tuple(replace(r, u=r.u - z) for r, z in zip(SIM.problem.records, zeros, strict=True))
        y = replace(SIM, problem=replace(SIM.problem, records=less)).predict(THETA, {})
    sim, base = read_as(y + noise(4))
    rest = Weighed(made(noise(4), named("zero_drift", "r_out_act_n", "warming"), (0.0, 0.0)), 0.0, -3.0)
    found = search(base, drift(), rest, sim=sim)
    by_run.add(found, 2)
    best = found.ranked()[0]
    assert best.ids == ("zero_drift",) and by_run.kind_of(best.fit) is kind
    _, parts = by_run.shown(sim, best.fit)
    assert np.array(list(parts.values())) == pytest.approx(zeros, abs=0.02)


def drift():
    h = named("friction_drift", "d_mu", "path_n", "load_mm_per_n")
    return Weighed(made(noise(3), h, (0.0, 200.0, 0.1)), 0.0, -3.0)


@pytest.mark.parametrize("both", [0.0, 0.8])
def test_gain_is_that_of_the_dense_covariance(both):
    rng = np.random.default_rng(1)
    place, n = np.repeat([0, 0, 0, 1, 1], 20), np.repeat(np.arange(5), 20)
    theta = rng.normal(0.0, 3.0, 100)
    own = both * theta + rng.normal(0.0, 2.0, 100)
    z = own * rng.normal(0.0, 0.3, 5)[n] + rng.standard_normal(100)
    sums = [np.bincount(n, x) for x in (own * own, theta * theta, own * theta, own * z, theta * z)]
    told = by_run.Told(*sums, np.array([0, 0, 0, 1, 1]), np.zeros(5, int))
    columns = theta[:, None] * np.eye(2)[place]
    for spread in (0.02, 0.3):
        gain, part, shift = by_run.gain_of(spread, told)
        each = own[:, None] * np.eye(5)[n]
        cov = np.eye(100) + spread**2 * each @ each.T
        weight = np.linalg.inv(cov)
        mean = np.linalg.solve(columns.T @ weight @ columns, columns.T @ weight @ z)
        assert shift == pytest.approx(mean)
        assert part == pytest.approx(spread**2 * each.T @ weight @ (z - columns @ mean))
        plain = multivariate_normal(np.zeros(100), np.eye(100)).logpdf(z)
        # theta integrated out, over what the base knows of it
        less = 0.5 * (np.linalg.slogdet(columns.T @ columns)[1] - np.linalg.slogdet(columns.T @ weight @ columns)[1])
        assert gain == pytest.approx(multivariate_normal(columns @ mean, cov).logpdf(z) - plain + less)


def test_a_spread_is_as_large_as_it_was_drawn_however_few_runs_a_bend_has():
    """Two runs a bend: with theta at its best instead of integrated out it came out at 0.7 of its size."""
    rng = np.random.default_rng(3)
    place, found = np.repeat(np.arange(3), 2), []
    grid = np.geomspace(0.01, 1.0, 60)
    ones = np.full(6, 400.0)
    for _ in range(400):
        z = 0.1 * rng.standard_normal(6) * ones + np.sqrt(ones) * rng.standard_normal(6)
        told = by_run.Told(ones, ones, ones, z, z, place, np.zeros(6, int))
        found.append(max(grid, key=lambda s: by_run.gain_of(float(s), told)[0]))
    assert np.sqrt(np.mean(np.square(found))) == pytest.approx(0.1, rel=0.1)


def test_what_one_system_has_in_all_its_runs_of_a_bend_is_no_scatter():
    rng = np.random.default_rng(2)
    # two runs of each system in each of three bends
    place, system = np.repeat([0, 1, 2], 4), np.tile([0, 0, 1, 1], 3)
    n = np.repeat(np.arange(12), 30)
    theta = rng.normal(0.0, 3.0, 360)
    own = 0.7 * theta + rng.normal(0.0, 1.0, 360)

    def told(parts):
        z = own * parts[n] + 0.1 * rng.standard_normal(360)
        sums = [np.bincount(n, x) for x in (own * own, theta * theta, own * theta, own * z, theta * z)]
        return by_run.Told(*sums, place, system), z

    alike, z = told(np.where(system == 1, 0.5, -0.5))
    bends = theta[:, None] * np.eye(3)[place[n]]
    without, beside = (
        0.5 * float(np.sum((z - x @ np.linalg.lstsq(x, z, rcond=None)[0]) ** 2))
        for x in (bends, np.column_stack((bends, own[:, None] * np.eye(6)[(2 * place + system)[n]])))
    )
    assert by_run.systematic(alike) == pytest.approx(without - beside)
    assert by_run.gain_of(0.5, alike)[0] < 1.05 * by_run.systematic(alike)
    # what the systems have against one another in each bend is no more by chance
    by_bend, _ = told(np.where(system == 1, 0.5, -0.5) * np.array([1.0, -1.0, 0.4])[place])
    assert by_run.gain_of(0.5, by_bend)[0] < 1.05 * by_run.systematic(by_bend)
    # as many runs that differ by as much, but not as their systems do
    mixed, _ = told(0.5 * np.tile([1.0, -1.0], 6))
    assert by_run.systematic(mixed) < 0.2 * by_run.gain_of(0.5, mixed)[0]


F = float(f_ratio.ppf(48.0 / 49.0, 3, 6))


@pytest.mark.parametrize(
    ("gain", "common", "left"),
    [
        # 6 contrasts within and 3 between systems: of 10 within chance gives 5 between, and 7.2 times that once in 49
        (100.0, 90.0, 100.0 - (90.0 - 5.0 * F)),
        (100.0, 70.0, 100.0),
        (100.0, 100.0, 0.0),
        (100.0, 130.0, -30.0),
    ],
)
def test_what_systems_have_in_common_counts_as_far_as_chance_gives_it(gain, common, left):
    runs = [SimpleNamespace(config=c, system=s) for c in range(3) for s in ("act", "sstl") for _ in range(2)]
    sim = SimpleNamespace(problem=SimpleNamespace(records=runs))
    assert by_run.by_chance(sim, gain, common) == pytest.approx(left)


def test_what_runs_have_of_their_own_is_found_to_size_and_taken_off():
    sim, base = scattered()
    found = search(base, drift(), sim=sim)
    by_run.add(found, 1)
    w = found.best(("friction_drift",))
    # of four runs in two bends the base's theta shares the mean of each bend
    apart = OWN - np.array([OWN[[0, 2]].mean(), OWN[[1, 3]].mean()])[[0, 1, 0, 1]]
    kind, own = by_run.shown(sim, w.fit)
    assert kind is by_run.FRICTION and list(own) == ["run0", "run1", "run2", "run3"]
    assert np.array(list(own.values())) == pytest.approx(apart, abs=0.003)
    assert w.fit.values[-1] == pytest.approx(np.sqrt(np.sum(apart**2) / 2.0), rel=0.4)
    assert w.gain > 100.0 and 0.0 < w.gain - w.evidence < 10.0
    assert np.std(w.fit.residual) == pytest.approx(NOISE_N, rel=0.02)
    # nobody can foretell it: what is held out is fitted as well, and what lasts is the base
    assert HeldOut(sim).residual(w.fit) is w.fit.residual and by_run.lasting(found, w.fit) is base
    (found_interval,) = parameter_intervals(sim, w.fit)
    spread = found_interval.estimate
    assert (found_interval.low, found_interval.high) == pytest.approx(
        tuple(spread * np.sqrt(2.0 / chi2.ppf(q, 2)) for q in (0.975, 0.025)), rel=1e-3
    )


def test_a_line_slides_and_holds_by_the_friction_of_its_run(monkeypatch):
    """To first order, friction that is off by a sixth leaves several times the noise where a line breaks away."""
    sim, base = scattered(3.0 * OWN)
    found = search(base, drift(), sim=sim)
    by_run.add(found, 1)
    w = found.best(("friction_drift",))
    assert np.std(w.fit.residual) == pytest.approx(NOISE_N, rel=0.03)
    monkeypatch.setattr(by_run, "EACH_ROUNDS", 1)
    first = search(base, drift(), sim=sim)
    by_run.add(first, 1)
    assert first.best(("friction_drift",)).fit.cost > w.fit.cost + 100.0
    assert w.fit.cost == pytest.approx(base.cost - w.gain)


def test_runs_that_are_alike_gain_nothing_by_it():
    for seed in range(4):
        found = search(made(noise(seed)), drift())
        by_run.add(found, 1)
        assert all(w.evidence < 1.0 for w in found.singles["friction_drift"])


def test_one_contrast_is_no_spread_and_nothing_is_added_where_it_is_not_asked():
    found = search(scattered()[1])
    by_run.add(found, 2)
    assert not found.singles and not found.combined
    few = replace(SIM, problem=replace(SIM.problem, records=SIM.problem.records[:3]))
    assert by_run.contrasts(few) == 1
    assert by_run.add(replace(found, sim=few), 1) is None and not found.singles


def test_a_zero_in_bends_recorded_once_may_be_one_of_the_bend_and_is_never_likelier():
    """A zero that warmed up over a session of one run a bend was a zero that grows with the bend, for sure."""
    two = replace(SIM, problem=replace(SIM.problem, records=SIM.problem.records[:2]))
    y = two.predict(THETA, {}) + np.array([0.2, -0.1])[two.run] + noise(6)[: len(two.y)]
    sim = replace(
        two, problem=replace(two.problem, records=tuple(replace(r, y=y[s]) for r, s in zip(two.problem.records, two.slices(), strict=True)))
    )
    whiten = white(NOISE_N, sim.weight, [s.start for s in sim.slices()])
    base = settle(sim, NOISE, fit(sim, whiten, made().hypothesis, THETA, np.zeros(0)))
    asked = {"zero_drift": (), "zero_offset": (Weighed(base, 50.0, 40.0),)}
    found = Search(sim, NOISE, NOISE, base, asked, {})
    by_run.add(found, 2)
    best = found.singles["zero_drift"][0]
    assert best.gain > 1000.0 and by_run.kind_of(best.fit) is by_run.OUTPUT
    # by half of what decides, so that neither is named without the other
    assert best.evidence == pytest.approx(40.0 - 0.5 * np.log(49.0))


def test_where_no_run_slides_nothing_is_said_of_its_friction():
    held = made(noise(2))
    found = search(replace(held, jacobian=np.zeros_like(held.jacobian)), drift())
    by_run.add(found, 2)
    assert [w.evidence for w in found.singles["friction_drift"]] == [-3.0]


def test_what_lasts_beside_what_runs_have_of_their_own_is_the_rest_of_the_model():
    gain = Weighed(made(noise(5), named("gain_error", "g_act"), (1.02,)), 9.0, 5.0)
    other = Weighed(made(noise(5), full("zero_offset", ("act",)), (0.1, 0.2)), 9.0, 5.0)
    found = search(made(noise(5)), other, gain)
    for kind in (by_run.FRICTION, by_run.INPUT):
        both = gain.fit.hypothesis.joined(by_run.scatter(kind))
        fit_of_both = replace(gain.fit, hypothesis=both, values=np.array([1.02, 0.1]))
        assert by_run.kind_of(fit_of_both) is kind and by_run.lasting(found, fit_of_both) is gain.fit
        alone = replace(gain.fit, hypothesis=by_run.scatter(kind), values=np.array([0.1]))
        assert by_run.lasting(found, alone) is found.base
    # a part that was not found alone leaves the base
    assert by_run.lasting(search(found.base, other), fit_of_both) is found.base
    assert by_run.kind_of(gain.fit) is None and by_run.lasting(found, gain.fit) is gain.fit and by_run.shown(SIM, gain.fit) is None


def test_a_spread_of_few_contrasts_has_the_interval_of_chi_square():
    records = [SimpleNamespace(config=c, system="act") for c in (0, 0, 0, 1, 1)]
    sim = SimpleNamespace(problem=SimpleNamespace(records=records))
    # five runs in two bends: three differences
    assert by_run.contrasts(sim) == 3
    low, high = by_run.interval(sim, 0.1)
    assert low == pytest.approx(0.1 * np.sqrt(3.0 / chi2.ppf(0.975, 3)), rel=1e-3)
    assert high == pytest.approx(0.1 * np.sqrt(3.0 / chi2.ppf(0.025, 3)), rel=1e-3)


def test_what_a_unit_of_a_run_s_own_does_is_a_share_of_theta_or_a_shift_of_a_sensor():
    base = made()
    theta = THETA[SIM.config]
    assert by_run.column(SIM, base, by_run.FRICTION) == pytest.approx(base.jacobian[:, 0] * theta)
    assert by_run.column(SIM, base, by_run.OUTPUT).tolist() == [1.0] * len(SIM.y)
    # the input is read too high: what the line was really given is less
    read = by_run.column(SIM, base, by_run.INPUT)
    gain = SIM.by_input(base.theta, {})
    assert read == pytest.approx(-gain) and set(np.sign(read)) <= {-1.0, 0.0}


def differing(effects, spread, seed=0, moves=3):
    """A rig recording of each movement in each bend, with friction of its own in every run."""
    rng, asked = np.random.default_rng(seed), scenario(hz=100.0)
    runs = []
    for c in asked.configurations:
        for move in asked.trajectories[:moves]:
            for system in ("act", "sstl"):
                own = c.model_copy(update={"theta": c.theta * (1.0 + spread * rng.standard_normal())})
                alone = asked.model_copy(
                    update={"configurations": (own,), "trajectories": (move.model_copy(update={"systems": (system,)}),)}
                )
                runs += simulate.run(alone, effects, int(rng.integers(1 << 30)))
    return runs


def diagnosed(runs):
    return run(runs, DiagnoseOptions(effects=FEW, max_effects=2, workers=2))


@pytest.mark.slow
def test_a_rig_whose_friction_differs_from_run_to_run_has_no_pulley():
    found = diagnosed(differing({}, 0.03))
    document = found.document()
    assert document["verdict"]["status"] == "identified" and document["verdict"]["effects"] == ["friction_drift"], document["verdict"]
    (parameter,) = document["candidates"][0]["parameters"]
    assert parameter["name"] == "d_run" and parameter["ci95"][0] < 0.03 < parameter["ci95"][1]
    gap = document["gap"]
    assert gap["explained_of_reducible_pct"] > 90.0 and not gap["held_out"] and "downstream" not in document
    assert any("friction of each run is fitted to it" in note for note in document["notes"])
    # the rig as it is kept does not hold what one run had: it is known to vary
    kept = found.model()
    assert "friction_drift" not in kept.effects
    again = run(differing({}, 0.03, seed=5), DiagnoseOptions(sim=kept, effects=FEW, max_effects=1, workers=2)).document()
    assert again["verdict"]["status"] == "none", again["verdict"]


@pytest.mark.slow
def test_a_pulley_beside_friction_that_differs_is_told_with_it():
    document = diagnosed(differing({"pulley_friction": {"m_p": 0.08, "m_r": 0.08}}, 0.01)).document()
    assert document["verdict"]["status"] in ("identified", "ambiguous")
    assert "pulley_friction" in document["verdict"]["effects"], document["verdict"]
    alone = diagnosed(differing({"pulley_friction": {"m_p": 0.08, "m_r": 0.08}}, 0.0)).document()
    assert alone["verdict"]["effects"] == ["pulley_friction"], alone["verdict"]
