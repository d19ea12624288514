"""A run without which the verdict differs is named; a limit on time leaves whole stages out and says which."""

from __future__ import annotations

import json
from copy import copy
from dataclasses import replace

import numpy as np
import pytest
from made_fits import NOTHING, THETA, noise, simulator
from rig_logs import SHORT, record, theta_jump
from typer.testing import CliRunner

from sstl_cli.api.diagnosis import diagnose as ask
from sstl_cli.api.log import Log
from sstl_cli.cli.app import _register, app
from sstl_cli.core.documents.diagnosis import DiagnosisDocument, Gap
from sstl_cli.core.documents.diagnosis import Verdict as Told
from sstl_cli.core.files import dumps
from sstl_cli.core.provenance import Provenance
from sstl_cli.core.runs import write_runs
from sstl_cli.diagnosis import gathering, odd
from sstl_cli.diagnosis.constants import CONFIRMED_RUNS
from sstl_cli.diagnosis.evidence import weigh
from sstl_cli.diagnosis.features import OUTPUT, CandidateRow, LogRow, Rows
from sstl_cli.diagnosis.fit import fit
from sstl_cli.diagnosis.found import Search
from sstl_cli.diagnosis.hypotheses import full
from sstl_cli.diagnosis.residuals import Leftover, Misfit
from sstl_cli.diagnosis.sentence import lines
from sstl_cli.diagnosis.simulator import Simulator
from sstl_cli.diagnosis.verdict import AMBIGUOUS, IDENTIFIED, UNDECIDED, Verdict
from sstl_cli.diagnosis.verdict import NOTHING as NONE
from sstl_cli.diagnosis.whitening import white
from sstl_cli.steps import diagnose
from sstl_cli.steps.diagnose import DiagnoseOptions

FEW = ("pulley_friction", "const_friction", "gain_error", "zero_offset")
OPTIONS = DiagnoseOptions(effects=FEW, max_effects=1, workers=2, odd_runs=True)
CALM = Leftover(8000, 1.0, 0.0, 0.0, 0.0, (Misfit("mean by run", 0.5, 0.3, ""),))
LOG = LogRow(8000, 1, 2, 1.0, 1.0, 0.5, 1.0, 1.0, 0.5, 0.0, 0.0, 0.0, 0.0, 0.3, 1.0, 1.0)
PLACE = 2


def row(worst: float = 100.0) -> CandidateRow:
    return CandidateRow(("zero_offset",), OUTPUT, 1, 10.0, 5.0, 5.0, 1.5, worst, 80.0, 0, 1.0, 0.5)


def searched(left: np.ndarray, keep: np.ndarray | None = None) -> Search:
    """Return base and offset fitted to the records of ``made_fits`` with this residual, or to some of their samples."""
    whole = simulator()
    runs = range(len(whole.problem.records)) if keep is None else np.unique(whole.run[keep])
    sim = (
        whole if keep is None else Simulator(replace(whole.problem, records=tuple(whole.problem.records[i] for i in runs)), whole.mechanics)
    )
    sim = copy(sim)
    sim.y = sim.predict(THETA, {}) + (left if keep is None else left[keep])
    whiten = white(0.02, sim.weight, [s.start for s in sim.slices()])
    base = fit(sim, whiten, NOTHING, THETA, np.zeros(0))
    h = full("zero_offset", sim.problem.systems)
    single = weigh(sim, fit(sim, whiten, h, THETA, np.zeros(len(h.free))), base)
    return Search(sim, None, None, base, {"zero_offset": (single,)}, {})  # type: ignore[arg-type]


def test_rows_without_a_run_are_those_of_a_fit_without_it():
    sim = simulator()
    left = noise() + 0.03 * (sim.run == PLACE) + 0.005
    found = searched(left)
    rows = odd.rows_without(found, Rows(LOG, (row(),), CALM, CALM), lambda _: ())
    for i, less in enumerate(rows):
        single = searched(left, sim.run != i).singles["zero_offset"][0]
        (c,) = less.candidates
        assert c.gain == pytest.approx(single.gain, abs=2.0)
        assert c.evidence == pytest.approx(single.evidence, abs=2.0)
        z = single.fit.whiten(single.fit.residual)
        assert c.chi2 == pytest.approx(float(z @ z) / len(z), rel=1e-3)
    # what one run alone leaves goes with it, what all leave stays
    worst = [r.candidates[0].worst_z for r in rows]
    assert worst[PLACE] < 0.2 * min(w for i, w in enumerate(worst) if i != PLACE)
    assert rows[0].log.samples < LOG.samples


def test_candidates_beside_the_output_are_those_without_the_run():
    asked = []
    odd.rows_without(searched(noise()), Rows(LOG, (row(),), CALM, CALM), lambda i: asked.append(i) or ())
    assert asked == [0, 1, 2, 3]


def said(status: str, *effects: str) -> Verdict:
    return Verdict(status, effects, None, (effects,), {effects: 1.0}, "")


def test_suspects_are_runs_whose_absence_changes_the_verdict_the_largest_change_first():
    whole = said(IDENTIFIED, "viscous")
    half = replace(said(NONE), probabilities={("viscous",): 0.4, (): 0.6})
    then = {1.0: said(IDENTIFIED, "viscous"), 2.0: half, 3.0: said(AMBIGUOUS, "viscous"), 4.0: said(NONE)}
    rows = [Rows(replace(LOG, base_chi2=k), (), CALM, CALM) for k in then]
    found = odd.suspects(whole, Rows(LOG, (), CALM, CALM), "abcd", rows, lambda r: then[r.log.base_chi2])
    assert [s.run_id for s in found] == ["d", "b", "c"]  # c: told apart no longer, as probable as before


def test_who_holds_most_of_an_unknown_rest_is_a_suspect_whatever_its_rows_say():
    unknown = said(UNDECIDED)
    rows = [Rows(LOG, (row(worst),), CALM, CALM) for worst in (99.0, 40.0)]
    found = odd.suspects(unknown, Rows(LOG, (row(100.0),), CALM, CALM), "ab", rows, lambda _: unknown)
    assert [s.run_id for s in found] == ["b"]
    identified = said(IDENTIFIED, "viscous")
    assert odd.suspects(identified, Rows(LOG, (row(100.0),), CALM, CALM), "ab", rows, lambda _: identified) == []


@pytest.fixture(scope="module")
def runs():
    """Two bends, two movements, both systems."""
    return record({}, 5, moves=SHORT[1:])


def spoilt(runs, how):
    return [how(r) if i == PLACE else r for i, r in enumerate(runs)]


def shifted(runs):
    return spoilt(runs, lambda r: replace(r, tension_out_n=r.tension_out_n + 0.4))


@pytest.mark.parametrize(
    "how",
    [
        pytest.param(lambda r: replace(r, tension_out_n=r.tension_out_n + 0.4), id="offset", marks=pytest.mark.slow),
        pytest.param(lambda r: theta_jump([r])[0], id="moved", marks=pytest.mark.slow),
    ],
)
def test_the_run_that_alone_has_a_gap_is_named(runs, how):
    found = diagnose.run(spoilt(runs, how), OPTIONS)
    document = found.document()
    odd_run = {"run_id": runs[PLACE].run_id, "status": "none", "effects": []}
    assert document["verdict"]["status"] != "none" and document["verdict"]["odd_runs"] == [odd_run]
    assert f"  without run {runs[PLACE].run_id}: nothing is missing" in lines(found.body)
    assert DiagnosisDocument.model_validate(json.loads(dumps(document))).verdict.odd_runs


@pytest.mark.slow
def test_no_run_is_odd_where_all_are_alike_and_nothing_is_diagnosed_again(runs, monkeypatch):
    calls = []
    real = gathering.gather
    monkeypatch.setattr(gathering, "gather", lambda *a, **b: calls.append(a) or real(*a, **b))
    assert diagnose.run(runs, OPTIONS).document()["verdict"]["odd_runs"] == [] and len(calls) == 1


@pytest.mark.slow
def test_few_runs_are_confirmed_and_the_confirmation_asks_for_no_more(runs, monkeypatch):
    calls = []
    real = gathering.gather
    monkeypatch.setattr(gathering, "gather", lambda *a, **b: calls.append(a) or real(*a, **b))
    every = [odd.Suspect(r.run_id, 0.5) for r in runs]
    monkeypatch.setattr(odd, "suspects", lambda *_: every)
    # whoever is left out, the others still say the same
    assert diagnose.run(runs, OPTIONS).document()["verdict"]["odd_runs"] == []
    assert [len(a[0]) for a in calls] == [len(runs), *[len(runs) - 1] * CONFIRMED_RUNS]


@pytest.mark.slow
def test_of_two_runs_none_is_odd_and_nobody_looks_unless_asked(runs):
    assert diagnose.run(runs[:2], OPTIONS).document()["verdict"]["odd_runs"] is None
    assert diagnose.run(runs[:3], replace(OPTIONS, odd_runs=False)).document()["verdict"]["odd_runs"] is None


def test_a_verdict_of_several_effects_reads_as_one_line():
    odd_runs = [
        {"run_id": "f001", "status": "identified", "effects": ["zero_offset"]}, {"run_id": "f002", "status": "unknown", "effects": []},
        {"run_id": "f003", "status": "ambiguous", "effects": ["viscous", "zero_drift"]},
    ]  # fmt: skip
    verdict = Told(status="none", effects=[], confidence=None, ambiguity_group=[], why="", odd_runs=odd_runs)
    document = DiagnosisDocument.model_construct(
        verdict=verdict, gap=Gap.model_construct(rmse_base_n=0.1, rmse_retuned_n=0.1, noise_floor_n=0.1), where=[]
    )
    assert lines(document)[-3:] == [
        "  without run f001: zero_offset", "  without run f002: the cause is not known",
        "  without run f003: most likely viscous + zero_drift, but not for sure",
    ]  # fmt: skip


@pytest.mark.slow
@pytest.mark.slow
def test_after_the_limit_singles_are_still_fitted_and_the_rest_is_said_to_be_left_out(runs):
    found = diagnose.run(shifted(runs), replace(OPTIONS, max_effects=3, max_seconds=0.0))
    document = found.document()
    assert set(found.evidence.search.singles) == set(FEW) and not found.evidence.search.combined
    assert document["verdict"]["odd_runs"] is None and document["next_experiment"] is None
    (note,) = [n for n in document["notes"] if n.startswith("left out")]
    assert note.startswith("left out after 0 s: pairs, triples") and note.endswith("odd runs")
    assert f"  note: {note}" in lines(found.body)


@pytest.mark.slow
def test_time_that_runs_out_between_the_stages_keeps_what_is_done(runs, monkeypatch):
    class Late(diagnose.Deadline):
        """Over after the pairs."""

        def passed(self, stage: str) -> bool:
            if stage != "pairs":
                self.left_out.append(stage)
            return stage != "pairs"

    monkeypatch.setattr(diagnose, "Deadline", Late)
    pulley = record({"pulley_friction": {"m_p": 0.03}, "zero_offset": {"z_out_act_n": 0.3}}, 5, moves=SHORT[1:])
    found = diagnose.run(pulley, replace(OPTIONS, max_effects=3, max_seconds=60.0))
    assert {len(k) for k in found.evidence.search.combined} == {2}
    # the next experiment is asked for where the verdict leaves something open
    notes = found.document()["notes"]
    assert any(n in notes for n in (f"left out after 60 s: triples, {x}downstream, odd runs" for x in ("", "next experiment, ")))


@pytest.mark.slow
def test_time_enough_leaves_nothing_out(runs):
    assert not [n for n in diagnose.run(runs[:4], replace(OPTIONS, max_seconds=600.0)).document()["notes"] if "left out" in n]


@pytest.mark.slow
def test_command_and_function_take_the_limit_and_look_for_odd_runs(runs, tmp_path):
    _register()
    path = tmp_path / "log.parquet"
    write_runs(path, shifted(runs), Provenance("test"))
    words = ["diagnose", str(path), "--effects", ",".join(FEW), "--max-effects", "1", "--json"]
    document = json.loads(CliRunner().invoke(app, words).stdout)
    assert [r["run_id"] for r in document["verdict"]["odd_runs"]] == [runs[PLACE].run_id]
    shown = CliRunner().invoke(app, [*words[:-1], "--max-seconds", "0"]).stdout
    assert "left out after 0 s" in shown and "without run" not in shown
    found = ask(Log(tuple(runs)), effects=FEW, max_effects=1, max_seconds=0.0)
    assert any("left out after 0 s" in n for n in found.document.notes) and found.verdict.odd_runs is None
