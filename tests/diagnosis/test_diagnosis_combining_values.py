"""What combinations promise, where they begin and which of them are fitted, on stand-ins and small records."""

from __future__ import annotations

import numpy as np
import pytest
from made_fits import NOISE_N, made, named, noise, simulator

from sstl_cli.diagnosis import combining as of
from sstl_cli.diagnosis.evidence import Weighed, strengths_charge
from sstl_cli.diagnosis.found import Search
from sstl_cli.diagnosis.hypotheses import full, variants
from sstl_cli.diagnosis.whitening import Noise, Sensor

SIM = simulator()
QUIET = Sensor(NOISE_N, 0.0, 0.1)
NOISE = Noise({"act": QUIET}, {"act": QUIET}, {"act": 1.0})
ZERO, OUT = full("zero_offset", ("act",)), named("zero_offset", "z_out_act_n")
FRICTION, GAIN = (variants(e, ("act",))[0] for e in ("const_friction", "gain_error"))


def weighed(h, values, evidence=1.0):
    return Weighed(made(0.0, h, values), evidence + 4.0, evidence)


GAINED, LOST, RUBS = weighed(GAIN, (1.1,), 9.0), weighed(ZERO, (0.0, 0.1), 7.0), weighed(FRICTION, (0.1,), 5.0)


def searched(*singles, combined=()):
    return Search(SIM, NOISE, NOISE, made(noise(1)), {w.ids[0]: (w,) for w in singles}, {tuple(sorted(w.ids)): w for w in combined})


def pair(one, other, evidence):
    return weighed(one.fit.hypothesis.joined(other.fit.hypothesis), (*one.fit.values, *other.fit.values), evidence)


def test_a_promise_is_a_gain_less_what_all_strengths_together_cost():
    assert of._promise(50.0, GAINED) == pytest.approx(50.0 - strengths_charge(1, 100.0))
    assert of._promise(50.0, GAINED, LOST) == pytest.approx(50.0 - strengths_charge(3, 100.0))
    assert of._promise(-5.0, GAINED) == pytest.approx(-strengths_charge(1, 0.0))


def test_a_job_has_the_effects_of_its_leader_and_of_what_joins_in_the_order_of_their_names():
    assert of._Job(1.0, LOST, (GAINED,), ()).ids == ("gain_error", "zero_offset") and of._Job(1.0, None, (LOST, RUBS), ()).ids == (
        "const_friction",
        "zero_offset",
    )


def test_a_combination_without_a_part_keeps_the_others_as_they_are_in_it():
    both = pair(GAINED, LOST, 20.0)
    rest = of._without(searched(GAINED, LOST, combined=[both]), both, "gain_error")
    assert rest.ids == ("zero_offset",) and rest.fit.values.tolist() == [0.0, 0.1] and rest.fit.theta.tolist() == both.fit.theta.tolist()
    assert of._without(searched(GAINED, LOST, combined=[both]), both, "zero_offset").fit.values.tolist() == [1.1]


def test_what_stands_for_a_part_begins_with_what_does_most_nearly_the_same():
    both = pair(RUBS, weighed(OUT, (0.3,)), 20.0)
    kept = of._without(searched(RUBS, LOST, combined=[both]), both, "zero_offset")
    # an output 0.3 N too high is one that both zeros make, that of the input at none
    assert of._like_part(both, kept, LOST) == pytest.approx([0.02, 0.3], abs=0.021)


def test_the_parts_of_the_leading_pairs_are_fitted_alone_and_kept_where_they_are_likelier(monkeypatch):
    pairs = [pair(GAINED, LOST, 20.0), pair(GAINED, RUBS, 15.0)]
    found = searched(GAINED, LOST, RUBS, combined=pairs)
    begun = {}
    monkeypatch.setattr(of, "settle", lambda sim, noise, start, rounds: start if rounds == 1 else None)
    evidence = {"gain_error": 9.0, "zero_offset": 7.5, "const_friction": 4.0}

    def alone(sim, f, base):
        begun[f.ids] = f
        return Weighed(f, 1.0, evidence[f.ids[0]])

    monkeypatch.setattr(of, "weigh", alone)
    of._parted(found, 1)
    assert set(begun) == {("gain_error",), ("zero_offset",), ("const_friction",)}
    # as evident is no better
    assert found.singles["gain_error"] == (GAINED,) and found.singles["const_friction"] == (RUBS,)
    assert [w.evidence for w in found.singles["zero_offset"]] == [7.5, 7.0] and found.singles["zero_offset"][1] is LOST


def jobs_of(monkeypatch, found, size, partners=(), pairs=()):
    """Return the effects and promises of the combinations that are fitted, in their order."""
    fitted = []

    def joined(found, job):
        fitted.append((job.ids, job.promise, job.leader is None))
        return weighed(GAIN, (1.0,))

    monkeypatch.setattr(
        of,
        "_partners",
        lambda sim, leader, others, workers: [(w, e, np.zeros(len(w.fit.free))) for w in others for i, e in partners if w.ids == (i,)],
    )
    monkeypatch.setattr(
        of, "_pairs", lambda sim, base, models: [(two, e, tuple(np.zeros(len(w.fit.free)) for w in two)) for two, e in pairs]
    )
    monkeypatch.setattr(of, "_joined", joined)
    monkeypatch.setattr(of, "_swap", lambda *_: False)
    monkeypatch.setattr(of, "_parted", lambda *_: None)
    return of.combine(found, size, 1), fitted


def test_combinations_are_fitted_the_most_promising_first_each_once_by_its_best_promise(monkeypatch):
    found = searched(GAINED, LOST, RUBS)
    count, fitted = jobs_of(
        monkeypatch,
        found,
        2,
        [("const_friction", 4.0), ("zero_offset", 3.5)],
        [((GAINED, LOST), 30.0), ((LOST, RUBS), 12.0), ((GAINED, RUBS), 12.1)],
    )
    # beside the leader of 9: 13 and 12.5; two joined at once by more than that and 3; friction beside the zero has 7 + 4
    assert fitted == [
        (("gain_error", "zero_offset"), 30.0, True), (("const_friction", "gain_error"), 13.0, False), (("const_friction", "zero_offset"), 11.0, False),
    ]  # fmt: skip
    assert count == 3
    # what adds three nats to the leader is not worth it
    assert jobs_of(monkeypatch, searched(GAINED, LOST), 2, [("zero_offset", 3.0)], [((GAINED, LOST), 12.0)]) == (0, [])


def test_three_effects_are_led_by_the_most_evident_pair_alone_and_three_of_them_are_fitted(monkeypatch):
    rest = [
        weighed(variants(i, ("act",))[0], (0.0,) * len(variants(i, ("act",))[0].free), -1.0)
        for i in ("viscous", "crosstalk", "asymmetric_friction", "const_friction")
    ]
    lead, other = pair(GAINED, LOST, 20.0), pair(GAINED, RUBS, 15.0)
    found = searched(GAINED, LOST, *rest, combined=[lead, other])
    count, fitted = jobs_of(monkeypatch, found, 3, [(w.ids[0], 4.0 + k) for k, w in enumerate(rest)])
    assert count == 3 and [(len(ids), promise) for ids, promise, _ in fitted] == [(3, 27.0), (3, 26.0), (3, 25.0)]
    assert all({"gain_error", "zero_offset"} < set(ids) for ids, *_ in fitted)


def test_a_likelier_pair_is_looked_beside_once_more_and_parts_are_fitted_of_pairs_alone(monkeypatch):
    for size, swaps in ((2, [True, False]), (2, [False]), (3, [])):
        asked, left = [], iter(swaps)
        found = searched(GAINED, LOST, combined=[pair(GAINED, LOST, 20.0)])
        monkeypatch.setattr(of, "_partners", lambda *_: [])
        monkeypatch.setattr(of, "_pairs", lambda *_: [])
        monkeypatch.setattr(of, "_swap", lambda found, workers, asked=asked, left=left: asked.append("swap") or next(left))
        monkeypatch.setattr(of, "_parted", lambda found, workers, asked=asked: asked.append("parts"))
        assert of.combine(found, size, 1) == 0
        assert asked == ["swap"] * len(swaps) + (["parts"] if size == 2 else [])


def test_a_newcomer_begins_at_the_edge_of_nothing_on_the_side_where_it_may_be():
    f = made(0.0, named("gain_error", "g_act"), (1.1,))
    width = f.free[0].width
    assert of._begin(f, np.array([0.0])) == pytest.approx([1.0 + 1e-3 * width]) and of._begin(
        f, np.array([-0.01 * width])
    ) == pytest.approx([1.0 - 0.01 * width])
