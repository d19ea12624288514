"""When noise is left as it is, and that every model is judged by the noise that is believed, on small made fits."""

from __future__ import annotations

from dataclasses import replace

import pytest
from made_fits import NOISE_N, made, noise, simulator

from sstl_cli.diagnosis import again
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
