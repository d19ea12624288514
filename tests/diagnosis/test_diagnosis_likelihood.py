"""A small version of docs/likelihood.md: what is left where nothing is missing is white, phase by phase."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parents[2] / "tools"))

import likelihood_cases as lc

WHITE_N, COLOURED_N = (0.02, 0.0, 0.2), (0.02, 0.02, 0.3)


SOURCES = [
    pytest.param(("fast model", WHITE_N), marks=pytest.mark.slow),
    pytest.param(("rig", WHITE_N), marks=pytest.mark.slow),
    ("rig", COLOURED_N),
]


@pytest.fixture(scope="module", params=SOURCES, ids=str)
def heard(request):
    simulator, setting = request.param
    return [lc.heard(lc.source(simulator, 100.0, setting, seed, 3000), {}) for seed in (1, 2)]


def test_every_phase_has_the_chi_squared_of_its_samples(heard):
    found = [lc.whiteness(n) for n in heard]
    square, count = (np.sum([f[k] for f in found], axis=0) for k in ("square", "count"))
    # four standard deviations, and three hundredths for what noise estimated from a short record is off; slides of the
    # release, few and loud, may be twice that below
    room = 4.0 * np.sqrt(2.0 / count) + np.tile([0.03, 0.03, 0.03, 0.06], 2)
    assert np.all(np.abs(square / count - 1.0) < room), square / count
    assert all(abs(f["neighbours"]) < 0.05 for f in found)


def test_what_holds_nothing_gains_nothing(heard):
    """Twice the gain of an offset's strengths by chance is chi squared: no more than one in ten thousand allows."""
    for n in heard:
        k, gain = lc.chance(n, "zero_offset")
        assert k == 4 and gain < 23.5


def test_the_covariance_of_the_smoother_is_that_of_its_chain(heard):
    r = heard[0].problem.records[0]
    law = lc.latent(r.raw.tension_in_n[:200], r.raw.dt_s, 0.02).chain
    sigma = lc.covariance(law)
    assert np.linalg.eigvalsh(sigma).min() > -1e-12 and np.allclose(sigma, sigma.T)
