"""Recordings without noise: of a simulator that is exact nothing is missing, of one that lacks an effect just that."""

import warnings

import pytest

import sstl_cli as sstl


@pytest.mark.parametrize(
    ("effects", "named"), [({}, ()), pytest.param({"gain_error": {"g_act": 1.03}}, ("gain_error",), marks=pytest.mark.slow)]
)
def test_recordings_without_noise(effects, named):
    whole = sstl.simulate("sample", simulator="transmission", noise_n=0.0, seed=3, effects=effects)
    # one bend in both systems
    log = sstl.Log(whole.runs[:2])
    candidates = ("gain_error", "zero_offset", "viscous", "friction_drift", "saturation", "acquisition_faults", "quantisation")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        said = sstl.diagnose(log, effects=candidates).verdict
    assert (said.status, tuple(said.effects)) == ("identified" if named else "none", named)
