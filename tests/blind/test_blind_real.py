"""Diagnosing back: recordings remade from an accepted model, with the diagnosis replaced by known answers."""

import numpy as np
import pytest

from sstl_cli.blind import accepted
from sstl_cli.core.documents.diagnosis import DiagnosisDocument, Gap, Verdict
from sstl_cli.core.errors import SstlError
from sstl_cli.core.runs import Run
from sstl_cli.physics.scenario import Configuration, Scenario
from sstl_cli.steps import blind_real

THETA = 0.45


def recording(offset=0.0, noise=0.02, seed=0):
    rng = np.random.default_rng(seed)
    t = np.arange(4000) / 100.0
    u = 12 - 9 * np.cos(2 * np.pi * 0.1 * t)
    y, out = 3.0, []
    for x in u:
        y = min(max(y, np.exp(-THETA) * x), np.exp(THETA) * x)
        out.append(y)
    y = np.array(out) + offset
    return Run("r1", "act", t, u + noise * rng.standard_normal(4000), y + noise * rng.standard_normal(4000), "A", "CP")


def scenario(**effects):
    return Scenario(configurations=(Configuration(id="A", location="CP", theta=THETA),), effects=effects)


def test_error_of_the_right_model_is_the_noise():
    run = recording(offset=0.5)
    right = scenario(zero_offset={"z_out_act_n": 0.5})
    assert accepted.rms_n(right, [run]) == pytest.approx(0.02, rel=0.4)
    shrink = accepted.realised_shrink_pct(scenario(), right, [run])
    assert shrink == pytest.approx(100 * (1 - 0.02 / 0.5), abs=2.0)


def test_remade_recordings_carry_the_model_and_real_residuals():
    run = recording()
    full = scenario(zero_offset={"z_out_act_n": 0.8})
    (made,) = accepted.remade(full, scenario(), [run], 4)
    n = len(made)
    np.testing.assert_allclose(made.tension_in_n, run.tension_in_n[:n], atol=1e-9)
    off = made.tension_out_n - run.tension_out_n[:n]
    assert off.mean() == pytest.approx(0.8, abs=0.02)
    assert off.std() == pytest.approx(0.02 * np.sqrt(2), rel=0.3)
    (again,) = accepted.remade(full, scenario(), [run], 4)
    np.testing.assert_array_equal(made.tension_out_n, again.tension_out_n)


def test_retuned_keeps_names_and_takes_theta():
    found = accepted.retuned(scenario(), {"A": 0.6, "B": 0.1})
    assert [c.theta for c in found.configurations] == [0.6]


def answering(seen):
    """A diagnosis that names an offset wherever the mean error of the stated simulator shows one."""

    def diagnose(runs, sim, exclude):
        error = np.mean([np.mean(r.y_fine - p) for r, p in accepted.predictions(sim, runs)])
        seen.append(float(error))
        named = ["zero_offset"] if abs(error) > 0.1 else []
        verdict = Verdict(status="identified" if named else "none", effects=named, ambiguity_group=named, confidence=0.9, why="")
        return DiagnosisDocument.model_construct(verdict=verdict, gap=Gap.model_construct(shrink_pct=50.0)), scenario(
            zero_offset={"z_out_act_n": 0.5}
        )

    return diagnose


def test_an_accepted_term_is_taken_out_and_named():
    seen = []
    found = blind_real.run([recording(offset=0.5)], diagnoser=answering(seen))
    assert [r.taken_out for r in found.trials] == [None, "zero_offset"]
    assert (found.named, found.of, found.false_alarm) == (1, 1, False)
    assert seen[2] == pytest.approx(0.5, abs=0.05)


def test_a_planted_term_has_the_wanted_strength():
    seen = []
    found = blind_real.run([recording()], scenario(), ["zero_offset", "const_friction"], strength=10.0, diagnoser=answering(seen))
    assert [r.taken_out for r in found.trials] == [None, "zero_offset", "const_friction"]
    assert found.of == 2 and found.wrong <= 1
    assert found.trials[1].values


def test_recorder_faults_cannot_be_planted():
    with pytest.raises(SstlError, match="E957"):
        blind_real.run([recording()], scenario(), ["quantisation"], diagnoser=answering([]))
