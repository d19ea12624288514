"""When noise is left as it is, and that every model is judged by the noise that is believed, on small made fits."""

from __future__ import annotations

from dataclasses import replace

import pytest
from made_fits import NOISE_N, made, noise, simulator

from sstl_cli.diagnosis import again
from sstl_cli.diagnosis.constants import ALIVE_NATS
from sstl_cli.diagnosis.evidence import Weighed
from sstl_cli.diagnosis.found import Search
from sstl_cli.diagnosis.hypotheses import variants
from sstl_cli.diagnosis.whitening import Noise, Sensor

OUT = next(h for h in variants("zero_offset", ("act",)) if [f.parameter.name for f in h.strengths] == ["z_out_act_n"])


def sensors(coloured):
    sensor = Sensor(NOISE_N, coloured * NOISE_N, 0.2)
    return Noise({"act": Sensor(NOISE_N, 0.1 * NOISE_N, 0.2)}, {"act": sensor}, {"act": 1.0})


def search(evidence, coloured):
    model = Weighed(made(noise(), OUT, (0.1,)), evidence + 5.0, evidence)
    return Search(simulator(), sensors(coloured), sensors(0.1), made(noise() + 0.1), {"zero_offset": (model,)}, {})


@pytest.mark.parametrize(("evidence", "coloured"), [(60.0, 0.12), (-1.0, 2.0)])
def test_noise_that_is_not_strained_or_that_nothing_explains_stays(evidence, coloured):
    found = search(evidence, coloured)
    assert again.beside_the_best(found, 1, 1) is found


@pytest.mark.parametrize(("coloured", "taken"), [(0.2, True), (3.0, False)])
def test_only_noise_that_is_strained_less_is_taken(monkeypatch, coloured, taken):
    found = search(60.0, 2.0)
    monkeypatch.setattr(again, "_noise", lambda was, leaders: sensors(coloured))
    monkeypatch.setattr(again, "judged", lambda was, own, workers: replace(was, noise=own))
    assert (again.beside_the_best(found, 1, 1).noise == sensors(coloured)) is taken


def test_what_still_promises_something_and_every_pair_is_fitted_again(monkeypatch):
    found, asked = search(60.0, 2.0), {}
    lead = found.singles["zero_offset"][0]
    gain = next(h for h in variants("gain_error", ("act",)) if h.strengths)
    for name, behind in (("near", ALIVE_NATS - 1.0), ("far", ALIVE_NATS + 1.0)):
        model = Weighed(made(noise(), gain, (1.02,) * len(gain.free)), lead.gain - behind, 1.0)
        both = Weighed(made(noise(), OUT.joined(gain), (0.1, *(1.02 for _ in gain.free))), lead.gain - behind, 1.0)
        found.singles["gain_error"], found.combined[both.ids] = (model,), both
        monkeypatch.setattr(again, "settle", lambda sim, own, f, rounds=2, *_: (asked.setdefault((name, f.ids), rounds) and f) or f)  # noqa: B023
        monkeypatch.setattr(again, "deepest", lambda sim, own, base, fits: base)
        monkeypatch.setattr(again, "weigh", lambda sim, f, *_: Weighed(f, 1.0, 1.0))
        judged = again.judged(found, sensors(0.2), 1)
        assert judged.noise == sensors(0.2) and set(judged.combined) == {both.ids} and set(judged.singles) == set(found.singles)
    assert asked == {
        ("near", ("zero_offset",)): 1, ("near", ("gain_error",)): 1, ("near", both.ids): 1, ("near", ()): 2,
        ("far", ("zero_offset",)): 1, ("far", ("gain_error",)): 0, ("far", both.ids): 1, ("far", ()): 2,
    }  # fmt: skip
