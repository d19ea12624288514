"""A model that leaves much of its record, as every real one does: nothing has changed, or something has."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from sstl_cli.blind.inject import Injection, put_in
from sstl_cli.core.runs import Run
from sstl_cli.diagnosis.state import turning
from sstl_cli.physics.scenario import load
from sstl_cli.physics.scenario_file import dump
from sstl_cli.steps.diagnose import DiagnoseOptions, run
from tests.diagnosis.rig_logs import record

OPTIONS = DiagnoseOptions(effects=("zero_offset", "const_friction", "friction_drift"), max_effects=1)
# one Monday looks as if its zero were off by 0.2 N although it is not: six times that are a change, four are none for sure
SHIFT_N = 1.2


def odd(runs: list[Run], seed: int) -> list[Run]:
    """Return runs of a rig with a shape that is in no catalogue: a ripple over its input behind a backlash of 2 N, and unrest."""
    rng = np.random.default_rng(seed)
    made = []
    for r in runs:
        behind = np.empty(len(r))
        at = float(r.tension_in_n[0])
        for i, u in enumerate(r.tension_in_n):
            at = min(max(at, u - 1.0), u + 1.0)
            behind[i] = at
        unrest = np.convolve(rng.standard_normal(len(r) + 24), np.full(25, 0.2), mode="valid") * 0.03
        made.append(replace(r, tension_out_n=r.tension_out_n + 0.3 * np.sin(0.5 * behind) + unrest))
    return made


@pytest.fixture(scope="module")
def monday(tmp_path_factory):
    found = run(odd(record({}, 1), 1), OPTIONS)
    path = tmp_path_factory.mktemp("model") / "rig.toml"
    path.write_text(dump(found.model()))
    return found, load(str(path))


@pytest.mark.slow
def test_what_the_model_leaves_is_known(monday):
    found, model = monday
    assert found.document()["verdict"]["status"] == "unknown"
    again = run(odd(record({}, 1), 1), replace(OPTIONS, sim=model)).document()
    assert again["verdict"]["status"] == "none"
    # the error is as large as it was said to be, and known
    assert again["gap"]["rmse_base_n"] == pytest.approx(found.document()["gap"]["rmse_with_effect_n"], rel=0.1)
    assert again["gap"]["known_misfit_n"] == pytest.approx(again["gap"]["rmse_base_n"], rel=0.15)
    assert "nothing has changed" in again["sentence"] and again["analysis"]["theta_changed"] is False


@pytest.mark.slow
def test_another_recording_of_the_same_rig_is_none(monday):
    again = run(odd(record({}, 2), 2), replace(OPTIONS, sim=monday[1])).document()
    assert again["verdict"]["status"] == "none"


@pytest.mark.slow
def test_friction_that_has_risen_all_along_is_said(monday):
    # a rig of which the model had four fifths of the friction
    less = tuple(c.model_copy(update={"theta": 0.8 * c.theta}) for c in monday[1].configurations)
    again = run(odd(record({}, 2), 2), replace(OPTIONS, sim=monday[1].model_copy(update={"configurations": less}))).document()
    now, was = again["analysis"]["theta"], again["analysis"]["theta_before"]
    assert {c: now[c] / t for c, t in was.items()} == pytest.approx(dict.fromkeys(was, 1.25), rel=0.05)
    assert again["verdict"]["status"] == "none" and again["analysis"]["theta_changed"]
    assert again["sentence"].startswith("Theta has changed since the simulator was accepted (") and "+25 %" in again["sentence"]


@pytest.mark.slow
def test_friction_at_the_end_of_a_rig_with_a_habit_is_named_and_kept(monday):
    runs = put_in(odd(record({}, 2), 2), Injection("const_friction", 0.6, "w_end_n"))
    found = run(runs, replace(OPTIONS, sim=monday[1]))
    assert found.verdict.effects == ("const_friction",) and found.verdict.status == "identified"
    values = {p["name"]: p["estimate"] for p in found.document()["candidates"][0]["parameters"]}
    assert values["w_end_n"] == pytest.approx(0.6, rel=0.15)
    # accepted, it is the rig's own
    again = run(runs, replace(OPTIONS, sim=found.model())).document()
    assert again["verdict"]["status"] == "none"
    assert again["gap"]["rmse_base_n"] == pytest.approx(again["gap"]["known_misfit_n"], rel=0.15)


@pytest.mark.slow
def test_a_change_beyond_what_the_rig_seems_to_be_off_by_is_named(monday):
    # what one Monday did not show of a map all its Fridays have in common: two of each
    other = run(odd(record({}, 11), 11), OPTIONS).model()
    sizes = []
    for seed, model in ((2, monday[1]), (31, other)):
        runs = [replace(r, tension_out_n=r.tension_out_n + SHIFT_N * (r.system == "act")) for r in odd(record({}, seed), seed)]
        found = run(runs, replace(OPTIONS, sim=model)).document()
        assert "zero_offset" in found["verdict"]["effects"]
        sizes += [p["estimate"] for p in found["candidates"][0]["parameters"] if p["name"] == "z_out_act_n"]
    assert np.mean(sizes) == pytest.approx(SHIFT_N, rel=0.2)


@pytest.mark.slow
def test_a_model_that_leaves_only_noise_carries_no_map():
    found = run(record({}, 4), OPTIONS)
    assert all(np.abs(s.mean_n).max() < 0.02 and max(s.sd_n) < 0.02 for s in found.model().misfits)


def test_direction_and_distance_since_the_last_reversal():
    way, since = turning(np.array([0.0, 1.0, 2.0, 3.0, 2.0, 1.0, 2.0, 3.0]))
    assert way.tolist() == [1, 1, 1, 1, -1, -1, 1, 1]
    assert since.tolist() == [0, 1, 2, 3, 1, 2, 1, 2]
