"""What models may remove of what was held out, and how a candidate and a log are counted, by hand."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from made_fits import simulator
from scipy.stats import t as student

from sstl_cli.diagnosis import features
from sstl_cli.diagnosis.constants import BLOCK_S, DECIDES_NATS
from sstl_cli.diagnosis.features import CandidateRow, LogRow, Rows, best_of, leading
from sstl_cli.diagnosis.residuals import Leftover

SIM = simulator()
BLOCKS = int(40.0 / BLOCK_S) * 4
RNG = np.random.default_rng(14)
CALM = Leftover(100, 1.0, 0.0, 0.0, 0.0, ())


def model(name, residual, gain=10.0, foretold=True):
    fit = SimpleNamespace(ids=(name,), residual=residual, hypothesis=SimpleNamespace(foretold=foretold))
    return SimpleNamespace(ids=(name,), fit=fit, gain=gain)


def search(base, scatters=False, honest=True):
    """Return a search whose models leave of held-out data what they leave of all."""
    problem = SimpleNamespace(records=SIM.problem.records, scatters=scatters)
    sim = SimpleNamespace(problem=problem, weight=SIM.weight, run=SIM.run, y=SIM.y)
    held = SimpleNamespace(
        folds=SimpleNamespace(honest=honest), residual=lambda f: f.residual, nats=lambda f: 0.5 * float(f.residual @ f.residual)
    )
    return SimpleNamespace(sim=sim, held_out=held, base=SimpleNamespace(residual=base))


def test_a_model_may_remove_of_the_gap_over_blocks_what_its_student_limit_says():
    base, left = RNG.standard_normal((2, 8000)) * [[2.0], [1.0]]
    # of a mean square of 4 N^2 3 N^2 are reducible
    floor = float(np.mean(base**2)) - 3.0
    a, b = (np.array([np.sum(x[k * 250 : (k + 1) * 250] ** 2) for k in range(BLOCKS)]) for x in (base, left))
    gap, removed = a - 250.0 * floor, a - b
    share = removed.sum() / gap.sum()
    # of a ratio of sums over blocks: residuals about it, over the sum below
    error = np.sqrt(np.sum((removed - share * gap) ** 2) * BLOCKS / (BLOCKS - 1)) / gap.sum()
    expected = share + student.ppf(0.975, BLOCKS - 1) * error
    found = features._held(search(base), [model("a", left), model("b", base), model("c", left, foretold=False)], 3.0)
    assert found == {("a",): pytest.approx(expected), ("b",): pytest.approx(0.0)}
    assert 0.9 < share < 1.1 and error > 0.002
    # where nothing is reducible the limit is none
    assert features._held(search(base), [model("a", left)], -0.1)[("a",)] == float("inf")
    # more than all that is left cannot be reducible: the noise is not below nothing
    more = features._held(search(base), [model("a", left)], 9.0)[("a",)]
    ratio = (a - b).sum() / a.sum()
    spread = np.sqrt(np.sum((a - b - ratio * a) ** 2) * BLOCKS / (BLOCKS - 1)) / a.sum()
    assert more == pytest.approx(ratio + student.ppf(0.975, BLOCKS - 1) * spread)


def test_where_nothing_new_is_held_out_nothing_is_said_and_beside_known_scatter_it_is_gain_that_is_kept():
    base, left = np.full(8000, 0.1), np.full(8000, 0.05)
    assert features._held(search(base, honest=False), [model("a", left)], 1.0) == {}
    # 40 nats as the base leaves it, 10 as the model does
    found = features._held(search(base, scatters=True), [model("a", left, gain=60.0), model("b", base), model("c", left, gain=0.1)], 1.0)
    assert found == {("a",): pytest.approx(0.5), ("b",): 0.0, ("c",): pytest.approx(30.0)}


def row(*ids, kind=features.OUTPUT, evidence=5.0):
    return CandidateRow(ids, kind, 1, evidence, evidence, evidence, 1.0, 0.0, 0.0, 0, 1.0, 0.5)


def log(**more):
    return LogRow(100, 1, 1, *([1.0] * 13), **more)


def test_the_leading_model_is_one_of_the_output_that_is_more_evident_than_the_base():
    rows = Rows(log(), (row("a"), row("b", evidence=7.0), row("c", kind=features.RECORDER, evidence=99.0)), CALM, CALM)
    assert leading(rows).ids == ("b",) and best_of(rows) == 7.0
    none = Rows(log(), (row("a", evidence=0.0), row("c", kind=features.BESIDE, evidence=99.0)), CALM, CALM)
    assert leading(none) is None and best_of(none) == 0.0


def test_what_is_barred_is_among_the_rows_but_not_among_the_named():
    rows = Rows(log(), (row("a"), row("a", "x"), row("b")), CALM, CALM, barred={"x": "something"}, scatters=True)
    assert [c.ids for c in rows.named.candidates] == [("a",), ("b",)] and rows.named.barred == {} and rows.named.scatters


def test_an_output_rests_where_the_evidence_for_it_decides():
    assert not log().rests and not log(jumps=DECIDES_NATS).rests and log(jumps=1.01 * DECIDES_NATS).rests


def test_samples_count_by_the_scatter_s_share_of_what_is_left():
    # half of the variance is a scatter that lasts three steps: of two alike one is new, three times over
    record = SimpleNamespace(
        system="act", weight=np.ones(100), misfit_n=np.full(100, 0.3), misfit_s=0.3, dt_s=0.05, factor=2, readings=np.full(100, 2.0)
    )
    noise = SimpleNamespace(output={"act": SimpleNamespace(white_n=0.3 * np.sqrt(2.0))})
    found = SimpleNamespace(sim=SimpleNamespace(problem=SimpleNamespace(records=[record])), noise=noise)
    assert features._independent(found, 700) == round(700 / (1.0 + 0.5 * (2.0 * 3.0 - 1.0)))
    record.weight[50:] = 0.0
    assert features._independent(found, 700) == 200 and features._independent(found, 1) == 1
