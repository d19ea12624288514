"""A pair that pulls both ways: its preload is a constant of the rig, found where inputs go below zero, kept with the model."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from made_pairs import PRELOAD_N, THETA, pair

from sstl_cli.core.errors import SstlError
from sstl_cli.diagnosis.movements import with_movements
from sstl_cli.diagnosis.preload import preload_of
from sstl_cli.diagnosis.records import prepare
from sstl_cli.physics.effect import Mechanics
from sstl_cli.physics.scenario import Scenario, load
from sstl_cli.physics.transmission.active import activate
from sstl_cli.physics.transmission.model import drive_of, predict


def test_a_pair_reads_what_its_tendon_carries_beyond_the_preload():
    u = np.array([0.0, 15.0, 20.0, -10.0, -15.0])
    drive = drive_of("act", None, 0.1, u, Mechanics(preload_n={"act": PRELOAD_N}))
    pull, release = np.exp(-THETA), np.exp(THETA)
    # midway at first; 45 and 50 N pull, 20 N are held up to e^0.3 times as much, 15 N give way
    begins = 0.5 * (pull + release) * 30.0
    expected = [begins, max(begins, 45.0 * pull), 50.0 * pull, release * 20.0, release * 15.0]
    assert predict(drive, THETA, activate({})) + PRELOAD_N == pytest.approx(expected)
    # a law of the line goes by all that the tendon carries
    alone = drive_of("act", None, 0.1, u + PRELOAD_N, Mechanics())
    stiff = activate({"sheath_compliance": {"c_t_per_n": 0.005}})
    assert predict(drive, THETA, stiff) + PRELOAD_N == pytest.approx(predict(alone, THETA, stiff))


def test_what_only_pulls_has_none_and_a_zero_that_is_off_does_not_make_it_push():
    only = replace(pair(), tension_in_n=pair().tension_in_n + 12.0)
    assert preload_of([only], None) == {}
    assert preload_of([replace(only, tension_in_n=only.tension_in_n - 4.0)], None) == {}
    assert preload_of([replace(only, tension_in_n=-only.tension_in_n)], None) == {}
    # nor one run of three, or samples that were not read
    assert preload_of([only, replace(only, run_id="b"), pair("c")], None) == {}
    assert preload_of([replace(only, tension_in_n=np.full(len(only), np.nan))], None) == {}


@pytest.mark.parametrize("size", [1.0, 60.0])
def test_an_input_that_goes_both_ways_is_stretched_by_what_it_is(size):
    found = preload_of([pair(size=size), pair("b", 4.3, size=size)], None)["act"] / size
    assert found == pytest.approx(PRELOAD_N, rel=1e-3)


def test_what_the_simulator_says_of_it_holds():
    assert preload_of([pair()], Scenario().with_rig(preload_n={"act": 12.0})) == {"act": 12.0}
    # a model that a diagnosis accepted has said what there is
    assert preload_of([pair()], Scenario(package_version="0.2.0")) == {}


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("[[trajectories]]\nkind = 'sinusoid'\nlow_n = -1.0\n", "a tendon cannot push"),
        ("[rig]\npreload_n = {act = 5.0}\n[[trajectories]]\nkind = 'sinusoid'\nsystems = ['act']\nlow_n = -6.0\n", "below -5 N"),
        ("[rig]\npreload_n = {act = 5.0}\n[[trajectories]]\nkind = 'sinusoid'\nlow_n = -1.0\n", "below 0 N"),
        ("simulator = 'rig'\n[rig]\npreload_n = {act = 5.0}\n", "fast model alone"),
        ("[rig]\npreload_n = {act = -5.0}\n", "preload_n"),
    ],
)
def test_a_scenario_in_which_a_tendon_would_push_is_refused(tmp_path, text, words):
    (tmp_path / "pair.toml").write_text('schema = "sstl.scenario/1"\n' + text, "utf-8")
    with pytest.raises(SstlError, match=words):
        load(str(tmp_path / "pair.toml"))


@pytest.mark.parametrize(("unit_n", "low_n"), [(1.0, -9.99), (4.7, -46.9), (470.0, -1000.0)])
def test_movements_of_a_pair_go_as_low_as_its_record_and_as_a_scenario_may(unit_n, low_n):
    swung = replace(pair(swing_n=10.0), tension_in_n=10.0 * np.sin(np.arange(2000) / 80.0))
    found = with_movements(Scenario().with_rig(preload_n={"act": 30.0 * unit_n}), prepare([swung], unit_n))
    assert [t.low_n for t in found.trajectories] == pytest.approx([low_n] * len(found.trajectories), rel=3e-3)
    assert Scenario.model_validate(found.model_dump(by_alias=True)).rig.preload_n == {"act": 30.0 * unit_n}
