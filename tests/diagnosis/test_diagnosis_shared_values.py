"""How much of a known scatter is taken for new, share by share, on costs that are known beforehand."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from made_fits import simulator

from sstl_cli.diagnosis import shared
from sstl_cli.diagnosis.constants import SHARES

SIM = simulator()


def scattering(monkeypatch, costs):
    """Return the noise that is taken where settling costs so much by its size (N; of slides first negative), and what was tried."""
    tried = []
    monkeypatch.setattr(shared, "scatter_n", lambda records: np.ones(len(SIM.y)))
    monkeypatch.setattr(shared, "replace", lambda part, **new: SimpleNamespace(**{**vars(part), **new}))

    def settle(sim, noise, f, rounds):
        kind = (0.0 if sim.more_n is None else float(sim.more_n[0]), 0.0 if sim.slips_n is None else float(sim.slips_n[0]))
        tried.append(kind)
        return SimpleNamespace(cost=costs.get((round(kind[0], 6), round(kind[1], 6)), 99.0), rounds=rounds)

    monkeypatch.setattr(shared, "settle", settle)
    sim = SimpleNamespace(problem=SIM.problem, more_n=None, slips_n=None)
    found, fits = shared._scattering(SimpleNamespace(sim=sim, noise=None), [SimpleNamespace(cost=50.0)])
    return found, fits, [(round(a, 6), round(b, 6)) for a, b in tried]


def test_shares_grow_as_long_as_they_make_the_likeliest_model_likelier(monkeypatch):
    sim, (best,), tried = scattering(monkeypatch, {(0.01, 0.0): 40.0, (0.03, 0.0): 30.0, (0.1, 0.0): 30.0, (0.03, 0.01): 20.0})
    # first new at every step, then of every slide beside it; what is as likely is not likelier
    assert tried == [(0.01, 0.0), (0.03, 0.0), (0.1, 0.0), (0.03, 0.01), (0.03, 0.03)]
    assert (sim.more_n[0], sim.slips_n[0], best.cost) == (0.03, 0.01, 20.0) and SHARES[1:3] == (0.01, 0.03)


def test_without_a_share_that_helps_all_stays_as_it_is(monkeypatch):
    sim, (kept,), tried = scattering(monkeypatch, {})
    assert (sim.more_n, sim.slips_n, kept.cost) == (None, None, 50.0) and tried == [(0.01, 0.0), (0.0, 0.01)]


def test_noise_adds_up_by_its_squares():
    assert shared._with(None, np.array([3.0])).tolist() == [3.0] and shared._with(np.array([4.0]), np.array([3.0])).tolist() == [5.0]


@pytest.mark.parametrize("off", [0.0, 0.1])
def test_a_law_that_is_off_adds_that_share_of_its_answer(monkeypatch, off):
    lead = SimpleNamespace(cost=1.0, discrepancy=off, free=())
    base = SimpleNamespace(cost=9.0)
    monkeypatch.setattr(shared, "replace", lambda part, **new: SimpleNamespace(**{**vars(part), **new}))
    monkeypatch.setattr(shared, "jumping", lambda f: set())
    monkeypatch.setattr(shared, "own_response", lambda sim, f: np.full(3, 2.0))
    monkeypatch.setattr(shared, "judged", lambda found, noise, workers: (found.sim.more_n.tolist(), noise, workers))
    asked = []
    monkeypatch.setattr(shared, "_scattering", lambda found, known: asked.append([f.cost for f in known]) or (found.sim, known))
    sim = SimpleNamespace(problem=SimpleNamespace(scatters=True), more_n=None)
    singles = {str(i): (SimpleNamespace(fit=SimpleNamespace(cost=10.0 + i, discrepancy=0.0)),) for i in range(6)} | {
        "lead": (SimpleNamespace(fit=lead),)
    }
    found = SimpleNamespace(sim=sim, base=base, singles=singles, noise="noise")
    told = shared.loosened(found, 3)
    assert told == ([0.2] * 3, "noise", 3) if off else told is found
    # the base and the four likeliest are asked
    assert asked == [[9.0, 1.0, 10.0, 11.0, 12.0]]
