"""Verdicts on rig recordings: each effect, nothing, two at once, an excluded one, one of no catalogue."""

from __future__ import annotations

from dataclasses import replace

import pytest
from rig_logs import STRENGTH, TRAJECTORIES, record, scenario, theta_jump

from sstl_cli.core.config import parse
from sstl_cli.physics.effects import catalogue
from sstl_cli.physics.scenario import Scenario
from sstl_cli.steps import simulate
from sstl_cli.steps.diagnose import DiagnoseOptions, run


def verdict(runs, **options):
    return run(runs, DiagnoseOptions(max_effects=2, workers=2, **options)).document()


def test_every_fitted_effect_has_a_strength():
    fitted = {e.id for e in catalogue().values() if e.fitted and e.channel == "out"}
    assert fitted == set(STRENGTH)


@pytest.mark.parametrize("effect", ["pulley_friction", "viscous", "presliding", "zero_drift", "stick_slip"])
def test_the_effect_or_its_group_is_named(effect):
    document = verdict(record({effect: STRENGTH[effect]}))
    assert document["verdict"]["status"] in ("identified", "ambiguous"), document["verdict"]
    assert effect in document["verdict"]["ambiguity_group"]
    assert document["gap"]["shrink_pct"] > 20


@pytest.mark.slow
@pytest.mark.parametrize("effect", sorted(STRENGTH))
def test_every_effect_or_its_group_is_named(effect):
    document = verdict(record({effect: STRENGTH[effect]}, hz=200.0, configs=3))
    assert document["verdict"]["status"] in ("identified", "ambiguous"), document["verdict"]
    assert effect in document["verdict"]["ambiguity_group"]


@pytest.mark.parametrize("seed", range(2))
def test_nothing_missing_is_none_with_coloured_noise(seed):
    document = verdict(record({}, seed, white=0.01, coloured=0.02))
    assert document["verdict"]["status"] == "none", document["verdict"]
    assert document["verdict"]["effects"] == []


@pytest.mark.slow
def test_nothing_missing_is_none_in_19_of_20_seeds():
    none = [verdict(record({}, seed, white=0.01, coloured=0.02))["verdict"]["status"] == "none" for seed in range(20)]
    assert sum(none) >= 19


def test_two_effects_are_both_named():
    pair = {"pulley_friction": {"m_p": 0.04, "m_r": 0.04}, "zero_offset": {"z_out_act_n": 0.5}}
    document = verdict(record(pair))
    assert document["verdict"]["status"] == "identified", document["verdict"]
    assert set(document["verdict"]["effects"]) == set(pair)


def test_an_excluded_effect_leads_to_unknown():
    document = verdict(record({"viscous": {"c_l_n_s_per_mm": 0.04}}), exclude=("viscous",))
    assert document["verdict"]["status"] == "unknown", document["verdict"]


def test_an_effect_of_no_catalogue_is_unknown():
    document = verdict(theta_jump(record({})))
    assert document["verdict"]["status"] == "unknown", document["verdict"]


def test_retuning_is_never_credited():
    """A wrong nominal theta alone: the error falls by re-tuning, and no effect is named for it."""
    document = verdict(record({}, seed=5))
    gap = document["gap"]
    assert gap["rmse_base_n"] > 3 * gap["rmse_retuned_n"]
    assert document["verdict"]["status"] == "none"
    assert gap["shrink_pct"] == 0.0


@pytest.mark.parametrize("effect", ["channel_delay", "channel_lowpass"])
def test_the_proposed_recording_separates_what_was_ambiguous(effect):
    """Ramps cannot tell a delay from a low-pass; the movement that is proposed, made on the rig, does."""
    truth = {effect: {"tau_act_s": 0.02}}
    ramps = scenario().model_copy(update={"trajectories": TRAJECTORIES[:2]})
    first = run(list(simulate.run(ramps, truth, 3)), DiagnoseOptions(max_effects=1, workers=2)).document()
    assert first["verdict"]["status"] == "ambiguous"
    assert {"channel_delay", "channel_lowpass"} <= set(first["verdict"]["ambiguity_group"])
    proposed = parse(Scenario, first["next_experiment"]["scenario"], "next experiment")
    proposed = proposed.model_copy(update={"simulator": "rig", "noise": ramps.noise})
    both = [*simulate.run(ramps, truth, 3), *renamed(simulate.run(proposed, truth, 4))]
    second = run(both, DiagnoseOptions(max_effects=1, workers=2)).document()
    assert second["verdict"]["status"] == "identified" and second["verdict"]["effects"] == [effect]


def renamed(runs):
    return [replace(r, run_id=f"next-{r.run_id}") for r in runs]
