"""An output that rests at one level in all runs: friction would leave it at several."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from identification_slips import rig

from sstl_cli.identification import gate


def resting(levels: list[float]):
    """Return the runs of a rig whose outputs are noise about so many levels (N), in turn."""
    made = []
    for i, r in enumerate(rig()):
        rng = np.random.default_rng(i)
        made.append(replace(r, tension_out_n=levels[i % len(levels)] + 0.02 * rng.standard_normal(len(r))))
    return made


@pytest.mark.parametrize("level", [4.0, 8.0])
def test_an_output_at_one_level_in_all_runs_is_dead_though_friction_could_hold_each_of_them(level):
    runs = resting([level])
    found = [r for r in gate.remarks(runs) if r.rule == "dead"]
    assert [set(r.run_ids) for r in found] == [{r.run_id for r in runs}] and found[0].severity == "remark"
    high, low = max(float(r.tension_in_n.max()) for r in runs), min(float(r.tension_in_n.min()) for r in runs)
    assert f"stays at {level:g} N in every run" in found[0].sentence and "not connected" in found[0].sentence
    # what lets nothing through holds the output between the input's extremes over what friction takes
    assert f"n theta {np.log(max(high / level, level / low)):.2g} " in found[0].sentence


def test_outputs_in_backlash_rest_where_each_of_them_was_moved_to_last():
    assert not [r for r in gate.remarks(resting([4.0, 5.0, 7.0])) if r.rule == "dead"]
