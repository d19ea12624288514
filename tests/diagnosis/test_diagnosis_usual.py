"""What a rig is usually off by is no change: evidence counts from the simulator as it usually is."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from made_fits import NOISE_N, made, noise, simulator

from sstl_cli.diagnosis.evidence import Weighed
from sstl_cli.diagnosis.found import Search
from sstl_cli.diagnosis.hypotheses import variants
from sstl_cli.diagnosis.usual import _price, beyond
from sstl_cli.diagnosis.variation import of_a_record
from sstl_cli.diagnosis.whitening import Noise, Sensor
from sstl_cli.physics.scenario import Variation, WanderSection

SENSOR = Sensor(NOISE_N, 0.2 * NOISE_N, 0.2)
NOISE = Noise({"act": SENSOR}, {"act": SENSOR}, {"act": 1.0})


def one(effect, name):
    return next(h for h in variants(effect, ("act",)) if [f.parameter.name for f in h.strengths] == [name])


def search(usual, offset, evidence):
    models = {
        "zero_offset": Weighed(made(noise(), one("zero_offset", "z_out_act_n"), (offset,)), evidence + 5.0, evidence),
        "gain_error": Weighed(made(noise(), one("gain_error", "g_act"), (1.02,)), 45.0, 40.0),
    }
    sim = simulator()
    sim.usual = usual
    return Search(sim, NOISE, NOISE, made(noise()), {k: (w,) for k, w in models.items()}, {})


def evidence(found):
    return {k: v[0].evidence for k, v in found.singles.items()}


def test_a_strength_within_what_is_usual_is_worth_its_price_and_nothing_more():
    found = search({("zero_offset", "z_out_act_n"): 0.05}, 0.1, 60.0)
    # two standard deviations: 2 nats above the simulator as it usually is, and whoever explains less is behind it
    assert evidence(beyond(found)) == pytest.approx({"zero_offset": 2.0, "gain_error": -18.0})


def test_a_strength_far_beyond_what_is_usual_stays_a_change():
    found = search({("zero_offset", "z_out_act_n"): 0.005}, 0.1, 60.0)
    assert beyond(found) is found


@pytest.mark.parametrize("usual", [{}, {("gain_error", "g_sstl"): 0.1}])
def test_what_is_not_known_to_vary_is_a_change(usual):
    found = search(usual, 0.1, 60.0)
    assert beyond(found) is found


def test_a_record_is_off_by_the_mean_of_its_parts():
    none = Variation(theta=0.0, effects={})
    part = Variation(theta=0.0, effects={"presliding": {"dahl_mm": 0.3, "tail": 0.5}})
    section = WanderSection(stretch_s=5.0, stretch=part, run=part, whole=none)
    assert of_a_record(section, 9, 4) == {("presliding", "dahl_mm"): pytest.approx(np.hypot(0.1, 0.15))}
    assert of_a_record(replace_whole(section, part), 9, 4)[("presliding", "dahl_mm")] == pytest.approx(np.sqrt(0.01 + 0.0225 + 0.09))


def replace_whole(section, part):
    return section.model_copy(update={"whole": part})


def test_combinations_count_from_there_as_well():
    found = search({("zero_offset", "z_out_act_n"): 0.05}, 0.1, 60.0)
    pair = replace(found.singles["gain_error"][0], evidence=65.0)
    both = replace(found, combined={("gain_error", "zero_offset"): pair})
    assert beyond(both).combined[("gain_error", "zero_offset")].evidence == pytest.approx(7.0)


def test_the_price_of_several_strengths_is_that_of_their_squares_together_and_of_a_change_none():
    full = next(h for h in variants("zero_offset", ("act",)) if len(h.strengths) == 2)
    names = [("zero_offset", f.parameter.name) for f in full.strengths]
    model = Weighed(made(noise(), full, (0.1, -0.3)), 65.0, 60.0)
    found = replace(search({}, 0.1, 60.0), singles={"zero_offset": (model,)})
    # one and two standard deviations: 2.5 nats
    found.sim.usual = dict(zip(names, (0.1, 0.15), strict=True))
    assert _price(found, model) == pytest.approx(2.5) and evidence(beyond(found)) == pytest.approx({"zero_offset": 2.5})
    # of which one is not known to vary, or by nothing, is a change
    for usual in ({names[0]: 0.1}, {names[0]: 0.1, names[1]: 0.0}):
        found.sim.usual = usual
        assert _price(found, model) == float("inf") and beyond(found) is found
    found.sim.usual = dict.fromkeys(names, 0.1)
    assert _price(found, replace(model, fit=made(noise()))) == float("inf")
    # what costs more than it explains leaves all as it was
    found.sim.usual = dict.fromkeys(names, 0.02)
    assert beyond(found) is found
