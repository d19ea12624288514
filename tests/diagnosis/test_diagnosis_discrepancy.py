"""What a model leaves, learned: what comes again, what does not, how sure that is, and how it jerks."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from made_fits import NOISE_N, THETA, made, noise, simulator

from sstl_cli.diagnosis import discrepancy, state
from sstl_cli.diagnosis.constants import INPUT_KNOTS, OTHER_KNOTS
from sstl_cli.diagnosis.discrepancy import learned
from sstl_cli.diagnosis.misfit import applied, beyond, known
from sstl_cli.diagnosis.whitening import Noise, Sensor

SIM = simulator()
NOISE = Noise({"act": Sensor(1e-4, 1e-6, 0.1)}, {"act": Sensor(NOISE_N, 1e-4, 0.1)}, {"act": 1.0})
PHASES = SIM.phases(THETA, {}, NOISE)


def scattered(seed, size_n, slow=20):
    """Return first-order noise of a standard deviation (N), alike over so many samples."""
    rng = np.random.default_rng(seed)
    kept = np.exp(-1.0 / slow)
    out = np.empty(len(SIM.y))
    at = 0.0
    for i, kick in enumerate(rng.standard_normal(len(out))):
        at = kept * at + np.sqrt(1.0 - kept**2) * kick
        out[i] = at
    return size_n * out


def pattern():
    """Return what comes again (N): a slope over the input while pulling, a constant while releasing."""
    u = np.concatenate([r.u for r in SIM.problem.records])
    way = np.concatenate([state.turning(r.u)[0] for r in SIM.problem.records])
    return np.where(way > 0, 0.02 * (u - 12.0), -0.1)


@pytest.fixture(scope="module")
def sections():
    return learned(SIM.problem, noise(3) + pattern() + scattered(2, 0.05), PHASES, NOISE)


def test_what_comes_again_is_mapped_and_what_does_not_is_scatter(sections):
    assert [s.config_id for s in sections] == ["a", "b"] and {s.along for s in sections} == {"turning"}
    assert {(len(s.input_n), len(s.other)) for s in sections} == {(INPUT_KNOTS, OTHER_KNOTS)}
    knowing = applied(SIM.problem, sections, 1.0)
    assert np.sqrt(np.mean((known(knowing) - pattern()) ** 2)) < 0.35 * np.std(pattern())
    for s in sections:
        assert np.median(s.sd_n) == pytest.approx(0.05, rel=0.35) and 0.1 < s.correlation_s < 1.2
        assert s.rate_n_s == pytest.approx(
            [max(np.max(w * r.rate) for r in SIM.problem.records if r.config == "ab".index(s.config_id)) for w in (1.0, -1.0)]
        )


def test_the_map_is_as_far_off_as_it_is_said_to_be(sections):
    knowing = applied(SIM.problem, sections, 1.0)
    off = known(knowing) - pattern()
    said = np.sqrt(np.concatenate([np.sum(r.wander.bend**2, axis=1) for r in knowing.records]))
    assert 0.5 < np.sqrt(np.mean((off / said) ** 2)) < 1.5


def test_what_was_left_is_white_by_what_was_learned(sections):
    left = replace(made(), residual=noise(3) + pattern() + scattered(2, 0.05))
    _, fitted = beyond(SIM, left, sections, NOISE, told=False)
    z = fitted.whiten(fitted.residual)
    assert np.mean(z**2) == pytest.approx(1.0, abs=0.15) and abs(np.mean(z[1:] * z[:-1])) < 0.1


def test_jerks_have_a_heavy_tail_and_do_not_make_the_scatter_larger(sections):
    rng = np.random.default_rng(5)
    jerks = np.where(rng.random(len(SIM.y)) < 0.01, 2.0 * rng.standard_normal(len(SIM.y)), 0.0)
    heavy = learned(SIM.problem, noise(3) + pattern() + scattered(2, 0.05) + jerks, PHASES, NOISE)
    for calm, wild in zip(sections, heavy, strict=True):
        assert wild.tail < 3.0 < 10.0 < calm.tail
        assert np.median(wild.sd_n) < 2.0 * np.median(calm.sd_n)


def test_a_scatter_that_passes_on_the_move_is_alike_along_a_path():
    path = np.cumsum(np.abs(np.concatenate([r.rate * r.dt_s * r.factor for r in SIM.problem.records])))
    rng = np.random.default_rng(6)
    steps = np.diff(path, prepend=0.0)
    kept, out, at = np.exp(-steps / 2.0), np.empty(len(path)), 0.0
    for i, kick in enumerate(rng.standard_normal(len(path))):
        at = kept[i] * at + np.sqrt(1.0 - kept[i] ** 2) * kick
        out[i] = at
    for s in learned(SIM.problem, noise(3) + 0.2 * out, PHASES, NOISE):
        assert s.correlation_path < 8.0


def test_noise_alone_has_no_map_and_too_few_samples_have_none():
    found = learned(SIM.problem, 0.5 * noise(4), PHASES, NOISE)
    assert found == () or all(np.abs(s.mean_n).max() < 0.01 for s in found)
    few = replace(SIM.problem, records=tuple(replace(r, weight=np.where(np.arange(len(r)) < 20, 1.0, 0.0)) for r in SIM.problem.records))
    assert learned(few, noise(5), PHASES, NOISE) == ()


def test_a_covariance_is_told_by_few_columns():
    rng = np.random.default_rng(7)
    factor = rng.standard_normal((30, 3)) @ rng.standard_normal((3, 20)) + 1e-4 * rng.standard_normal((30, 20))
    short = discrepancy._short(factor)
    assert short.shape == (30, 3) and short @ short.T == pytest.approx(factor @ factor.T, abs=0.02 * np.trace(factor @ factor.T) / 3)


def test_what_is_left_is_like_itself_for_a_while():
    records = [replace(r, weight=np.ones(len(r))) for r in SIM.problem.records[:1]]
    rng = np.random.default_rng(1)

    def memory(x):
        return discrepancy._memory(discrepancy._Map(records, None, np.ones(len(x), bool), x, x, PHASES, NOISE, None), x)

    # blocks of 10 equal numbers: alike by 1 - lag / 10
    assert memory(np.repeat(rng.standard_normal(200), 10)) == pytest.approx(7.0, abs=1.0)
    assert memory(np.zeros(2000)) == 1.0 and memory(rng.standard_normal(2000)) == 1.0
    # no longer than a quarter of a run
    assert memory(np.ones(2000)) == 500.0
