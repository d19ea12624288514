"""A reading that comes to its limit softly is saturation too, and what the recorder shows itself is asked for once."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from made_fits import NOISE_N, made, named, simulator
from rig_logs import RAMPS, record

from sstl_cli.diagnosis import faults, gathering
from sstl_cli.diagnosis.evidence import Weighed
from sstl_cli.diagnosis.faults import RecorderEffect
from sstl_cli.diagnosis.found import Search
from sstl_cli.diagnosis.verdict import IDENTIFIED
from sstl_cli.diagnosis.whitening import Noise, Sensor
from sstl_cli.steps import diagnose
from sstl_cli.steps.diagnose import DiagnoseOptions

QUIET = Sensor(NOISE_N, 0.0, 0.1)
NOISE = Noise({"act": QUIET}, {"act": QUIET}, {"act": 1.0})
SOFT, CURVED = named("saturation", "soft_out", "knee_n", "width_n"), named("sensor_nonlinearity", "b_out", "knee_n")
OPTIONS = DiagnoseOptions(effects=("saturation", "sensor_nonlinearity", "gain_error", "load_dependent_friction"), max_effects=1, workers=2)


def bent(slope: float, width_n: float = 0.3, knee_n: float = 9.0) -> diagnose.Diagnosis:
    """Return the diagnosis of a rig's log whose output reads a part of what is beyond a knee."""

    def read(t_n: np.ndarray) -> np.ndarray:
        return t_n - (1.0 - slope) * width_n * np.logaddexp(0.0, (t_n - knee_n) / width_n)

    rng = np.random.default_rng(3)
    runs = record({}, white=0.0, moves=RAMPS[:1])
    noisy = [replace(r, tension_in_n=r.tension_in_n + 0.02 * rng.standard_normal(len(r))) for r in runs]
    return diagnose.run([replace(r, tension_out_n=read(r.tension_out_n) + 0.02 * rng.standard_normal(len(r))) for r in noisy], OPTIONS)


def test_a_soft_limit_is_saturation_and_its_knee_is_found():
    found = bent(0.0)
    assert (found.verdict.status, found.verdict.effects) == (IDENTIFIED, ("saturation",))
    fit = found.evidence.search.best(("saturation",)).fit
    said = dict(zip((f.parameter.name for f in fit.free), fit.values, strict=True))
    # one output alone comes there: of the other's knee, where it has one of its own, nothing is known
    said["knee_n"] = said.pop("knee_sstl_n", said["knee_n"])
    assert said == pytest.approx({"soft_out": 1.0, "knee_n": 9.0, "width_n": 0.3}, rel=0.1)


def test_what_keeps_half_of_its_slope_beyond_a_knee_is_a_curved_sensor():
    found = bent(0.5, 0.05)
    assert (found.verdict.status, found.verdict.effects) == (IDENTIFIED, ("sensor_nonlinearity",))


def test_a_fault_of_the_recorder_is_no_model_as_well_unless_that_leads():
    soft, curved = Weighed(made(0.0, SOFT, (1.0, 9.0, 0.3)), 50.0, 40.0), Weighed(made(0.0, CURVED, (-0.5, 9.0)), 70.0, 60.0)
    both = Weighed(made(0.0, SOFT.joined(CURVED), (1.0, 9.0, 0.3, -0.5, 9.0)), 60.0, 30.0)
    search = Search(
        simulator(),
        NOISE,
        NOISE,
        made(),
        {"saturation": (soft,), "sensor_nonlinearity": (curved,)},
        {("saturation", "sensor_nonlinearity"): both},
    )
    fault = RecorderEffect("saturation", 0.9, {}, 1.0, 0.02)
    less, much = (lambda _, left=left: [replace(fault, removed_n2=left)] for left in (0.4, 0.6))
    assert list(faults.once(search, [], less).singles) == ["saturation", "sensor_nonlinearity"]
    once = faults.once(search, [fault], less)
    assert list(once.singles) == ["sensor_nonlinearity"] and not once.combined
    leads = replace(search, singles={**search.singles, "saturation": (replace(soft, evidence=90.0),)})
    kept = faults.once(leads, [fault], less)
    assert list(kept.singles) == ["saturation", "sensor_nonlinearity"] and len(kept.combined) == 1
    # what leads leaves most of what the readings show: a channel that overflows is no amplifier
    assert list(faults.once(leads, [fault], much).singles) == ["sensor_nonlinearity"]
    # one row of each name
    assert [r.ids for r in gathering.beside(once, [fault], [])] == [("saturation",)] and gathering.beside(kept, [fault], []) == []
