"""Simulators that stand in for hardware take every effect of the catalogue as it stands there."""

from __future__ import annotations

import pytest

from sstl_cli.physics import bristle, rig, variant
from sstl_cli.physics.effects import catalogue, get
from sstl_cli.steps.simulate_rig import KNOWN, stated

RESOLVED = {"rig": rig.resolve_effects, "bristle": bristle.resolve_effects, "variant": variant.resolve_effects}


# a tube that buckles is a law of the fast model alone
NARROWER = {("sheath_compliance", "c_t_per_n")}


@pytest.mark.parametrize("simulator", RESOLVED)
@pytest.mark.parametrize("effect_id", catalogue())
def test_names_and_neutral_values_are_those_of_the_catalogue_and_ranges_reach_as_far(simulator, effect_id):
    assert set(KNOWN[simulator]()) == set(catalogue())
    for name, bounds in KNOWN[simulator]()[effect_id].items():
        declared = get(effect_id).parameter(name)
        assert bounds.neutral == declared.neutral
        assert bounds.low <= declared.low or (effect_id, name) in NARROWER
        assert bounds.low <= bounds.neutral <= bounds.high >= declared.high


@pytest.mark.parametrize("simulator", RESOLVED)
@pytest.mark.parametrize("effect_id", catalogue())
def test_what_does_nothing_is_refused_by_no_simulator(simulator, effect_id):
    defaults = {p.name: p.neutral for p in catalogue()[effect_id].parameters}
    told = stated(effect_id, defaults, KNOWN[simulator]())
    found = RESOLVED[simulator]({effect_id: told})[effect_id]
    assert {n: defaults[n] for n in told} == told and set(told) <= set(found)


@pytest.mark.parametrize("simulator", RESOLVED)
def test_what_a_simulator_has_no_code_for_is_still_refused(simulator):
    told = stated("stribeck", {"ratio": 1.2, "v_s_mm_s": 1.0, "mean_ratio": 1.1, "mean_mm_s": 2.0}, KNOWN[simulator]())
    with pytest.raises(ValueError, match="mean_ratio"):
        RESOLVED[simulator]({"stribeck": told})


def test_the_shape_of_a_law_that_is_off_is_no_question():
    told = stated("stribeck", {"ratio": 1.2, "v_s_mm_s": 1.0, "mean_ratio": 1.0, "mean_mm_s": 2.0}, KNOWN["bristle"]())
    assert told == {"ratio": 1.2, "v_s_mm_s": 1.0}
