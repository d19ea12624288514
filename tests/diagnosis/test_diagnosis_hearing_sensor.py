"""Where slow noise of the input's sensor is looked for, and which systems are told of it, by hand on the small made records."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from made_fits import NOISE_N, THETA, made, noise, simulator
from scipy.signal import lfilter

from sstl_cli.core.runs import Run
from sstl_cli.diagnosis import hearing
from sstl_cli.diagnosis.constants import AT_MOST, DECIDES_NATS, LEVELS, MEASURED, UNKNOWN_COLOUR, UNSEEN
from sstl_cli.diagnosis.hypotheses import full, variants
from sstl_cli.diagnosis.records import prepare
from sstl_cli.diagnosis.whitening import Noise, Sensor

SIM = simulator()
ZERO, FRICTION = full("zero_offset", ("act",)), variants("const_friction", ("act",))[0]
SENSOR = Sensor(0.02, 0.01, 0.2)
RUNS = hearing._smoothed(SIM.problem.records, {"act"})
MEASURED_NOISE = Noise({"act": Sensor(0.01, 0.005, 0.2)}, {"act": SENSOR}, {"act": 1.0})


def read(out):
    return replace(MEASURED_NOISE, output={"act": out})


def test_the_noise_of_some_systems_is_of_one_and_of_the_rest_of_the_other():
    def both(k):
        return Noise(
            *({s: Sensor(k, k, k) for s in ("act", "sstl")} for _ in range(2)),
            {"act": k, "sstl": k},
            {"act": {"x": k}, "sstl": {"x": k}},
            {"act": k},
            {"act": k},
        )

    found = hearing._either(both(1.0), both(2.0), {"act"})
    assert {k: s.white_n for k, s in found.input.items()} == {k: s.white_n for k, s in found.output.items()} == {"act": 1.0, "sstl": 2.0}
    assert found.smoother == {"act": 1.0, "sstl": 2.0} and found.spread == {"act": {"x": 1.0}, "sstl": {"x": 2.0}}
    # what was believed before stays
    assert found.open == found.loose == {"act": 2.0}


def test_columns_are_thetas_and_what_each_model_may_change_as_far_as_it_shows():
    base, best, third = made(), made(0.0, ZERO, (0.0, 0.1)), made(0.0, FRICTION, (0.1,))
    assert hearing._leading([base]) is base and hearing._leading([base, best, third]) is best
    found = hearing.columns(SIM, [base, best, third])
    assert found.shape == (8000, 5)
    for c in (0, 1):
        assert found[:, c] == pytest.approx(np.where(SIM.config == c, best.jacobian[:, 0], 0.0))
    assert np.array_equal(found[:, 2:4], best.jacobian[:, 1:]) and np.array_equal(found[:, 4], third.jacobian[:, 1])
    # what shows only where nothing was read does not show
    blind = replace(SIM)
    blind.weight = np.where(SIM.config == 0, 1.0, 0.0)
    assert hearing.columns(blind, [base, best, third]).shape == (8000, 4)
    assert hearing.columns(SIM, [base]).shape == (8000, 2)


@pytest.mark.parametrize(
    ("off", "believed"), [(0.0, True), (0.9 * AT_MOST * MEASURED, True), (-0.7 * AT_MOST * MEASURED, True), (AT_MOST * MEASURED, False)]
)
def test_an_input_is_asked_whatever_its_output_s_sensor_has_which_is_believed_unless_it_holds_what_the_models_miss(
    monkeypatch, off, believed
):
    monkeypatch.setattr(
        hearing, "_likeliest", lambda records, into, out, tau: (replace(out, white_n=into.white_n, correlation_s=tau * len(records)), 5.0)
    )
    out = replace(SENSOR, coloured_n=0.01 * float(np.exp(off)))
    found = hearing.entering(RUNS, read(out), MEASURED_NOISE, 0.3)
    # all four runs are asked
    assert found == {"act": Sensor(0.01, (out if believed else SENSOR).coloured_n, 1.2)}
    alike = hearing._alike(read(out), MEASURED_NOISE, {"act"})
    assert alike == ({"act": replace(out, white_n=0.01)} if believed else {})


def test_where_the_measured_noise_may_be_anything_it_is_believed_further():
    far = read(replace(SENSOR, coloured_n=0.01 * float(np.exp(2.0 * AT_MOST * MEASURED))))
    assert hearing._is_noise("act", far, replace(MEASURED_NOISE, open={"act": 1.0})) and not hearing._is_noise("act", far, MEASURED_NOISE)


def test_what_is_too_little_to_be_seen_or_to_be_believed_is_told_to_nobody(monkeypatch):
    little = replace(SENSOR, coloured_n=0.9 * UNSEEN * SENSOR.white_n)
    assert hearing._alike(read(little), MEASURED_NOISE, {"act"}) == {}
    monkeypatch.setattr(hearing, "_likeliest", lambda *_: (SENSOR, 0.9 * DECIDES_NATS))
    assert hearing.entering(RUNS, read(SENSOR), MEASURED_NOISE, 0.3) == {}


def test_louder_inputs_are_dearer_by_what_their_readings_say_against_them_and_by_what_decides():
    assert not list(hearing._louder({}, MEASURED_NOISE.input))
    (first, cost), *more = hearing._louder(RUNS, MEASURED_NOISE.input)
    levels = [first["act"].coloured_n, *(s["act"].coloured_n for s, _ in more)]
    assert levels == sorted(levels) and levels[0] > UNKNOWN_COLOUR * 0.01 and {s["act"].white_n for s, _ in more} == {0.01}
    # straight lines are no noise, and the more of it they would have to hide the less
    costs = [cost["act"], *(c["act"] for _, c in more)]
    assert costs == sorted(costs) and costs[0] > DECIDES_NATS
    part = RUNS["act"]
    told = hearing._readings_nats(part, levels[-1], first["act"].correlation_s) - hearing._readings_nats(part, LEVELS[0] * 0.01, 0.4)
    assert costs[-1] == pytest.approx(told + DECIDES_NATS)
    clean = tuple(replace(r, error_n=np.zeros(len(r))) for r in SIM.problem.records)
    assert not list(hearing._louder(hearing._smoothed(clean, {"act"}), MEASURED_NOISE.input))


def test_what_is_told_has_to_be_worth_what_it_costs_besides(monkeypatch):
    nats = iter([{"act": -10.0}, {"act": -14.0}, {"act": -14.0}])
    monkeypatch.setattr(hearing, "_likely", lambda *_: (MEASURED_NOISE, next(nats)))
    asked = hearing._Asked(SIM, (made(),), MEASURED_NOISE, np.zeros((8000, 1)), MEASURED_NOISE, next(nats))
    assert not asked.told_of({"act": SENSOR}, {"act": 5.0}).told
    after = asked.told_of({"act": SENSOR}, {"act": 3.0})
    assert after.told == {"act"} and after.nats == {"act": -11.0} and all(r.told_n == SENSOR.coloured_n for r in after.sim.problem.records)
    assert asked.told_of({}) is asked


def test_an_input_whose_output_is_still_left_with_more_than_noise_is_told_of_nothing(monkeypatch):
    far = read(replace(SENSOR, coloured_n=SENSOR.coloured_n * float(np.exp(AT_MOST * MEASURED))))
    monkeypatch.setattr(hearing, "_likely", lambda *_: (far, {"act": -1e4}))
    asked = hearing._Asked(SIM, (made(),), MEASURED_NOISE, np.zeros((8000, 1)), far, {"act": 0.0})
    assert not asked.told_of({"act": SENSOR}).told


def test_a_clean_input_is_left_alone(monkeypatch):
    monkeypatch.setattr(hearing, "_likeliest", lambda *_: "asked")
    clean = tuple(replace(r, error_n=np.zeros(len(r))) for r in SIM.problem.records)
    assert hearing.entering(hearing._smoothed(clean, {"act"}), read(SENSOR), MEASURED_NOISE, 0.3) == {}


def test_an_input_without_slow_noise_is_not_said_to_have_as_much_as_the_output():
    into, out = Sensor(0.01, 0.0, 0.2), Sensor(NOISE_N, 0.05, 0.2)
    found, nats = hearing._likeliest(SIM.problem.records[:1], into, out, 0.2)
    assert found.white_n == 0.01 and found.coloured_n < 0.5 * out.coloured_n and nats < DECIDES_NATS


@pytest.mark.parametrize("out", [Sensor(NOISE_N, 0.04, 0.3), Sensor(0.03, 0.0005, 5.0), Sensor(0.002, 0.4, 1.0)])
def test_slow_noise_of_an_input_is_found_as_large_as_it_is_beside_any_output(out):
    rng = np.random.default_rng(6)
    t = np.arange(0.0, 40.0, 0.02)
    memory = np.exp(-0.02 / 0.2)
    slow = lfilter([1.0], [1.0, -memory], 0.05 * np.sqrt(1.0 - memory**2) * rng.standard_normal(len(t)))
    # straight lines between corners a few seconds apart
    u = np.interp(t, np.arange(0.0, 45.0, 4.0), rng.uniform(3.0, 25.0, 12)) + slow + 0.01 * rng.standard_normal(len(t))
    records = prepare([Run("r", "act", t, u, 0.6 * u, config_id="a")]).records
    found, nats = hearing._likeliest(records, Sensor(0.01, 0.0, 0.2), out, 0.2)
    assert found == Sensor(0.01, pytest.approx(0.05, rel=0.25), 0.2) and nats > 25.0


def test_noise_that_models_leave_is_as_large_as_it_was_made_and_what_they_can_change_is_none():
    base, best = made(), made(0.0, variants("zero_offset", ("act",))[1], (0.0,))
    sim = replace(SIM)
    # an offset that the second model can take up, and a theta that both can
    sim.y = sim.predict(THETA + 0.002, {}) + 0.1 + noise(1)
    measured = Noise({"act": Sensor(1e-4, 1e-6, 0.1)}, {"act": Sensor(NOISE_N, 0.1 * NOISE_N, 0.1)}, {"act": 1.0})
    found, nats = hearing._likely(sim, [base, best], measured, hearing.columns(sim, [base, best]))
    assert found.output["act"].white_n == pytest.approx(NOISE_N, rel=0.1) and found.output["act"].coloured_n < 0.3 * NOISE_N
    _, more = hearing._likely(sim, [base], measured, hearing.columns(sim, [base]))
    assert more["act"] > nats["act"] + 100.0


def test_without_slow_noise_nothing_is_smoothed_again():
    base = made(noise(2))
    sim = replace(SIM)
    sim.y = base.prediction + base.residual
    measured = Noise({"act": Sensor(1e-4, 1e-6, 0.1)}, {"act": Sensor(NOISE_N, 0.01 * NOISE_N, 0.1)}, {"act": 1.0})
    found, fitted, at, known = hearing.heard(sim, [base], measured)
    assert found is sim and fitted is base and known is measured and at.output["act"].white_n == pytest.approx(NOISE_N, rel=0.1)
