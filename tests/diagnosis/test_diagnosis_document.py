"""The document: exact shares, intervals, contract fields, the same for any number of workers."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from rig_logs import record

from sstl_cli.cli import _gates
from sstl_cli.core.documents.diagnosis import DiagnosisDocument
from sstl_cli.core.errors import SstlError
from sstl_cli.core.files import dumps
from sstl_cli.core.runs import Run
from sstl_cli.identification import gate
from sstl_cli.physics.scenario import load
from sstl_cli.steps.diagnose import DiagnoseOptions, run

PULLEY = {"pulley_friction": {"m_p": 0.06, "m_r": 0.05}}
OPTIONS = DiagnoseOptions(max_effects=1, effects=("pulley_friction", "asymmetric_friction", "gain_error", "zero_offset"))


@pytest.fixture(scope="module")
def runs():
    return record(PULLEY, hz=25.0)


@pytest.fixture(scope="module")
def diagnosis(runs):
    return run(runs, OPTIONS)


def test_shares_sum_to_100(diagnosis):
    document = diagnosis.document()
    assert sum(row["share_pct"] for row in document["where"]) == pytest.approx(100.0, abs=1e-9)
    for rows in document["where_bands"].values():
        assert sum(row["share_pct"] for row in rows) == pytest.approx(100.0, abs=1e-6)


def test_the_gap_shrinks_from_as_given_to_floor(diagnosis):
    gap = diagnosis.document()["gap"]
    assert gap["rmse_base_n"] >= gap["rmse_retuned_n"] > gap["rmse_with_effect_n"] >= gap["noise_floor_n"]
    low, high = gap["shrink_ci95_pct"]
    assert low <= gap["shrink_pct"] <= high
    assert gap["noise_floor_n"] == pytest.approx(0.02, rel=0.25)
    assert gap["noise_floor_low_n"] < gap["noise_floor_n"] < gap["noise_floor_high_n"]
    assert gap["noise_floor_low_n"] < 0.02 * 1.05 and gap["noise_floor_high_n"] > 0.02
    assert gap["held_out"] is True


def test_parameters_cover_the_truth(diagnosis):
    best = diagnosis.document()["candidates"][0]
    assert best["id"] == "pulley_friction"
    found = {p["name"]: p for p in best["parameters"]}
    for name, value in PULLEY["pulley_friction"].items():
        assert abs(found[name]["estimate"] - value) < 0.003
        assert found[name]["ci95"][0] < found[name]["ci95"][1]


def test_probabilities_of_what_is_said_and_of_all_candidates_sum_to_one(diagnosis):
    document = diagnosis.document()
    verdict = document["verdict"]
    total = sum(c["probability"] for c in document["candidates"])
    assert total + verdict["probability_none"] + verdict["probability_unknown"] == pytest.approx(1.0)
    ranked = [c["probability"] for c in document["candidates"]]
    assert ranked == sorted(ranked, reverse=True)


def test_a_missing_interval_says_why(diagnosis):
    for candidate in diagnosis.document()["candidates"]:
        for p in candidate["parameters"]:
            assert (p["ci95"] is None) == bool(p["why"])
            assert p["ci95"] is None or p["ci95"][0] <= p["estimate"] <= p["ci95"][1]


def test_rivals_come_with_their_distance_and_the_noise_with_its_interval(diagnosis):
    document = diagnosis.document()
    first, *others = document["candidates"]
    assert first["d2"] is None and all(c["d2"] > 24.0 for c in others)
    white = document["analysis"]["noise"]["act"]["output"]["white_n"]
    assert "why" not in white and document["analysis"]["noise"]["act"]["input"]["white_n"]["ci95"] is None
    assert "differences" in document["analysis"]["noise"]["act"]["input"]["white_n"]["why"]
    assert white["ci95"][0] < white["estimate"] < white["ci95"][1]
    assert white["estimate"] == pytest.approx(0.02, rel=0.1)


def test_the_answer_does_not_depend_on_workers_or_order(runs, diagnosis):
    again = run(list(reversed(runs)), replace(OPTIONS, workers=3))
    assert dumps(again.document()) == dumps(diagnosis.document())


def test_the_accepted_model_explains_the_log(runs, diagnosis, tmp_path):
    from sstl_cli.physics.scenario_file import dump

    path = tmp_path / "rig.toml"
    path.write_text(dump(diagnosis.model()))
    closed = run(runs, replace(OPTIONS, sim=load(str(path)))).document()
    assert closed["verdict"]["status"] == "none"
    assert closed["gap"]["rmse_base_n"] < 1.2 * closed["gap"]["noise_floor_n"]


@pytest.mark.parametrize("keep", ["act", "sstl"])
def test_one_system_alone_works(runs, keep):
    document = run([r for r in runs if r.system == keep], OPTIONS).document()
    assert document["verdict"]["status"] in ("identified", "ambiguous", "none", "unknown")
    assert any(keep in note for note in document["notes"])
    if keep == "act":
        # the pulley does not show in the actuation tendon
        assert document["verdict"]["status"] == "none"


def flat(value=10.0, n=500, moving=None):
    t = np.arange(n) * 0.01
    x = np.full(n, value) if moving is None else moving(t)
    return Run("flat", "act", t, x, 0.5 * x)


def test_constant_input_is_an_error_not_a_guess():
    with pytest.raises(SstlError, match="input never changes"):
        run([flat()], DiagnoseOptions())


def test_too_short_is_an_error():
    with pytest.raises(SstlError, match="fewer than"):
        run([flat(n=50)], DiagnoseOptions())


def test_without_propagation_nothing_is_named():
    """Small movements inside the backlash: the output never moves, so no effect can show."""
    rng = np.random.default_rng(0)
    run_ = flat(n=4000, moving=lambda t: 10.0 + 1.0 * np.sin(t))
    held = Run("held", "act", run_.time_s, run_.tension_in_n + 0.01 * rng.standard_normal(4000), 10.0 + 0.01 * rng.standard_normal(4000))
    document = run([held], OPTIONS).document()
    assert document["verdict"]["status"] == "unknown" and "use a larger stroke" in document["verdict"]["why"]
    # a movement of the menu that tells two candidates apart is not what this log lacks
    assert document["next_experiment"] is None


@pytest.mark.slow
@pytest.mark.parametrize(
    ("effect", "values"),
    [
        ("acquisition_faults", {"spike_pct": 0.5, "spike_n": 5.0}),
        ("acquisition_faults", {"frozen_pct": 1.5}),
        pytest.param("saturation", {"t_max_out_n": 9.0}, marks=pytest.mark.slow),
        pytest.param("quantisation", {"q_out_n": 0.3}, marks=pytest.mark.slow),
    ],
)
def test_the_numbers_of_a_fault_of_the_recorder_are_of_the_same_readings(effect, values):
    options = replace(OPTIONS, effects=(*OPTIONS.effects, effect))
    runs = record({effect: values})
    document = run(runs, options).document()
    gap = document["gap"]
    # a limit that every run meets is told by the gate, and keeps no run from being asked for it
    assert {r.rule for r in gate.remarks(runs) if r.failed} == ({"limit"} if effect == "saturation" else set())
    assert all(r["severity"] == "remark" for r in document.get("remarks", [])) and ("limit" in str(document.get("remarks"))) == (
        effect == "saturation"
    )
    assert not document["analysis"]["set_aside"]
    assert document["verdict"]["effects"] == [effect] and gap["samples"] == "all as recorded"
    base, left, floor = gap["rmse_retuned_n"], gap["rmse_with_effect_n"], gap["noise_floor_n"]
    # what remains when the fault is taken out is the noise, not less; rounding hides most of its own
    assert 0.9 * floor <= left < 0.95 * base and base > 0.08
    # rounding hides the noise of the output, not that of the input, and never all of it
    assert floor > 0.005
    assert gap["shrink_pct"] == pytest.approx(100.0 * (1.0 - left / base))
    # the places are those of the same readings: their errors add up to the one that is told
    assert document["where_samples"] == gap["samples"]
    assert sum(r["share_pct"] for r in document["where"]) == pytest.approx(100.0)
    readings = sum(0.01 * r["share_pct"] / r["rmse_n"] ** 2 for r in document["where"])
    assert readings**-0.5 == pytest.approx(base, rel=1e-6)
    row = next(c for c in document["candidates"] if c["id"] == effect)
    assert row["shrink_pct"] == pytest.approx(gap["shrink_pct"])
    assert gap["explained_of_reducible_pct"] == pytest.approx(min(100.0 * (base - left) / (base - floor), 100.0), abs=0.1)
    # what other candidates leave of the readings that are sound does not compare, and each says what its numbers are of
    samples = {c["id"]: c["samples"] for c in document["candidates"]}
    assert samples.pop(effect) == gap["samples"] and set(samples.values()) == {"analysed"}
    rows = _gates.markdown(DiagnosisDocument.model_validate(document), [])
    assert "(all as recorded)" in rows and "(analysed)" in rows
