"""Distances from the truth: rebuilt recordings, every kind of effect, and error rates that simulation must reproduce."""

import sys
from math import sqrt
from pathlib import Path

import numpy as np
import pytest
from made_truths import made_truth
from scipy.stats import norm
from soon import asked

from sstl_cli.blind import distance, sides
from sstl_cli.blind.cases import rebuild
from sstl_cli.blind.judge import Judged, wilson
from sstl_cli.blind.schedule import Entry, Job
from sstl_cli.blind.truth import CaseTruth
from sstl_cli.core.documents.blind import CaseDistance
from sstl_cli.core.errors import SstlError
from sstl_cli.core.observer import ODDS, ideal
from sstl_cli.diagnosis.constants import DECIDABLE, DECIDES_NATS
from sstl_cli.physics.effects import get
from sstl_cli.reporting.figures import distance as figure
from sstl_cli.steps import blind_limit
from sstl_cli.steps.blind_make import draw_job

sys.path.insert(0, str(Path(__file__).parents[2] / "tools"))
import limit_simulation


def drawn(kind, effects, strength, seed=12, simulator="rig", as_labs=False):
    return draw_job(Job(Entry(kind, effects, strength), seed, simulator, True, as_labs))


def limit(case):
    return blind_limit.run("c", case.truth, case.sim, case.exclude).plain()


@pytest.mark.parametrize(
    ("kind", "effects", "simulator", "as_labs"),
    [
        ("single", ("slack",), "rig", False), ("unlisted", ("disturbance",), "bristle", False),
        pytest.param("pair", ("gain_error", "viscous"), "variant", True, marks=pytest.mark.slow), ("poor", ("const_friction",), "rig", False),
        ("single", ("acquisition_faults",), "rig", True),
    ],
)  # fmt: skip
def test_the_truth_makes_the_same_recordings_again(kind, effects, simulator, as_labs):
    case = drawn(kind, effects, 1.2, 5, simulator, as_labs)
    source, withheld = rebuild(case.truth)
    again = source.record(source.bench.runs, withheld)
    assert len(again) == len(case.runs)
    for a, b in zip(again, case.runs, strict=True):
        assert np.array_equal(a.tension_out_n, b.tension_out_n) and np.array_equal(a.time_s, b.time_s)


def test_a_truth_that_does_not_say_how_it_was_drawn_has_no_distance():
    case = drawn("none", (), 0.0)
    old = CaseTruth.of({k: v for k, v in case.truth.document().items() if k != "attempt"})
    with pytest.raises(SstlError, match="before distances"):
        rebuild(old)


@pytest.mark.slow
def test_nothing_withheld_has_a_law_and_no_distance():
    found = limit(drawn("none", (), 0.0))
    assert found["d2_base"] is None and found["decidable"] is False and 0.0 <= found["d2_law"] < 24.0


@pytest.mark.parametrize(
    "effects",
    [
        ("tension_loop_lag",),
        *(pytest.param((e,), marks=pytest.mark.slow) for e in ("friction_drift", "quantisation", "tendon_elasticity", "presliding")),
    ],
)
def test_every_kind_of_effect_has_a_distance_that_grows_with_it(effects):
    far, near = (limit(drawn("single", effects, s)) for s in (4.0, 0.2))
    assert far["d2_base"] > 100.0 and far["d2_base"] > 3.0 * near["d2_base"]
    if effects != ("tension_loop_lag",):
        assert far["rival"] is not None and far["rival"] not in effects


@pytest.mark.slow
def test_look_alikes_are_always_among_the_rivals():
    case = drawn("single", ("channel_lowpass",), 1.2)
    session = distance.truth_of(*rebuild(case.truth), case.sim)
    found = distance.apart(session)
    assert set(get("channel_lowpass").look_alikes) <= set(found.rivals)
    assert found.rival == min(found.rivals, key=found.rivals.get)


@pytest.mark.slow
def test_a_pair_is_held_against_each_of_its_parts():
    found = limit(drawn("pair", ("gain_error", "friction_drift"), 4.0))
    names = set(found["rivals"])
    assert any(n.startswith("without") or " for " in n for n in names)


@pytest.mark.slow
def test_an_excluded_truth_is_told_from_the_others_alone():
    case = drawn("excluded", ("gain_error",), 4.0)
    found = limit(case)
    assert found["d2_own"] is None and "gain_error" not in found["rivals"]
    # what a candidate comes near another one beside it comes nearer, and neither is the excluded one
    assert found["d2_joined"] <= found["d2_rival"] and "gain_error" not in found["joined"].split("+")
    assert 2 <= len(found["joined"].split("+")) <= 3


def test_a_cause_that_a_pair_of_candidates_shows_as_well_counts_apart():
    def judged(case, status):
        return Judged(case, made_truth(["viscous"], kind="outside", excluded=True), status, (), (), 0.9, 1.0, {}, None, None)

    def row(case, joined):
        none = dict.fromkeys(("channel", "rival", "d2_base_known", "d2_rival_known", "d2_law", "d2_own", "why"))
        return CaseDistance(
            case=case,
            effects=["viscous"],
            d2_base=90.0,
            d2_rival=30.0,
            rivals={},
            decidable=True,
            decidable_known=True,
            d2_joined=joined,
            **none,
        )

    cases = [judged("a", "unknown"), judged("b", "ambiguous"), judged("c", "ambiguous")]
    found = sides.compared(cases, {r.case: r for r in (row("a", 40.0), row("b", 3.0), row("c", None))}).against_limit
    assert (found.unknown_recall.k, found.unknown_recall.n) == (1, 3)
    assert (found.unknown_recall_joined.k, found.unknown_recall_joined.n) == (1, 2)


def test_strata_and_the_ideal_observer():
    # D^2 / 2 - 1.645 D = ln 49 where an ideal observer reaches 95 %
    d = 1.645 + sqrt(1.645**2 + 2.0 * np.log(49.0))
    assert ideal(d * d) == pytest.approx(0.95, abs=1e-3) and ideal(0.0) == 0.0
    assert ideal(9.0) == pytest.approx(norm.cdf((4.5 - np.log(49.0)) / 3.0))

    def judged(case, status):
        return Judged(case, made_truth(["viscous"]), status, ("viscous",), ("viscous",), 0.9, 1.0, {}, None, None)

    found = sides.by_d2([judged("a", "identified"), judged("b", "ambiguous"), judged("c", "identified")], {"a": 30.0, "b": 50.0, "c": 3.0})
    strata = {r.d2_low: r.plain() for r in found}
    assert (strata[24.0]["isolation"]["k"], strata[24.0]["isolation"]["n"], strata[24.0]["in_group"]["k"]) == (1, 2, 2)
    assert strata[24.0]["ideal"] == pytest.approx((ideal(30.0) + ideal(50.0)) / 2)
    assert strata[24.0]["d2_median"] == 40.0 and strata[1600.0]["d2_median"] is None
    assert strata[0.0]["cases"] == 1 and strata[1600.0]["ideal"] is None


def test_a_set_counts_what_could_be_told():
    rows = [
        {"case": "a", "d2_base": 90.0, "d2_rival": 30.0, "decidable": True, "decidable_known": True},
        {"case": "b", "d2_base": 90.0, "d2_rival": 1.0, "decidable": False, "decidable_known": True},
        {"case": "c", "d2_base": None, "d2_rival": None, "decidable": False, "decidable_known": False},
    ]
    rest = dict.fromkeys(("channel", "rival", "d2_base_known", "d2_rival_known", "d2_law", "d2_own", "why")) | {"effects": [], "rivals": {}}
    found = blind_limit.document([CaseDistance(**rest, **row) for row in rows], "0" * 64)
    assert (found.cases, found.judged, found.decidable, found.decidable_known) == (3, 2, 1, 2)


@pytest.mark.slow
def test_predicted_and_simulated_error_rates_agree():
    """A small version of ``tools/limit_simulation.py``: the noise is drawn, and both models are refitted to each draw."""
    case = limit_simulation.case_of("crosstalk", "rig", 47, 4.0)
    draws = 60
    wrong = sum(limit_simulation.known_input(case, draws))
    low, high = wilson(wrong, draws)
    assert low <= norm.cdf(-0.5 * sqrt(case.d2_known)) <= high and 1.0 < case.d2_known < 40.0


DELAY = ("channel_delay", "rig", 50, 2.0, 0.32)


@pytest.mark.parametrize(
    ("effect", "simulator", "seed", "target", "free"),
    # a low-pass of three constants that shows a delay of two: P(chi^2 > 1); four constants against one; one that stands at its bound
    asked((DELAY, ("crosstalk", "variant", 47, 2.0, 0.30), ("gain_error", "rig", 41, 2.0, 0.07)), DELAY, several=True),
)
def test_what_is_refitted_is_counted_in_the_predicted_rate(effect, simulator, seed, target, free):
    """The normal tail of D / 2 knows nothing of what models gain by chance: 50 % for 32 % and 22 % for 30 %."""
    case = limit_simulation.case_of(effect, simulator, seed, target)
    draws = 60
    low, high = wilson(sum(limit_simulation.known_input(case, draws)), draws)
    predicted = limit_simulation.free_tail(case)
    assert predicted == pytest.approx(free, abs=0.04) and low <= predicted <= high


@pytest.mark.slow
def test_a_model_is_relieved_of_what_noise_gives_it():
    case = limit_simulation.case_of("asymmetric_friction", "rig", 42, 4.0)
    # one constant against two, and a theta for each of two bends: half a nat each
    own, other = limit_simulation.reliefs(case, 60)
    thetas = len(case.own.theta)
    assert own == pytest.approx(0.5 * (1 + thetas), abs=0.4) and other == pytest.approx(0.5 * (2 + thetas), abs=0.4)


def test_the_observer_and_the_figure_ask_for_what_the_diagnosis_asks_for():
    assert pytest.approx(DECIDES_NATS) == ODDS
    assert figure.DECIDABLE == DECIDABLE and ideal(DECIDABLE) > 0.95 > ideal(DECIDABLE - 1.0)
