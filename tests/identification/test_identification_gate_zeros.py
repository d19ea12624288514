"""A zero that was taken anew before one run is told; lines that anything else bends to one side are not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from identification_loops import play, trapezoid
from identification_slips import lines, rig

from sstl_cli.core.runs import Run
from sstl_cli.identification import gate

# of friction on every bend: on a slight one lines tell no zero
FACTOR = 1.2


def loaded(run_id="act-b050", added_n=0.0):
    """Return a log of three bends, the output of one run of which reads more by ``added_n`` (a number, or one for each sample)."""
    return [replace(r, tension_out_n=r.tension_out_n + added_n) if r.run_id == run_id else r for r in rig(FACTOR)]


def zeros(evidence):
    return [r for r in gate.judge(evidence) if r.rule == "zero"]


def test_a_zero_that_friction_needs_as_well_is_told():
    (said,) = zeros([gate.evidence_of(r) for r in loaded(added_n=1.2)])
    assert said.run_ids == ("act-b050",) and said.number == pytest.approx(1.2, abs=0.1) and "tared) before this run" in said.sentence


def test_lines_apart_are_no_zero_where_friction_explains_the_run():
    """Presliding bends the lines of a part of a loop to one side, and the samples hold no zero."""
    evidence = [gate.evidence_of(r) for r in loaded()]
    bent = [
        replace(e, slopes=replace(e.slopes, beta_p=e.slopes.beta_p + 1.2, beta_r=e.slopes.beta_r + 1.3)) if e.run_id == "act-b050" else e
        for e in evidence
    ]
    assert zeros(bent) == []


@pytest.mark.parametrize("by_n", [4.0, 3.0])
def test_a_zero_that_goes_along_one_run_is_told(by_n):
    along = np.linspace(0.0, by_n, len(rig(FACTOR)[0]))
    (said,) = zeros([gate.evidence_of(r) for r in loaded(added_n=along)])
    assert (
        said.run_ids == ("act-b050",)
        and said.number == pytest.approx(by_n, rel=0.1)
        and "from the first sample to the last" in said.sentence
    )


def test_a_zero_that_goes_along_all_runs_is_the_rigs():
    along = np.linspace(0.0, 3.2, len(rig(FACTOR)[0]))
    runs = [replace(r, tension_out_n=r.tension_out_n + (1.0 if r.run_id == "act-b050" else 0.7) * along) for r in rig(FACTOR)]
    assert not [r for r in zeros([gate.evidence_of(r) for r in runs]) if "first sample" in r.sentence]


def test_all_runs_of_a_sensor_that_hold_its_zero_are_named():
    def driven(name, high, zero_n, seed):
        t, x = trapezoid(2.0, high, rate=50.0, cycles=3)
        noise = 0.02 * np.random.default_rng(seed).standard_normal((2, len(t)))
        return Run(name, "sstl", t, x + noise[0], play(x, lines(0.8)) + noise[1] + zero_n, config_id="a", trajectory=name)

    # of a strong movement 3 N are a small part, not told by themselves
    log = [driven("strong", 90.0, 3.0, 1), driven("other", 80.0, 0.0, 2)]
    assert not [r for r in gate.remarks(log) if "strong" in r.run_ids]
    (said,) = [r for r in gate.remarks([driven("weak", 26.0, 3.0, 3), *log]) if r.rule == "zero"]
    assert set(said.run_ids) == {"weak", "strong"} and said.number == pytest.approx(3.0, abs=0.1)
