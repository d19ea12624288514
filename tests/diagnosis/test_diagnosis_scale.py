"""The scale of an output that is no force: a play that was read in volts comes back in newtons."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from sstl_cli.core.runs import Run
from sstl_cli.diagnosis.scale import Scale, given, in_newtons, scale_of
from sstl_cli.physics.filters import first_order
from sstl_cli.physics.scenario import OutputScale
from sstl_cli.steps import diagnose

PER_N, ORIGIN = {"act": 3.0, "sstl": -0.5}, {"act": 5.0, "sstl": 2.0}


def run(name, system="act", period=7.0, unit="V", per_n=1.0, origin=0.0, moved=None):
    """Return 20 s of a play of theta 0.4 a pass, moved by a sine if by nothing else, its output in some unit."""
    t = np.arange(0.0, 20.0, 0.02)
    u = 12.0 + 9.0 * np.sin(2.0 * np.pi * t / period) if moved is None else moved
    theta = 0.4 * (1 + (system == "sstl"))
    y, last = np.empty_like(u), 12.0
    for k, x in enumerate(u):
        last = y[k] = min(max(last, np.exp(-theta) * x), np.exp(theta) * x)
    noise = 0.005 * np.random.default_rng(int(period)).standard_normal((2, len(t)))
    return Run(name, system, t, u + noise[0], per_n * (y + noise[1]) + origin, config_id="a", unit_out=unit)


def test_outputs_in_newtons_have_no_scale():
    assert scale_of([run("a", unit="N")]) is None


def test_scale_and_origin_of_a_system_are_found():
    found = scale_of([run("a", per_n=3.0, origin=5.0), run("b", period=5.0, per_n=3.0, origin=5.0)])
    assert found.unit == "V" and found.per_n["act"] == pytest.approx(3.0, rel=0.01) and found.origin["act"] == pytest.approx(5.0, abs=0.1)


def test_each_system_has_its_own_and_the_median_is_typical():
    found = scale_of([run("a", per_n=3.0, origin=5.0), run("b", "sstl", 5.0, "mm", 0.5, 2.0)])
    assert found.unit == "V, mm" and found.per_n == {"act": pytest.approx(3.0, rel=0.02), "sstl": pytest.approx(0.5, rel=0.02)}
    assert found.origin == {"act": pytest.approx(5.0, abs=0.2), "sstl": pytest.approx(2.0, abs=0.05)}
    assert found.typical == pytest.approx(1.75, rel=0.02)


def test_samples_that_were_not_read_do_not_spoil_the_first_guess():
    one = run("a", per_n=3.0, origin=5.0)
    holes = replace(one, tension_out_n=np.where(np.arange(len(one)) % 50 == 7, np.nan, one.tension_out_n))
    assert scale_of([holes]).per_n["act"] == pytest.approx(3.0, rel=0.02)


def test_newtons_are_what_is_read_less_the_origin_over_the_scale():
    runs = [Run(s, s, np.zeros(2), np.ones(2), np.array([5.0, 8.0])) for s in ("act", "sstl")]
    out = [r.tension_out_n.tolist() for r in in_newtons(runs, Scale("V", PER_N, ORIGIN))]
    assert out == [[0.0, 1.0], [-6.0, -12.0]]


def test_the_scale_of_an_accepted_model_holds_for_its_unit_and_its_systems_only():
    accepted = OutputScale(unit="V", per_n={"act": 3.0}, origin={"act": 5.0})
    assert given([run("a")], accepted) == Scale("V", {"act": 3.0}, {"act": 5.0})
    assert given([run("a")], None) is None
    assert given([run("a", unit="mm")], accepted) is None
    assert given([run("a"), run("b", "sstl")], accepted) is None
    # several units are several sensors
    two = accepted.model_copy(update={"unit": "V, mm"})
    assert given([run("a"), run("b", unit="mm")], two).unit == "V, mm"


def document(log):
    options = diagnose.DiagnoseOptions(effects=("zero_drift",), max_effects=1, physics=False)
    return diagnose.run(log, options).body


def test_every_number_of_a_document_is_in_the_unit_of_the_recording():
    """Ranges of tension, loops and residuals stayed in the unit of the fit; of an output in volts all but the gap did."""
    log = [run("a", unit="N"), run("b", period=5.0, unit="N")]
    usual = document(log)
    large = document([replace(r, tension_in_n=50.0 * r.tension_in_n, tension_out_n=50.0 * r.tension_out_n) for r in log])
    volts = document([replace(r, tension_out_n=3.0 * r.tension_out_n + 5.0, unit_out="V") for r in log])
    assert large.notes != usual.notes and (usual.unit, large.unit, volts.unit) == ("N", "N", "V")
    for found, force, per_n, origin in ((large, 50.0, 1.0, 0.0), (volts, 1.0, 3.0, 5.0)):
        out = force * per_n
        assert found.gap.rmse_retuned_n == pytest.approx(out * usual.gap.rmse_retuned_n, rel=0.05)
        assert found.where[0].rmse_n == pytest.approx(out * usual.where[0].rmse_n, rel=0.3)
        assert found.candidates[0].rmse_held_out_n == pytest.approx(out * usual.candidates[0].rmse_held_out_n, rel=0.3)
        for quantity in ("tension_n", "rate_n_s"):
            ranges = ([x.high for x in d.where_bands[quantity]] for d in (found, usual))
            assert next(ranges) == pytest.approx([force * x for x in next(ranges)], rel=0.02, abs=0.1 * force)
        loop, plain = found.loops[0], usual.loops[0]
        assert loop.tension_in_n == pytest.approx(force * np.array(plain.tension_in_n), rel=0.01)
        assert loop.measured_n == pytest.approx(out * np.array(plain.measured_n) + origin, rel=0.01)
        left = ([float(np.std(x.base_n)) for x in d.residuals] for d in (found, usual))
        assert next(left) == pytest.approx([out * x for x in next(left)], rel=0.05)
        noise = (d.analysis.noise["act"] for d in (found, usual))
        here, there = next(noise), next(noise)
        assert here["input"]["white_n"].estimate == pytest.approx(force * there["input"]["white_n"].estimate, rel=0.05)
        assert here["output"]["white_n"].estimate == pytest.approx(out * there["output"]["white_n"].estimate, rel=0.05)


def test_a_saved_model_has_what_a_channel_beside_shows_in_the_unit_of_the_recording():
    """A slew limit of the loop was saved in the unit of the fit, where tensions are fitted in one of their own."""
    slew_s_per_n, force = 0.12, 50.0
    log = []
    for period in (7.0, 5.0):
        asked = run("r", period=period).tension_in_n
        reached = first_order(asked, 0.02, 0.0, slew_s_per_n)
        made = run("r", period=period, unit="N", moved=reached)
        ends = {"tension_in_n": made.tension_in_n, "tension_out_n": made.tension_out_n, "tension_ref_n": asked}
        log.append(replace(made, run_id=f"{period:g}", **{k: force * v for k, v in ends.items()}))
    found = diagnose.run(log, diagnose.DiagnoseOptions(effects=("tension_loop_lag", "zero_drift"), max_effects=1, physics=False))
    assert found.verdict.effects == ("tension_loop_lag",)
    saved = found.model().effects["tension_loop_lag"]
    assert saved["inverse_slew_s_per_n"] == pytest.approx(slew_s_per_n / force, rel=0.05)


def test_what_the_base_lacks_is_no_part_of_the_scale():
    """A delay made the scale of the base 6 % too large; what that left was taken for further causes."""
    late = [replace(r, tension_out_n=np.concatenate((np.full(8, r.tension_out_n[0]), r.tension_out_n[:-8]))) for r in (
        run("a", per_n=3.0, origin=5.0), run("b", period=5.0, per_n=3.0, origin=5.0), run("c", period=3.0, per_n=3.0, origin=5.0),
    )]  # fmt: skip
    options = diagnose.DiagnoseOptions(effects=("channel_delay", "viscous", "sensor_nonlinearity"), max_effects=2, physics=False)
    body = diagnose.run(late, options).body
    assert scale_of(late).per_n["act"] > 3.05
    assert body.verdict.status == "identified" and list(body.verdict.effects) == ["channel_delay"]
    assert body.analysis.output_scale.per_n["act"] == pytest.approx(3.0, rel=0.005)
    (delay,) = (p.estimate for c in body.candidates if c.id == "channel_delay" for p in c.parameters if p.name == "tau_act_s")
    assert delay == pytest.approx(0.16, rel=0.02)


def test_a_gain_beside_a_model_in_another_unit_acts_about_where_the_sensor_reads_nothing():
    """It acted about no force: of a sensor that reads 20 there a gain was found too small, beside a zero that nobody moved."""
    log = [run(name, period=period, per_n=3.0, origin=20.0) for name, period in (("a", 7.0), ("b", 5.0))]
    options = diagnose.DiagnoseOptions(effects=("gain_error", "zero_offset", "zero_drift"), max_effects=2, physics=False)
    model = diagnose.run(log, options).model()
    later = [run(name, period=period, per_n=3.0 * 1.08, origin=20.0 * 1.08) for name, period in (("c", 6.1), ("d", 4.3))]
    body = diagnose.run(later, replace(options, sim=model)).body
    assert body.verdict.status == "identified" and list(body.verdict.effects) == ["gain_error"]
    (gain,) = (p.estimate for c in body.candidates if c.id == "gain_error" for p in c.parameters if p.name == "g_act")
    assert gain == pytest.approx(1.08, rel=0.003)
    # and a model that has such a gain says the same
    read = model.model_copy(update={"effects": {"gain_error": {"g_act": 1.08}}})
    assert diagnose.run(later, replace(options, sim=read)).body.verdict.status == "none"
