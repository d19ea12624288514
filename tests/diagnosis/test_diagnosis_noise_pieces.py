"""What is believed of a sensor's noise, piece by piece, and the noise that slides leave against a dense restricted likelihood."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from made_fits import NOISE_N, noise, simulator
from scipy.signal import lfilter

from sstl_cli.diagnosis import noise as of
from sstl_cli.diagnosis import rounding, white
from sstl_cli.diagnosis.constants import ALIKE, DECIDES_NATS, ENOUGH, MEASURED, SMOOTHER, UNSEEN, WHITE, WINDOWS_S
from sstl_cli.diagnosis.holds import _pieces
from sstl_cli.diagnosis.laid import constants
from sstl_cli.diagnosis.noise import floor_n, likely, measured, of_readings, some, variance, white_only
from sstl_cli.diagnosis.recorder import Faults, white_beside
from sstl_cli.diagnosis.whitening import Noise, Phases, Sensor, step_of, whitener

SIM = simulator()
RECORDS = SIM.problem.records
QUIET = Noise({"act": Sensor(0.01, 0.004, 0.2)}, {"act": Sensor(NOISE_N, 0.01, 0.1)}, {"act": 2.0})
NO = np.zeros(4, bool)


def faults(noise_n, step=0.0, samples=len(NO)):
    none = np.zeros(samples, bool)
    return Faults(none, none, none, float("inf"), step, noise_n)


def phases(slide=0.0, gain=0.5, doubt=0.0):
    return Phases(*(np.full(len(SIM.y), v) for v in (slide, slide, gain, doubt)))


def test_a_coarse_converter_without_noise_keeps_one_error_throughout_a_rest():
    sensor, step = Sensor(0.02, 0.03, 0.1), 0.04 * np.sqrt(12.0)
    # rounding of 0.04 N is below a noise of 0.05 N, and above one of 0.03 N
    assert rounding.with_rounding(sensor, [faults(0.05, step)]) is sensor
    rounded = rounding.with_rounding(sensor, [faults(0.03, step), faults(0.03, step), faults(9.0, 0.0)])
    assert rounded == Sensor(0.02, pytest.approx(0.05), WINDOWS_S[-1])
    assert rounding.with_rounding(replace(sensor, correlation_s=3.0), [faults(0.03, step)]).correlation_s == 3.0


def test_beside_an_accepted_model_only_white_noise_is_left():
    found = white_only(QUIET)
    assert found.input["act"] == Sensor(0.01, pytest.approx(UNSEEN * 0.01), 0.2) and found.output["act"] == Sensor(
        NOISE_N, pytest.approx(UNSEEN * NOISE_N), 0.1
    )
    assert found.smoother == {"act": 2.0}


def test_the_noise_of_a_reading_is_that_of_a_mean_times_the_root_of_how_many():
    thin = [SimpleNamespace(system="act", averaged=lambda _, k=k: k) for k in (1, 4, 9)]
    assert of_readings(thin, QUIET).output["act"].white_n == pytest.approx(2.0 * NOISE_N)
    assert of_readings(thin, QUIET).input == QUIET.input


def test_runs_are_taken_shortest_first_until_they_hold_enough():
    pairs = [(r, slice(0, 0)) for r in RECORDS]
    assert len(some(pairs)) == ENOUGH // 2000 and len(some(pairs[:1])) == 1
    short = replace(RECORDS[0], y=RECORDS[0].y[:1999])
    # one sample too few: a third run
    found = some([*pairs, (short, slice(0, 0))])
    assert found[0][0] is short and len(found) == 3


def test_the_least_white_noise_is_that_of_rounding_and_of_the_grid():
    r = replace(RECORDS[0], faults_in=faults(0.0, 0.6, 2000), faults_out=faults(0.0, 0.0, 2000))
    assert white.least_white(r, "tension_in_n") == pytest.approx(0.6 / np.sqrt(12.0))
    assert white.least_white(r, "tension_out_n") == pytest.approx(1e-4 * np.ptp(r.raw.tension_out_n))
    assert white.white_of(r.raw.tension_in_n, r, "tension_in_n") == pytest.approx(0.6 / np.sqrt(12.0))
    assert white.white_of(RECORDS[0].raw.tension_in_n, RECORDS[0], "tension_in_n") == pytest.approx(0.01, rel=0.05)
    # where the output is held for long enough it shows there alone
    loud = RECORDS[0].y_fine + np.where(np.arange(2000) < 1000, 0.0, 0.5) * np.random.default_rng(1).standard_normal(2000)
    assert white.white_of(loud, RECORDS[0], "tension_out_n", np.arange(2000) < 1000) == pytest.approx(0.01, rel=0.1)
    assert white.typical([1.0, 5.0, 2.0]) == 2.0 and white.typical([0.0]) == 1e-6


def test_values_are_spaced_as_they_are_read():
    assert white.spacing(RECORDS, "tension_in_n") == pytest.approx(0.02)
    slow = (np.arange(2000) % 5 == 0).astype(float)
    marked = [replace(r, raw=replace(r.raw, extra={"known_tension_out_n": slow})) for r in RECORDS]
    assert white.spacing(marked, "tension_out_n") == pytest.approx(0.1) and white.spacing(marked, "tension_in_n") == pytest.approx(0.02)
    assert white.spacing([replace(r, dt_s=0.04) for r in RECORDS], "tension_out_n") == 0.04


def test_windows_fill_a_hold_from_its_beginning():
    held = np.array([0, 1, 1, 1, 1, 1, 0, 1, 1, 0], bool)
    assert [p.tolist() for p in _pieces(np.arange(10.0), held, 2)] == [[1.0, 2.0], [3.0, 4.0], [7.0, 8.0]]
    # those with too few readings are left out
    assert [p.tolist() for p in _pieces(np.where(np.arange(10) == 3, np.nan, np.arange(10.0)), held, 2)] == [[1.0, 2.0], [7.0, 8.0]]


def test_a_perfect_model_leaves_the_noise_of_both_sensors_where_it_enters():
    gain = np.linspace(0.0, 1.0, len(SIM.y))
    found = variance(RECORDS, replace(phases(), gain=gain), QUIET)
    error = np.concatenate([r.error_n for r in RECORDS])
    slow = step_of(1.0, 0.02 / 0.1).variance
    assert found == pytest.approx(gain**2 * (4.0 * error**2 + 0.004**2) + slow * 0.01**2 + NOISE_N**2) and slow == pytest.approx(1.0)
    # told of it the smoother has it in its error
    told = [replace(r, told_n=0.1) for r in RECORDS]
    assert variance(told, phases(), QUIET) == pytest.approx(0.25 * 4.0 * error**2 + 0.01**2 + NOISE_N**2)
    several = [replace(r, readings=np.full(2000, 4.0)) for r in RECORDS]
    assert variance(several, phases(gain=0.0), QUIET) == pytest.approx(step_of(4.0, 0.2).variance * 0.01**2 + NOISE_N**2 / 4.0)


def test_the_floor_is_its_root_over_what_counts_with_the_scatter_where_asked_for():
    part = [
        replace(r, weight=np.where(np.arange(2000) < 1000 * (i < 2), 1.0, 0.0), misfit_n=np.full(2000, 0.3)) for i, r in enumerate(RECORDS)
    ]
    still = phases(gain=0.0)
    plain = np.hypot(0.01, NOISE_N)
    assert floor_n(part, still, QUIET) == pytest.approx(plain) and floor_n(part, still, QUIET, True) == pytest.approx(np.hypot(plain, 0.3))
    assert floor_n(RECORDS, still, QUIET, True) == pytest.approx(plain)
    assert floor_n([replace(r, weight=np.zeros(2000)) for r in RECORDS], still, QUIET) == 0.0


def test_measured_noise_of_a_line_that_holds_is_that_of_its_output():
    rng = np.random.default_rng(5)
    y = [5.0 + 0.03 * rng.standard_normal(2000) for _ in RECORDS]
    held = [replace(r, y=v, y_fine=v, raw=replace(r.raw, tension_out_n=v)) for r, v in zip(RECORDS, y, strict=True)]
    found = measured(held, np.zeros(8000))
    assert found.output["act"].white_n == pytest.approx(0.03, rel=0.05) and found.input["act"].white_n == pytest.approx(0.01, rel=0.05)
    # the input's slow noise is to its white as the output's is
    into, out = found.input["act"], found.output["act"]
    assert (
        into.coloured_n / out.coloured_n == pytest.approx(into.white_n / out.white_n, rel=0.1) and into.correlation_s == out.correlation_s
    )
    assert found.smoother == {"act": 1.0} and MEASURED <= found.open["act"] <= ALIKE


def test_noise_is_most_likely_where_a_dense_restricted_likelihood_has_its_minimum():
    # white noise of 0.03 N was taken for 0.02 N; a slope in the input is projected out
    start = replace(
        QUIET,
        input={"act": Sensor(1e-6, 1e-6, 0.1)},
        output={"act": Sensor(NOISE_N, 1e-4, 0.1)},
        open={"act": MEASURED},
        loose={"act": 0.3},
    )
    column = np.concatenate([r.u for r in RECORDS])[:, None]
    residual = 1.5 * noise(9) + 0.7 * column[:, 0]
    found, nats = likely(RECORDS, phases(gain=0.0), residual, column, start)
    assert found.output["act"].white_n == pytest.approx(1.5 * NOISE_N, rel=0.03) and set(nats) == {"act"}
    # 4000 samples know a standard deviation to 1 / sqrt(2 n)
    assert found.spread["act"]["output.white_n"] == pytest.approx(1.0 / np.sqrt(8000.0), rel=0.3)
    part = [r for r, _ in some([(r, slice(0, 0)) for r in RECORDS])]
    rows = np.concatenate([np.arange(s.start, s.stop) for r, s in zip(RECORDS, SIM.slices(), strict=True) if r in part])
    own = phases(gain=0.0)
    sub = own.at(rows)

    def dense(scale):
        sensor = replace(found.output["act"], white_n=scale * found.output["act"].white_n)
        w = whitener(constants(part, replace(found, output={"act": sensor})), sub)
        r, x = w(residual[rows]), w(column[rows])[:, 0]
        prior = (np.log(sensor.white_n / NOISE_N) / 0.3) ** 2
        return 0.5 * (r @ r - (x @ r) ** 2 / (x @ x) + w.log_det + np.log(x @ x) + prior)

    assert dense(1.0) < min(dense(0.97), dense(1.03))


def test_the_price_of_a_noise_is_that_of_the_output_alone():
    # the input's sensor has as much slow noise as shows in the slides: what was believed of it costs nothing
    rng = np.random.default_rng(12)
    memory = np.exp(-0.02 / 0.2)
    slow = [lfilter([1.0], [1.0, -memory], 0.03 * np.sqrt(1.0 - memory**2) * rng.standard_normal(2000)) for _ in RECORDS]
    start = replace(QUIET, input={"act": Sensor(1e-6, 0.01, 0.2)}, output={"act": Sensor(NOISE_N, 0.002, 0.2)}, smoother={"act": 1.0})
    own, column = phases(1.0, 1.0), np.ones((8000, 1))
    residual = noise(13) + np.concatenate(slow)
    found, nats = likely(RECORDS, own, residual, column, start)
    assert found.input["act"].coloured_n > 0.015 and 0.05 / np.e <= found.input["act"].correlation_s <= 0.8 * np.e
    part = [r for r, _ in some([(r, slice(0, 0)) for r in RECORDS])]
    rows = np.concatenate([np.arange(s.start, s.stop) for r, s in zip(RECORDS, SIM.slices(), strict=True) if r in part])
    w = whitener(constants(part, found), own.at(rows))
    r, x = w(residual[rows]), w(column[rows])[:, 0]
    out = found.output["act"]
    off = [np.log(out.white_n / NOISE_N) / 0.05, np.log(out.coloured_n / 0.002) / MEASURED, np.log(found.smoother["act"]) / 0.2]
    outside = max(np.log(0.05 / out.correlation_s), np.log(out.correlation_s / 0.8), 0.0) / MEASURED
    expected = 0.5 * (r @ r - (x @ r) ** 2 / (x @ x) + w.log_det + np.log(x @ x) + sum(v**2 for v in off) + outside**2)
    assert nats["act"] == pytest.approx(expected, abs=0.01)


def test_noise_far_from_what_was_measured_costs_and_told_inputs_keep_what_they_were_told():
    start = replace(QUIET, spread={"act": {"input.coloured_n": 0.7, "output.white_n": 9.0}})
    told = [replace(r, told_n=0.004, told_s=0.2) for r in RECORDS]
    column = np.ones((8000, 1))
    found, _ = likely(told, phases(), noise(10), column, start)
    assert found.input == start.input and found.spread["act"]["input.coloured_n"] == 0.7 and found.spread["act"]["output.white_n"] < 1.0
    free, _ = likely(RECORDS, phases(), noise(10), column, start)
    assert free.input["act"].white_n == 0.01 and free.input != start.input
    # ten times as loud as measured: a prior of a twentieth lets it go no further than three of them
    loud, _ = likely(RECORDS, phases(gain=0.0), 10.0 * noise(11), column, start)
    assert loud.output["act"].white_n <= NOISE_N * np.exp(0.15) * 1.001


def test_what_lasts_longer_than_noise_of_a_sensor_is_evidence_once_all_else_has_its_say():
    """A parabola in the logarithms: lasting 4 s is likeliest, and another number goes with it."""
    pull, near = 6.0, 2.0

    def cost(p):
        return 7.0 + 0.5 * near * (p[0] - (p[-2] - np.log(4.0))) ** 2 + 0.5 * pull * (p[-2] - np.log(4.0)) ** 2

    at, unit = np.array([0.0, np.log(4.0), 0.0]), np.full(3, 0.3)
    expected = 0.5 * pull * np.log(4.0) ** 2
    # where the bound alone says that it decides nothing, it is the bound
    assert of._wanders(cost, at, unit, 7.0) == pytest.approx(expected, rel=1e-3) and expected > DECIDES_NATS
    weak = of._wanders(lambda p: 0.3 * (cost(p) - 7.0), at, unit, 0.0)
    assert weak == pytest.approx(0.3 * (expected + 0.5 * near * np.log(4.0) ** 2), rel=1e-3) and weak <= DECIDES_NATS
    assert of._wanders(cost, np.array([0.0, np.log(0.9), 0.0]), unit, 7.0) == 0.0


@pytest.mark.parametrize(("lasts_s", "size", "wanders"), [(5.0, 2.0, True), (0.3, 2.0, False), (5.0, 0.15, False), (None, 0.0, False)])
def test_an_output_that_wanders_for_seconds_is_told_from_noise_of_its_sensor(lasts_s, size, wanders):
    """What is little beside the noise of a reading a model may leave where nothing is missing."""
    residual = noise(16)
    if lasts_s is not None:
        rng, memory = np.random.default_rng(17), np.exp(-0.02 / lasts_s)
        steps = size * NOISE_N * np.sqrt(1.0 - memory**2)
        residual = residual + np.concatenate([lfilter([1.0], [1.0, -memory], steps * rng.standard_normal(2000)) for _ in RECORDS])
    start = replace(QUIET, output={"act": Sensor(NOISE_N, max(size, 0.5) * NOISE_N, 1.0)}, open={"act": 1.0})
    found, _ = likely(RECORDS, phases(gain=0.0), residual, np.ones((8000, 1)), start)
    assert (found.wanders["act"] > DECIDES_NATS) is wanders


def test_the_spread_of_a_number_is_one_over_the_root_of_the_curvature():
    def cost(p):
        return 7.0 + 0.5 * 16.0 * p[0] ** 2 + 0.5 * 0.01 * p[1] ** 2

    def bent(p):
        # of third order as well, which a curvature from both sides does not see
        return cost(p) + 9.0 * p[0] ** 3

    assert of._spread(bent, np.zeros(2), 0, 7.0) == pytest.approx(0.25)
    assert of._spread(cost, np.zeros(2), 0, 7.0) == pytest.approx(0.25) and of._spread(cost, np.zeros(2), 1, 7.0) == 1.0


def test_columns_that_nearly_cancel_one_another_take_no_noise_for_their_own():
    """Three effects of one bend may leave, times a hundred thousand, what the smoothing of the input did: that is no size of any effect."""
    rng = np.random.default_rng(14)
    memory = np.exp(-0.02 / 0.2)
    slow = np.concatenate([lfilter([1.0], [1.0, -memory], 0.03 * np.sqrt(1.0 - memory**2) * rng.standard_normal(2000)) for _ in RECORDS])
    start = replace(QUIET, input={"act": Sensor(1e-6, 0.01, 0.2)}, output={"act": Sensor(NOISE_N, 0.002, 0.2)})
    own, residual = phases(1.0, 1.0), noise(15) + slow
    u = np.concatenate([r.u for r in RECORDS])
    plain, _ = likely(RECORDS, own, residual, u[:, None], start)
    # two columns that differ by the very noise, a thousandth of their size
    found, _ = likely(RECORDS, own, residual, np.stack((u, u + 0.03 * slow), axis=1), start)
    assert found.input["act"].coloured_n == pytest.approx(plain.input["act"].coloured_n, rel=0.2)


def test_noise_is_strained_by_what_it_had_to_take_up_and_not_by_what_it_did_not():
    def louder(white=1.0, coloured=1.0, entering=1.0, smoother=1.0):
        into, out = QUIET.input["act"], QUIET.output["act"]
        return Noise(
            {"act": replace(into, coloured_n=entering * into.coloured_n)},
            {"act": replace(out, white_n=white * out.white_n, coloured_n=coloured * out.coloured_n)},
            {"act": smoother},
        )

    plain = louder()
    assert of.strain(plain, plain) == pytest.approx(0.0, abs=1e-20)
    # one spread of the prior in one number of four
    for name, spread in (("white", WHITE), ("coloured", MEASURED), ("entering", ALIKE), ("smoother", SMOOTHER)):
        assert of.strain(louder(**{name: np.exp(spread)}), plain) == pytest.approx(0.25)
        assert of.strain(louder(**{name: np.exp(-spread)}), plain) == pytest.approx(0.0)
    # what is not known can go further for the same price
    assert of.strain(louder(coloured=np.exp(1.0)), replace(plain, open={"act": 1.0})) == pytest.approx(0.25)
    two = Noise(*({**part, "sstl": part["act"]} for part in (plain.input, plain.output, plain.smoother)))
    strained = replace(two, output={**two.output, "sstl": louder(white=np.exp(2.0 * WHITE)).output["act"]})
    assert of.strain(strained, two) == pytest.approx(1.0)


def test_noise_that_is_all_rounding_is_known_to_be_no_more_than_that():
    least = white.typical([white.least_white(r, "tension_out_n") for r in RECORDS])
    assert least > 0.0
    at = [replace(QUIET, output={"act": Sensor(n, 0.0, 0.1)}) for n in (least, 1.01 * least)]
    assert [rounding.at_least_rounding(RECORDS, n) for n in at] == [True, False]


def test_the_prior_of_a_noise_is_what_was_measured_and_never_nothing():
    centre, near = of._prior(Sensor(0.01, 0.002, 0.2), Sensor(0.02, 0.005, 0.2), (0.1, 0.4))
    assert np.exp(centre) == pytest.approx([0.02, 0.005, 0.002, 1.0]) and near == pytest.approx([0.1, 0.4, ALIKE, SMOOTHER])
    # slow noise of either sensor is at least a fiftieth of the output's white one, and a billionth of a newton
    for white_n in (0.02, 1e-7):
        floor = of._prior(Sensor(9.0, 0.0, 0.2), Sensor(white_n, 0.0, 0.2), (0.1, 0.4))[0][1:3]
        assert np.exp(floor) == pytest.approx(np.full(2, 0.02 * white_n + 1e-9))


def test_columns_are_taken_off_by_weighted_least_squares_but_for_what_no_sample_shows():
    rng = np.random.default_rng(21)
    columns = rng.standard_normal((8000, 2)) * [1.0, 1e-3]
    left = columns @ [0.3, -20.0] + noise(22)
    found = of._step(RECORDS, phases(gain=0.0), left, columns, QUIET)
    w = whitener(constants(RECORDS, QUIET), phases(gain=0.0))
    j, r = w(columns), w(left)
    gram = j.T @ j
    # each within a hundred of its standard deviations: a ten-thousandth of its information holds it at none
    assert found == pytest.approx(np.linalg.solve(gram + 1e-4 * np.diag(np.diag(gram)), j.T @ r), rel=1e-6)
    assert found == pytest.approx([0.3, -20.0], rel=0.05)
    # a column of nothing has no coefficient
    assert of._step(RECORDS, phases(gain=0.0), left, np.column_stack((columns, np.zeros(8000))), QUIET)[2] == 0.0


def test_slow_noise_that_third_differences_took_for_white_is_taken_off_and_known_less_well(monkeypatch):
    """Held noise of 0.03 N that lasts a twentieth of a second, beside readings that look like 0.05 N."""
    asked = []

    def held(records, slides, white_n, levels):
        asked.append(white_n)
        return of.held_noise.known, white_n

    held.known = SimpleNamespace(coloured_n=0.03, correlation_s=0.05, spread=MEASURED)
    monkeypatch.setattr(of, "held_noise", held)
    monkeypatch.setattr(of, "white_of_output", lambda mine: (0.05, 0.1))
    monkeypatch.setattr(of, "white_of", lambda *_: 0.04)
    found = measured(RECORDS, np.zeros(8000))
    memory = float(np.exp(-0.02 / 0.05))
    left_out = white_beside(0.05, 0.03, memory)
    # the input's slow noise is to the output's as its white one is
    left_in = white_beside(0.04, 0.8 * 0.03, memory)
    assert found.output["act"].white_n == pytest.approx(left_out) and found.input["act"].white_n == pytest.approx(left_in)
    assert found.output["act"].coloured_n == 0.03 and found.input["act"].coloured_n == pytest.approx(0.8 * 0.03)
    assert asked[0] == 0.05 and asked[1] == pytest.approx(left_out) and asked[2] == pytest.approx(left_in)
    # three tenths of what was taken off beside what is left, and no more than a third of the way to what was seen
    doubt = np.hypot(0.1, MEASURED * (0.05**2 / left_out**2 - 1.0))
    assert found.loose["act"] == pytest.approx(min(doubt, 0.1 + np.log(0.05 / left_out) / 3.0)) and found.open["act"] == MEASURED
    # what no hold shows takes nothing off
    held.known = SimpleNamespace(coloured_n=0.03, correlation_s=0.05, spread=1.0)
    plain = measured(RECORDS, np.zeros(8000))
    assert plain.output["act"].white_n == 0.05 and plain.input["act"].white_n == 0.04 and plain.loose["act"] == 0.1
    # two sensors are alike within a factor of five
    monkeypatch.setattr(of, "white_of", lambda *_: 4.0)
    assert measured(RECORDS, np.zeros(8000)).input["act"].coloured_n == pytest.approx(5.0 * 0.03)
    monkeypatch.setattr(of, "white_of", lambda *_: 1e-5)
    assert measured(RECORDS, np.zeros(8000)).input["act"].coloured_n == pytest.approx(0.03 / 5.0)
