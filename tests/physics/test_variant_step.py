"""`simulate --simulator variant`: laws from the scenario or the seed, the same for all runs of a rig."""

from __future__ import annotations

import tomllib

import numpy as np
import pytest

from sstl_cli.core.config import parse
from sstl_cli.core.errors import SstlError
from sstl_cli.physics.scenario import Scenario
from sstl_cli.physics.scenario_file import dump
from sstl_cli.steps import simulate

TEXT = """
schema = "sstl.scenario/1"
simulator = "variant"
sampling_hz = 50.0

[noise]
white_n = 0.0

[laws]
viscous = "eyring"

[[configurations]]
id = "a"
location = "CP"
theta = 0.5

[[configurations]]
id = "b"
location = "ND"
theta = 0.4

[[trajectories]]
kind = "ramp_hold"
duration_s = 10.0
record_position = true
"""


def scenario(**changes: object) -> Scenario:
    return parse(Scenario, tomllib.loads(TEXT), "laws.toml").model_copy(update=changes)


def test_laws_are_written_back_and_used() -> None:
    given = scenario()
    assert parse(Scenario, tomllib.loads(dump(given)), "again.toml") == given
    effects = {"viscous": {"c_l_n_s_per_mm": 0.05}}
    outs = {}
    for law in ("eyring", "curvature"):
        outs[law] = np.concatenate([r.tension_out_n for r in simulate.run(scenario(laws={"viscous": law}), effects, 1)])
    again = np.concatenate([r.tension_out_n for r in simulate.run(given, effects, 1)])
    assert np.array_equal(again, outs["eyring"])
    assert not np.array_equal(again, outs["curvature"])


def test_drawn_law_is_the_same_for_all_runs_and_differs_between_seeds() -> None:
    effects = {"zero_offset": {"z_out_act_n": 1.0}}

    def readings(seed: int) -> tuple[float, float]:
        runs = [r for r in simulate.run(scenario(laws={}), effects, seed) if r.system == "act"]
        bare = [r for r in simulate.run(scenario(laws={}), {}, seed) if r.system == "act"]
        first, second = (float(np.ptp(r.tension_out_n - b.tension_out_n)) for r, b in zip(runs, bare, strict=True))
        return first, second

    # a preload is constant in a run, a zero that returns late is not
    kinds = set()
    for seed in range(6):
        first, second = readings(seed)
        assert (first < 1e-9) == (second < 1e-9)
        kinds.add(first < 1e-9)
    assert kinds == {True, False}


def test_unknown_law_is_refused_in_one_line() -> None:
    with pytest.raises(SstlError, match="did you mean 'eyring'") as caught:
        list(simulate.run(scenario(laws={"viscous": "eyrin"}), {}, 1))
    assert caught.value.code == "E720"
