"""What follows from the verdict, on a small made log whose output's sensor is 0.2 N off, and by hand."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from sstl_cli.core.runs import Run
from sstl_cli.diagnosis import compared, floor, gap, judged, left_out, movements, neighbours, own_record, planning, recorded, simple, worth
from sstl_cli.diagnosis.accepted import accepted, kept, known, model
from sstl_cli.diagnosis.constants import COVERED, FASTEST_HZ
from sstl_cli.diagnosis.gathering import gather
from sstl_cli.diagnosis.question import Question
from sstl_cli.diagnosis.verdict import IDENTIFIED, verdict
from sstl_cli.diagnosis.where import PHASES
from sstl_cli.physics.scenario import Scenario

THETA, ZERO_N, NOISE_N = (0.4, 0.6), 0.2, 0.01
ASKED = Question(effects=("zero_offset", "const_friction"), max_effects=1)


def made(config: int) -> Run:
    rng = np.random.default_rng(config)
    t = np.arange(0.0, 40.0, 0.02)
    u = np.interp(t, np.arange(0.0, 45.0, 4.0), rng.uniform(3.0, 25.0, 12))
    y, last = np.empty_like(u), np.exp(-THETA[config]) * u[0]
    for k, v in enumerate(u):
        last = y[k] = max(np.exp(-THETA[config]) * v, min(last, np.exp(THETA[config]) * v))
    seen = (x + NOISE_N * rng.standard_normal(len(t)) for x in (u, y + ZERO_N))
    return Run(f"r{config}", "act", t, *seen, config_id=f"C{config}", trajectory="ramps")


@pytest.fixture(scope="module")
def case():
    found = gather([made(0), made(1)], ASKED)
    said = verdict(found.rows, ASKED.weights)
    return found, said, judged.Judged(**vars(found), verdict=said, accepted=accepted(found, said))


def test_the_accepted_model_is_that_of_the_named_effect_in_the_units_of_the_record(case):
    found, said, g = case
    assert (said.status, said.effects) == (IDENTIFIED, ("zero_offset",))
    assert g.accepted is kept(found, said) is found.search.singles["zero_offset"][0].fit
    scenario = model(found, said, Scenario())
    assert scenario.effects["zero_offset"]["z_out_act_n"] == pytest.approx(ZERO_N, abs=0.01)
    assert [c.theta for c in scenario.configurations] == pytest.approx(THETA, abs=0.003)
    assert scenario.noise.white_n == pytest.approx(NOISE_N, rel=0.1)
    # nothing named: the base, without the effect
    nothing = replace(said, status="none", effects=())
    assert accepted(found, nothing) is found.search.base and not model(found, nothing, Scenario()).effects


def test_an_accepted_simulator_knows_what_its_own_record_shows_and_one_that_varies_by_nothing_is_left(case):
    found, said, _ = case
    scenario = known(found, said, Scenario())
    assert own_record.tried(found, scenario.model_copy(update={"wander": None}), ASKED).dispersion == scenario.dispersion
    tried = own_record.tried(found, scenario, ASKED)
    assert all(tried.dispersion[k] >= v for k, v in scenario.dispersion.items()) and tried.effects == scenario.effects


def test_the_gap_falls_from_the_zero_to_the_noise(case):
    _, _, g = case
    errors = gap.errors(g)
    found = gap.sizes(g, errors, np.zeros(len(g.search.sim.y), np.int64))
    # what a theta of its own takes of a zero is little
    assert 0.5 * ZERO_N < found.retuned_n < ZERO_N and found.with_effect_n < 1.3 * found.floor.value_n
    assert found.fall_pct == pytest.approx(100.0 * (1.0 - found.with_effect_n / found.retuned_n))
    assert found.interval.low < found.fall_pct < found.interval.high and 95.0 < found.explained_pct <= 100.0 and found.worse == []
    below = floor.floor(g, errors.fine_n)
    assert below == found.floor and 0.5 * NOISE_N < below.low_n < below.value_n < below.high_n < 2.0 * NOISE_N


def test_an_rms_is_over_what_counts_and_holds_the_noise_above_the_rate_of_the_analysis():
    nothing = np.zeros(3)
    errors = gap.Errors(nothing, nothing, 4.0, np.array([1.0, 0.0, 1.0]), nothing)
    assert errors.rms(np.array([3.0, 99.0, -3.0])) == 5.0


def test_candidates_are_listed_with_their_errors_and_their_distance_from_the_likeliest(case):
    _, said, g = case
    rows = {c.model.ids[0]: c for c in compared.compared(g, gap.errors(g))}
    assert set(rows) == {"zero_offset", "const_friction"}
    best, other = rows["zero_offset"], rows["const_friction"]
    assert best.d2 is None and other.d2 > 100.0 and best.best == "identifiable" and best.change is None
    assert best.probability == said.probabilities[("zero_offset",)] and best.rmse_n < other.rmse_n and best.fall_pct > other.fall_pct
    at = [x.parameter.name for x in best.model.fit.free].index("z_out_act_n")
    low, high = best.intervals[at]
    assert low < best.model.fit.values[at] < high < low + 0.1


def test_what_only_the_channels_beside_show_is_told_once():
    gaps = [SimpleNamespace(effect=e, at=i) for i, e in enumerate(["loop", "spring", "loop"])]
    assert [x.at for x in compared.only_beside(gaps, {"spring"})] == [0]


def test_the_effect_without_which_the_prediction_moves_most_is_first():
    sim = SimpleNamespace(predict=lambda theta, effects: np.full(2, sum(effects.values())))
    fit = SimpleNamespace(effects={"a": 1.0, "b": 3.0}, theta=None, prediction=np.full(2, 4.0))
    g = SimpleNamespace(verdict=SimpleNamespace(status=IDENTIFIED, effects=("a", "b")), accepted=fit, search=SimpleNamespace(sim=sim))
    assert judged.by_size(g) == ["b", "a"]
    g.verdict.status = "unknown"
    assert judged.by_size(g) == ["a", "b"]


def test_simpler_rules_take_the_smallest_error_and_charge_for_numbers():
    def single(name, left, free):
        return (SimpleNamespace(ids=(name,), fit=SimpleNamespace(residual=np.full(100, left), free=[None] * free)),)

    base = SimpleNamespace(residual=np.full(100, 1.0))
    found = SimpleNamespace(
        sim=SimpleNamespace(weight=np.ones(100)), base=base, singles={"a": single("a", 0.5, 1), "b": single("b", 0.499, 3)}
    )
    errors = gap.Errors(base.residual, base.residual, 0.0, np.ones(100), np.zeros(100))
    assert simple.answers(found, errors) == simple.Answers("b", "a")
    # a hundredth of the error is not worth a number: 100 ln(0.99^2) = -2.01, and ln(100) = 4.6
    assert simple.answers(replace_singles(found, {"a": single("a", 0.99, 1)}), errors) == simple.Answers("a", None)
    assert simple.answers(replace_singles(found, {}), errors) == simple.Answers(None, None)


def replace_singles(found, singles):
    return SimpleNamespace(**{**vars(found), "singles": singles})


def test_errors_over_raw_readings_are_those_of_the_model_where_no_fault_is(case):
    found, _, _ = case
    sim, theta = found.search.sim, found.search.base.theta
    before, after, given = recorded.rms_n(sim, theta, theta + 0.1, SimpleNamespace(removed_n2=0.0))
    left = np.concatenate(
        [r.raw.tension_out_n[: len(y)] - y for r, y in zip(sim.problem.records, sim.predict_fine(theta, {}), strict=True)]
    )
    assert before == after == pytest.approx(np.sqrt(np.mean(left**2)), rel=0.01) and given > before
    half = before**2 * len(left) / 2.0
    assert recorded.rms_n(sim, theta, theta, SimpleNamespace(removed_n2=half))[1] == pytest.approx(before / np.sqrt(2.0), rel=0.01)
    rows = recorded.shares(sim, theta, np.arange(len(sim.y)) % len(PHASES))
    assert sum(r.share_pct for r in rows) == pytest.approx(100.0) and len(rows) == 2 * len(PHASES)
    assert [r.share_pct for r in rows] == sorted((r.share_pct for r in rows), reverse=True)


def test_an_effect_of_the_output_is_worth_something_to_a_controller_at_the_middle_bend(case):
    found, said, g = case
    assert worth.can_be_asked(found, g.accepted) and not worth.can_be_asked(found, found.search.base)
    scenario = model(found, said, Scenario())
    name, tracked = worth.of_the_middle(found, g.accepted, scenario, Scenario())
    assert name in ("C0", "C1") and tracked
    before = worth._before(found, scenario, Scenario())
    assert not before.effects and [c.theta for c in before.configurations] == pytest.approx(found.search.base.theta.tolist())


def test_movements_stay_within_the_tensions_of_the_record_and_a_scenario_s_own_are_kept(case):
    found, _, _ = case
    moved = movements.with_movements(Scenario(trajectories=()), found.problem)
    u = np.concatenate([r.raw.tension_in_n for r in found.problem.records])
    assert moved.trajectories and all(u.min() - 0.1 < t.low_n < t.high_n < u.max() + 0.1 for t in moved.trajectories)
    assert {t.systems for t in moved.trajectories} == {("act",)} and moved.sampling_hz == min(50.0, FASTEST_HZ)
    assert movements.with_movements(moved, found.problem) is moved


def test_of_two_runs_none_is_left_out_and_none_where_the_time_is_over(case, monkeypatch):
    found, said, _ = case
    assert left_out.differing(found, said, ASKED, None, lambda _: False) is None
    monkeypatch.setattr(left_out, "FEWEST_RUNS", 2)
    assert left_out.differing(found, said, ASKED, None, lambda stage: stage == left_out.STAGE) is None
    # either run alone shows the same zero
    assert left_out.differing(found, said, ASKED, None, lambda _: False) == []


def test_neighbours_pull_with_their_sum_where_each_is_known_once():
    t = np.linspace(0.0, 10.0, 11)

    def run(tendon, tension, time=t, config="A"):
        return Run(
            f"{tendon}{tension}{len(time)}", "act", time, np.full(len(time), tension), np.zeros(len(time)), config_id=config, tendon=tendon
        )

    own, left, right = run("a", 1.0), run("b", 2.0), run("c", 4.0)
    found = neighbours.with_neighbours(own, [own, left, right])
    assert found.extra[neighbours.NEIGHBOUR].tolist() == [6.0] * 11
    # a neighbour with two such runs, another bend, or one that ends too early says nothing
    for beside in ([left, run("b", 3.0)], [run("b", 2.0, config="B")], [run("b", 2.0, t[: int(10 * COVERED)])]):
        assert neighbours.with_neighbours(own, [own, *beside]) is own


def test_a_plan_tells_apart_what_has_a_size_of_its_own():
    def row(effect, rival, told):
        return planning.Planned(effect, "p", "N", 0.1, 0.1, True, rival, told, 30.0)

    assert planning.classes([row("a", "b", None), row("c", "d", 0.3)]) == [["a", "b"]]
    assert planning.classes([replace(row("a", "b", None), shows=False)]) == []
