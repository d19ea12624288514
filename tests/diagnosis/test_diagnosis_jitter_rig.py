"""A rig whose clock jitters without its stamps saying so: nothing of it is missing."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from rig_logs import record

from sstl_cli.diagnosis.gathering import gather
from sstl_cli.diagnosis.question import Question
from sstl_cli.diagnosis.records import prepare


def jittered(share):
    """Return a sound log of a rig whose instants are off by a share of a period, and stamped as if they were not."""
    found = []
    for i, r in enumerate(record({}, seed=5, hz=50.0)):
        at = r.time_s + share * r.dt_s * np.random.default_rng(i).standard_normal(len(r))
        read = {k: np.interp(at, r.time_s, getattr(r, k)) for k in ("tension_in_n", "tension_out_n")}
        noise = {k: 0.005 * np.random.default_rng((i, j)).standard_normal(len(r)) for j, k in enumerate(read)}
        found.append(replace(r, **{k: read[k] + noise[k] for k in read}))
    return found


@pytest.mark.slow
def test_nothing_is_missing_of_a_rig_whose_clock_jitters_unseen():
    late = prepare(jittered(0.08)).records[0]
    assert 0.5 * 0.08 < late.jitter_s / late.dt_s < 1.2 * 0.08
    assert prepare(jittered(0.0)).records[0].jitter_s == 0.0
    found = gather(jittered(0.08), Question(max_effects=1, workers=1))
    # without it several effects gain a hundred nats
    assert max(c.evidence for c in found.rows.candidates) < 8.0
    assert found.rows.log.base_chi2 < 1.2
