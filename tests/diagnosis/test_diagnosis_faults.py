"""What faults of the recorder carry of the squared error, on records of a hundred samples."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.stats import chi2

from sstl_cli.core.runs import Run
from sstl_cli.diagnosis.constants import CLIPPED_SIGMA, FEW, LEAST_SHARE
from sstl_cli.diagnosis.faults import RecorderEffect, _coarse, recorder_effects, squared_errors
from sstl_cli.diagnosis.recorder import Faults

N, NOISE = 100, 0.1
NO = np.zeros(N, bool)
SOME = np.arange(N) < FEW


def faults(spike=NO, frozen=NO, clipped=NO, level=float("inf"), step=0.0):
    return Faults(spike, frozen, clipped, level, step, NOISE)


def record(error=0.0, into=None, out=None, u=None, weight=None):
    """Return a record whose prediction is 5 N throughout, read with an error."""
    y = 5.0 + np.broadcast_to(error, N)
    known = Run("r", "act", 0.01 * np.arange(N), np.full(N, 8.0), y)
    u = np.full(N, 8.0) if u is None else u
    return SimpleNamespace(
        raw=known, u=u, faults_in=into or faults(), faults_out=out or faults(), raw_weight=np.ones(N) if weight is None else weight
    )


def found(*records, noise=NOISE):
    return {e.id: e for e in recorder_effects(records, [np.full(N, 5.0)] * len(records), [noise] * len(records))}


def test_a_sound_record_has_no_faults():
    assert found(record(error=3.0)) == {}


def test_spikes_carry_their_squared_error():
    # five samples are off by 10 N, the others by 1 N, which is not the spikes'; the noise of 0.1 N is nobody's
    error = np.where(SOME, 10.0, 1.0)
    effect = found(record(error, out=faults(spike=SOME)))["acquisition_faults"]
    assert effect.removed_n2 == pytest.approx(495.0)
    assert effect.share == pytest.approx(495.0 / (500.0 + 95.0 - N * NOISE**2))
    assert effect.parameters == pytest.approx({"spike_pct": 100.0 * 5 / 200, "frozen_pct": 0.0})
    assert effect.nats == pytest.approx(0.5 * 495.0 / NOISE**2)
    row = effect.row()
    assert row.ids == ("acquisition_faults",) and row.kind == "recorder" and row.share == effect.share and row.evidence == effect.nats


def test_readings_count_over_the_noise_of_their_own_sensor():
    """Spikes of a quiet sensor beside a loud one: five of 1 N beside noise of 0.01 N, and a record whose noise is 1 N."""
    spiky, loud = record(np.where(SOME, 1.0, 0.01), out=faults(spike=SOME)), record(np.where(np.arange(N) % 2, 1.0, -1.0))
    (effect,) = recorder_effects((spiky, loud), [np.full(N, 5.0)] * 2, [0.01, 1.0])
    assert effect.nats == pytest.approx(0.5 * 5.0 / 0.01**2, rel=1e-3) and effect.share == pytest.approx(1.0, rel=1e-3)


def test_what_was_not_recorded_is_off_by_nothing():
    """A stretch that was lost is bridged; what the bridge is off by is no error of a reading, and does not dwarf the fault's."""
    error = np.where(SOME, 10.0, 0.0)
    lost = np.arange(N) >= N - 20
    whole, bridged = record(error, out=faults(spike=SOME)), record(np.where(lost, 50.0, error), out=faults(spike=SOME))
    bridged.raw.extra["gap"] = lost.astype(float)
    (effect,) = recorder_effects((bridged,), [np.full(N, 5.0)], [NOISE])
    assert effect.total_n2 == pytest.approx(found(whole)["acquisition_faults"].total_n2) == pytest.approx(500.0)
    assert effect.share == pytest.approx(1.0) and effect.parameters["spike_pct"] == pytest.approx(100.0 * 5 / (2 * 80))


def test_what_a_rig_is_known_to_carry_is_no_news():
    made = record(np.where(SOME, 10.0, 0.0), out=faults(spike=SOME))
    (first,) = recorder_effects((made,), [np.full(N, 5.0)], [NOISE])
    # five readings of equal weight: chance brings up to 2.4 times as many at 49 to 1
    assert first.events == pytest.approx(5.0) and first.at_most_n2 == pytest.approx(first.removed_n2 * 2.4, rel=0.01)
    assert recorder_effects((made,), [np.full(N, 5.0)], [NOISE], {"acquisition_faults": first.at_most_n2 / N}) == []
    worse = record(np.where(SOME, 20.0, 0.0), out=faults(spike=SOME))
    (news,) = recorder_effects((worse,), [np.full(N, 5.0)], [NOISE], {"acquisition_faults": first.at_most_n2 / N})
    assert news.removed_n2 == pytest.approx(2000.0 - first.at_most_n2)


def test_spoilt_readings_of_both_ends_count_as_so_many_of_equal_weight():
    # five of the input are off by 2 N, as many of the output by 1 N: (20 + 5)^2 over 80 + 5
    later = (np.arange(N) >= 50) & (np.arange(N) < 50 + FEW)
    both = record(np.where(later, 1.0, 0.0), into=faults(frozen=SOME), out=faults(spike=later), u=np.where(SOME, 6.0, 8.0))
    effect = found(both)["acquisition_faults"]
    assert effect.removed_n2 == pytest.approx(25.0) and effect.events == pytest.approx(625.0 / 85.0)
    assert effect.parameters == pytest.approx({"spike_pct": 2.5, "frozen_pct": 2.5}) and effect.total_n2 == pytest.approx(25.0)
    # as many events by chance bring this many times the squared error at 49 to 1: the quantile of a Poisson mean
    more = chi2.ppf(48.0 / 49.0, 2.0 * (effect.events + 1.0)) / 2.0 / effect.events
    assert effect.at_most_n2 == pytest.approx(25.0 * more) and RecorderEffect("x", 1.0, {}, 7.0, 1.0).at_most_n2 == 7.0


def test_a_clipped_input_is_off_by_how_far_it_went_beyond_and_only_beyond_noise():
    clipped = np.arange(N) < 10
    for beyond, counted in ((CLIPPED_SIGMA * NOISE * 1.01, True), (CLIPPED_SIGMA * NOISE * 0.99, False), (-3.0, False)):
        made = record(into=faults(clipped=clipped, level=8.0), u=np.where(clipped, 8.0 + beyond, 8.0))
        _, _, into = squared_errors(made, np.full(N, 5.0))
        assert into == pytest.approx(np.where(clipped & counted, beyond**2, 0.0))
    # ten readings that went 2 N beyond a limit of 8 N
    far = record(into=faults(clipped=clipped, level=8.0), u=np.where(clipped, 10.0, 8.0))
    effect = found(far)["saturation"]
    assert effect.removed_n2 == pytest.approx(40.0) and effect.parameters == {"t_max_in_n": 8.0}


def test_of_several_records_the_lowest_limit_and_the_coarsest_step_are_stated():
    clipped = np.arange(N) < 10
    low, high = (record(np.where(clipped, -3.0, 0.0), out=faults(clipped=clipped, level=v)) for v in (2.0, 1.5))
    assert found(low, high)["saturation"].parameters == {"t_max_out_n": 1.5}
    fine, coarse = (record(0.5, out=faults(step=v)) for v in (0.9, 1.2))
    effect = found(coarse, fine, noise=0.01)["quantisation"]
    assert effect.parameters["q_out_n"] == 1.2 and effect.removed_n2 == pytest.approx(N * (1.44 + 0.81) / 12.0)


def test_spoilt_readings_of_both_ends_are_counted_together():
    later = (np.arange(N) >= 50) & (np.arange(N) < 60)
    both = record(into=faults(frozen=SOME, spike=later), out=faults(frozen=SOME, spike=SOME), u=np.where(SOME | later, 6.0, 8.0))
    values = found(both)["acquisition_faults"].parameters
    assert values == pytest.approx({"spike_pct": 100.0 * 15 / 200, "frozen_pct": 100.0 * 10 / 200})


def test_fewer_are_chance():
    few = np.arange(N) < FEW - 1
    assert found(record(np.where(few, 10.0, 0.0), out=faults(spike=few))) == {}


def test_what_carries_next_to_nothing_is_no_cause():
    # of 95 x 1 N^2 of others five samples of 0.5 N carry 1.25 N^2
    assert found(record(np.where(SOME, 0.5, 1.0), out=faults(frozen=SOME))) == {}
    assert LEAST_SHARE > 1.25 / 96.25


def test_a_spoilt_input_counts_by_how_far_it_is_from_the_latent_one():
    u = np.where(SOME, 6.0, 8.0)
    effect = found(record(into=faults(frozen=SOME), u=u))["acquisition_faults"]
    assert effect.removed_n2 == pytest.approx(5 * 4.0) and effect.parameters["frozen_pct"] == pytest.approx(2.5)


def test_a_clipped_output_carries_what_lies_beyond_its_level():
    clipped = np.arange(N) < 40
    # read lower than predicted where clipped: that is what a limit does
    effect = found(record(np.where(clipped, -3.0, 0.0), out=faults(clipped=clipped, level=2.0)))["saturation"]
    assert effect.removed_n2 == pytest.approx(40 * 9.0) and effect.parameters == {"t_max_out_n": 2.0} and effect.share == 1.0
    # read higher than predicted: no limit does that
    assert found(record(np.where(clipped, 3.0, 0.0), out=faults(clipped=clipped, level=8.0))) == {}


def test_a_clipped_input_falsifies_the_output_until_it_is_forgotten():
    clipped, masked = np.arange(N) < 10, np.arange(N) < 30
    effect = found(record(np.where(masked, 2.0, 0.0), into=faults(clipped=clipped, level=8.0), weight=1.0 - masked))["saturation"]
    assert effect.removed_n2 == pytest.approx(30 * 4.0) and effect.parameters == {"t_max_in_n": 8.0}


def test_what_rounding_can_make_is_no_limit():
    clipped = np.arange(N) < 40
    coarse = faults(clipped=clipped, level=4.8, step=0.6)
    # 0.35 N is below half a step and the noise together
    assert "saturation" not in found(record(np.where(clipped, -0.35, 0.0), out=coarse))


def test_rounding_carries_its_variance_at_most():
    # steps of 1.2 N have a variance of 0.12 N^2
    effect = found(record(0.5, out=faults(step=1.2)), noise=0.01)["quantisation"]
    assert effect.removed_n2 == pytest.approx(N * 0.12) and effect.share == pytest.approx(12.0 / 25.0, rel=1e-3)
    assert effect.parameters == {"q_in_n": 0.0, "q_out_n": 1.2}
    # what is left after it was measured is all that it can have made
    assert found(record(0.2, out=faults(step=1.2)), noise=0.01)["quantisation"].removed_n2 == pytest.approx(N * 0.04)


def test_the_noise_was_measured_on_rounded_samples():
    # 0.4 N contain the 0.12 N^2 of rounding to 1.2 N: 0.04 N^2 are noise, 0.96 N^2 of an error of 1 N are to be explained
    effect = found(record(1.0, out=faults(step=1.2)), noise=0.4)["quantisation"]
    assert effect.removed_n2 == pytest.approx(12.0) and effect.share == pytest.approx(12.0 / 96.0)
    # less than that is no noise at all
    assert found(record(1.0, out=faults(step=1.2)), noise=0.3)["quantisation"].share == pytest.approx(12.0 / 100.0)


def test_rounding_that_is_a_small_part_of_the_noise_is_nobodys_fault():
    # 0.12 N^2 of rounding beside 1 N^2 of noise count, 0.0075 N^2 do not, however little else is left
    assert "quantisation" in found(record(1.02, into=faults(step=1.2 * 2.0 / np.exp(0.25))), noise=1.0)
    # noise alone explains as much, or more: then no step is seen in it
    assert found(record(0.98, into=faults(step=1.2 * 2.0 / np.exp(0.25))), noise=1.0) == {}
    assert "quantisation" not in found(record(1.002, into=faults(step=0.3 * 2.0 / np.exp(0.25))), noise=1.0)


def test_a_rounded_input_counts_by_half_and_as_steeply_as_the_line_can_be():
    effect = found(record(0.5, into=faults(step=1.2)), noise=0.01)["quantisation"]
    assert effect.removed_n2 == pytest.approx(N * 0.12 / 4.0 * np.exp(0.5) ** 2)
    assert effect.parameters == {"q_in_n": 1.2, "q_out_n": 0.0}


def test_what_was_counted_of_one_record_is_not_counted_of_the_rest():
    clipped = np.arange(N) >= 50
    both = found(
        record(np.where(SOME, 10.0, np.where(clipped, -3.0, 0.0)), out=faults(spike=SOME, clipped=clipped, level=2.0, step=1.2)), noise=0.01
    )
    assert "quantisation" not in both and both["saturation"].removed_n2 == pytest.approx(50 * 9.0)


def test_records_add_up_and_predictions_may_be_coarser():
    spoilt = record(np.where(SOME, 10.0, 0.0), out=faults(spike=SOME))
    (effect,) = recorder_effects((spoilt, record()), [np.full(N, 5.0), np.full(N // 2, 5.0)], [NOISE] * 2)
    assert effect.removed_n2 == pytest.approx(500.0) and effect.parameters["spike_pct"] == pytest.approx(100.0 * 5 / 400)


def test_rounding_at_the_edge_of_the_noise_is_no_limit_of_the_input():
    clipped = np.arange(N) < 40
    # half a step of the input, as steep as a line can be, and the noise
    edge = 0.3 * np.exp(0.5) + NOISE
    for off, counted in ((edge - 0.01, False), (edge + 0.01, True)):
        made = record(np.where(clipped, off, 0.0), into=faults(clipped=clipped, level=8.0, step=0.6), weight=1.0 - clipped)
        assert ("saturation" in found(made)) is counted


def test_the_larger_cause_comes_first():
    error = np.where(SOME, 10.0, 0.0)
    clipped = np.arange(N) >= 90
    both = record(np.where(clipped, -3.0, error), out=faults(spike=SOME, clipped=clipped, level=2.0))
    assert [e.id for e in recorder_effects((both,), [np.full(N, 5.0)], [NOISE])] == ["acquisition_faults", "saturation"]


def test_nats_of_no_noise_stay_a_number():
    assert np.isfinite(RecorderEffect("saturation", 1.0, {}, 1.0, 0.0).nats)


@pytest.mark.parametrize(("step", "is_fault"), [(0.05, False), (0.14, True)])
def test_steps_that_the_noise_smooths_over_are_no_fault(step, is_fault):
    rng = np.random.default_rng(3)
    sensor = Faults(NO, NO, NO, float("inf"), step, float(np.hypot(NOISE, step / np.sqrt(12.0))))
    error = np.round(NOISE * rng.standard_normal(N) / step) * step
    assert ("quantisation" in found(record(error, out=sensor), noise=sensor.noise_n)) is is_fault


def test_a_step_counts_beyond_half_of_the_noise_that_is_not_its_own():
    # 0.05 N^2 hold 0.03 N^2 of rounding to 0.6 N: a quarter of the other 0.02 N^2 is smoothed over
    assert _coarse(Faults(NO, NO, NO, float("inf"), 0.6, np.sqrt(0.05))) == pytest.approx(0.36 - 0.25 * 0.02)
    assert (
        _coarse(Faults(NO, NO, NO, float("inf"), 0.6, 0.0)) == pytest.approx(0.36)
        and _coarse(Faults(NO, NO, NO, float("inf"), 0.1, 1.0)) == 0.0
    )
