"""Where the noise enters: a small constant friction, in noise that the release slides of the sensing loop amplify."""

from __future__ import annotations

from functools import cache

import numpy as np
from rig_logs import record, scenario

from sstl_cli.diagnosis import search
from sstl_cli.diagnosis.records import prepare
from sstl_cli.diagnosis.simulator import Simulator
from sstl_cli.diagnosis.where import phases

WHITE_N = 0.04
# leaves 1.2 times the noise after theta is tuned
FRICTION_N = 0.062
NOMINAL = np.array([0.45, 0.62])


@cache
def found():
    problem = prepare(record({"const_friction": {"w_l_n": FRICTION_N}}, seed=4, white=WHITE_N, hz=100.0))
    sim = Simulator(problem, scenario().rig.mechanics())
    return search.run(sim, ["const_friction", "viscous", "asymmetric_friction", "zero_offset"], NOMINAL, 1)


def gap_n(fit):
    """RMS (N) at the analysis rate of what a fit leaves."""
    return float(np.sqrt(np.mean(fit.residual**2)))


def test_the_case_is_the_one_meant_a_gap_of_1_2_times_the_noise_that_friction_takes_away():
    base, true = found().base, found().best(("const_friction",)).fit
    own = np.sqrt(gap_n(base) ** 2 - gap_n(true) ** 2)
    assert 0.8 < own / WHITE_N < 1.6
    assert gap_n(true) < 0.9 * gap_n(base)


def test_constant_friction_is_before_what_fits_the_amplified_noise():
    ranked = [w.ids[0] for w in found().ranked()]
    true, rival = found().best(("const_friction",)), found().best(("viscous",))
    assert ranked[0] == "const_friction"
    assert true.evidence > 20.0 and true.evidence - rival.evidence > 20.0


def test_release_slides_of_the_sensing_loop_carry_no_more_evidence_than_they_can():
    sim, true, rival = found().sim, found().best(("const_friction",)).fit, found().best(("viscous",)).fit
    code = phases(sim, true.prediction)
    sensing = np.concatenate([np.full(len(r), r.system == "sstl") for r in sim.problem.records])
    there = sensing & (code == 3) & (sim.weight > 0)
    z = true.whiten(true.residual)[there]
    # chi^2 of the truth in them is one, within what so many samples scatter
    assert there.sum() > 50
    assert abs(np.mean(z**2) - 1.0) < 4.0 * np.sqrt(2.0 / there.sum())
    # and what is left of viscous drag wins nothing there that the whole would have to pay for
    won = 0.5 * float(z @ z - np.sum(rival.whiten(rival.residual)[there] ** 2))
    assert won < 10.0
