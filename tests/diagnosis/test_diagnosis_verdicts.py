"""Verdicts on rig recordings: each effect, nothing, two at once, an excluded one, one of no catalogue."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from rig_logs import FULL, RAMPS, STRENGTH, record, scenario, theta_jump

from sstl_cli.core.config import parse
from sstl_cli.core.groups import spelled_out
from sstl_cli.diagnosis.hypotheses import FAMILIES
from sstl_cli.physics.effects import catalogue, get
from sstl_cli.physics.scenario import Scenario
from sstl_cli.steps import simulate
from sstl_cli.steps.diagnose import DiagnoseOptions, run

# a part of the catalogue that costs little and has look-alikes; the whole one is asked in the slow tests
FEW = ("pulley_friction", "const_friction", "gain_error", "zero_offset", "zero_drift", "channel_delay")


def verdict(runs, **options):
    return run(runs, DiagnoseOptions(**{"max_effects": 1, "workers": 2, "effects": FEW} | options)).document()


def of_all(effects, seed=0, **rig):
    """The verdict by the whole catalogue on long recordings."""
    return verdict(record(effects, seed, hz=100.0, moves=FULL, **rig), effects=None, max_effects=2)


def test_every_fitted_effect_has_a_strength():
    fitted = {e.id for e in catalogue().values() if e.fitted and e.channel == "out"}
    assert fitted == set(STRENGTH)


@pytest.mark.slow
@pytest.mark.parametrize("effect", ["viscous", "zero_drift"])
def test_the_effect_or_its_group_is_named(effect):
    document = verdict(record({effect: {k: 2.0 * v for k, v in STRENGTH[effect].items()}}), effects=tuple(sorted({*FEW, effect})))
    assert document["verdict"]["status"] in ("identified", "ambiguous"), document["verdict"]
    assert effect in document["verdict"]["ambiguity_group"]
    assert document["gap"]["shrink_pct"] > 20


@pytest.mark.slow
@pytest.mark.parametrize("effect", sorted(STRENGTH))
def test_every_effect_or_its_group_is_named(effect):
    verdict = of_all({effect: STRENGTH[effect]}, configs=3)["verdict"]
    if effect in FAMILIES["stick-slip"] and verdict["status"] == "unknown":
        # jumps too small to be seen to rest are scatter like any other, and it says whose
        assert any(f"best candidate, {member}, lets the output scatter" in verdict["why"] for member in FAMILIES["stick-slip"])
        return
    assert verdict["status"] in ("identified", "ambiguous"), verdict
    assert effect in spelled_out(verdict["ambiguity_group"], verdict.get("members"))


@pytest.fixture(scope="module")
def nothing():
    """The diagnosis of a log that lacks nothing but the right theta."""
    return verdict(record({}, 5))


def test_nothing_missing_is_none(nothing):
    assert nothing["verdict"]["status"] == "none", nothing["verdict"]
    assert nothing["verdict"]["effects"] == []


def test_none_says_what_would_have_shown(nothing):
    shown = {s["effect"]: s for s in nothing["verdict"]["would_have_shown"]}
    assert set(shown) == set(FEW)
    # ten times the noise of one sample is no small offset; a thousandth of it cannot be told
    assert 2e-5 < shown["zero_offset"]["size"] < 0.2
    assert all(0.0 < s["gap_n"] < 0.02 for s in shown.values())
    # and from what each would have been told: not where it does not show
    assert all(s["rival"] in set(FEW) - {e} for e, s in shown.items())
    assert all(s["told_size"] is None or s["told_size"] >= s["size"] for s in shown.values())
    assert any(s["told_size"] is not None for s in shown.values())


def test_no_interval_reaches_beyond_what_its_parameter_can_be(nothing):
    told = [p for c in nothing["candidates"] for p in c["parameters"] if p["ci95"] is not None]
    assert told
    for p in told:
        can_be = get(p["effect"]).parameter(p["name"])
        assert can_be.least <= p["ci95"][0] <= p["estimate"] <= p["ci95"][1] <= can_be.most, p


def test_retuning_is_never_credited(nothing):
    """A wrong nominal theta alone: the error falls by re-tuning, and no effect is named for it."""
    gap = nothing["gap"]
    assert gap["rmse_base_n"] > 3 * gap["rmse_retuned_n"]
    assert gap["shrink_pct"] == 0.0 and gap["shrink_ci95_pct"] is None and gap["shrink_why"]


@pytest.mark.slow
def test_nothing_missing_is_none_with_coloured_noise():
    document = verdict(record({}, 0, white=0.01, coloured=0.02))
    assert document["verdict"]["status"] == "none", document["verdict"]


@pytest.mark.slow
def test_nothing_missing_is_none_in_19_of_20_seeds():
    none = [of_all({}, seed, white=0.01, coloured=0.02)["verdict"]["status"] == "none" for seed in range(20)]
    assert sum(none) >= 19


@pytest.mark.slow
def test_two_effects_are_both_named():
    pair = {"pulley_friction": {"m_p": 0.04, "m_r": 0.04}, "zero_offset": {"z_out_act_n": 0.5}}
    document = verdict(record(pair), max_effects=2, effects=("pulley_friction", "zero_offset", "zero_drift"))
    assert document["verdict"]["status"] in ("identified", "ambiguous"), document["verdict"]
    assert set(document["verdict"]["effects"]) == set(pair)


@pytest.mark.slow
def test_an_excluded_effect_leads_to_unknown():
    strong = {k: 2.0 * v for k, v in STRENGTH["presliding"].items()}
    found = verdict(record({"presliding": strong}), effects=(*FEW, "presliding"), exclude=("presliding",))
    assert found["verdict"]["status"] == "unknown" and found["verdict"]["effects"] == [], found["verdict"]


@pytest.mark.slow
def test_what_looks_like_an_excluded_effect_is_not_named_for_sure():
    """A delay takes four fifths of the squared error of a drag, and leaves far more than the noise."""
    found = verdict(record({"viscous": {"c_l_n_s_per_mm": 0.04}}), effects=(*FEW, "viscous"), exclude=("viscous",))
    assert found["verdict"]["status"] in ("ambiguous", "unknown") and found["verdict"]["probability_unknown"] > 0.4, found["verdict"]
    assert found["verdict"]["confidence"] < 0.6 and ("no name" in found["verdict"]["why"] or "leaves more" in found["verdict"]["why"])


@pytest.fixture(scope="module")
def jumped():
    return verdict(theta_jump(record({})), effects=FEW[:5])


@pytest.mark.slow
def test_an_effect_of_no_catalogue_is_unknown(jumped):
    assert jumped["verdict"]["status"] == "unknown", jumped["verdict"]


@pytest.mark.slow
def test_unknown_says_what_is_left_and_where(jumped):
    left = jumped["verdict"]["leftover"]
    assert left and all(t["test"] and t["where"] for t in left)
    assert left[0]["sigma"] > 5.0 and [t["sigma"] for t in left] == sorted((t["sigma"] for t in left), reverse=True)


@pytest.mark.slow
@pytest.mark.parametrize("effect", ["channel_delay", "channel_lowpass"])
def test_the_proposed_recording_separates_what_was_ambiguous(effect):
    """Ramps cannot tell a delay from a low-pass; the movement that is proposed, made on the rig, does."""
    truth, two = {effect: {"tau_act_s": 0.025}}, ("channel_delay", "channel_lowpass")
    ramps = scenario(hz=100.0, moves=RAMPS)
    first = verdict(list(simulate.run(ramps, truth, 3)), effects=two)
    if first["verdict"]["status"] == "identified":
        # ramps with corners at 100 Hz told them apart already
        assert first["verdict"]["effects"] == [effect]
        return
    assert first["verdict"]["status"] == "ambiguous"
    assert {"channel_delay", "channel_lowpass"} <= set(spelled_out(first["verdict"]["ambiguity_group"], first["verdict"].get("members")))
    proposed = parse(Scenario, first["next_experiment"]["scenario"], "next experiment")
    proposed = proposed.model_copy(update={"simulator": "rig", "noise": ramps.noise})
    both = [*simulate.run(ramps, truth, 3), *renamed(simulate.run(proposed, truth, 4))]
    second = verdict(both, effects=two)
    assert first["next_experiment"]["settles"] and second["candidates"][0]["id"] == effect
    # odds of 49 to 1, which the proposal promises
    right, wrong = (c["evidence_nats"] for c in second["candidates"][:2])
    assert right - wrong > np.log(49.0)


def renamed(runs):
    return [replace(r, run_id=f"next-{r.run_id}") for r in runs]
