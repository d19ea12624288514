"""What the other runs of a log betray of one of them: a lead, a loss, a rate, a sensor."""

from __future__ import annotations

from dataclasses import replace
from itertools import accumulate

import numpy as np
import pytest
from identification_loops import multisine, play
from identification_slips import BENDS, bend, changed, lines, lost_rows, rig
from test_identification_gate import leads, loop

from sstl_cli.core.runs import Run
from sstl_cli.identification import gate, samples


def at(mm: list[float], thetas: list[float]) -> list[Run]:
    return [replace(r, lead_mm=lead) for r, lead in zip(leads(thetas), mm, strict=True)]


@pytest.mark.parametrize("zero", [0.0, 30.0])
def test_a_screw_that_bends_to_both_sides_goes_through_the_straight_sheath(zero):
    both = at([lead + zero for lead in (-24.0, -12.0, 0.0, 12.0, 24.0)], [0.31, 0.2, 0.1, 0.2, 0.3])
    assert gate.remarks(both) == ()
    # to the other side alone
    assert gate.remarks(at([-40.0, -30.0, -20.0, -10.0, 0.0], [0.5, 0.4, 0.3, 0.2, 0.1])) == ()
    assert [r.rule for r in gate.remarks(at([10.0, 20.0, 30.0, 40.0, 50.0], [0.5, 0.4, 0.3, 0.2, 0.1]))] == ["lead_order"]


@pytest.mark.parametrize(("wrong", "named"), [(2.4, {"r1", "r2"}), (120.0, {"r2", "r3"})])
def test_one_wrong_lead_of_four_stands_off_by_more_than_the_errors_of_friction(wrong, named):
    thetas = [0.12, 0.22, 0.34, 0.46]
    assert gate.remarks(at([0.0, 12.0, 24.0, 36.0], thetas)) == ()
    (said,) = gate.remarks(at([0.0, 12.0, wrong, 36.0], thetas))
    assert said.rule == "lead_order" and set(said.run_ids) == named


def test_bends_of_nearly_one_lead_may_rub_in_any_order():
    assert gate.remarks(at([10.0, 12.0, 14.0, 40.0], [0.32, 0.3, 0.31, 0.45])) == ()


def test_the_one_run_that_no_friction_explains_is_named():
    (said,) = gate.remarks(changed(lost_rows, "act-b020"))
    assert (said.rule, said.run_ids) == ("unexplained", ("act-b020",))


def test_an_unexplained_run_is_told_once():
    def louder(r: Run) -> Run:
        lost = lost_rows(r)
        return replace(lost, tension_out_n=lost.tension_out_n + 0.5 * np.random.default_rng(6).standard_normal(len(lost)))

    said = {r.rule for r in gate.remarks(changed(louder, "act-b020"))}
    assert said and "unexplained" not in said


def at_one_end(r: Run) -> Run:
    """Return a run whose second sensor reads what the first one does, with noise of its own."""
    clean = np.convolve(np.pad(r.tension_in_n, 4, mode="edge"), np.full(9, 1.0 / 9.0), "valid")
    return replace(r, tension_out_n=clean + 0.02 * np.random.default_rng(8).standard_normal(len(r)))


@pytest.mark.parametrize("which", [("sstl-b020",), ("act-b020", "act-b050")])
def test_a_run_that_loses_nothing_where_others_of_its_bend_do_is_of_one_tension(which):
    (said,) = gate.remarks(changed(at_one_end, *which))
    assert (said.rule, said.run_ids) == ("same_channel", which) and "same end" in said.sentence


def test_a_bend_of_its_own_may_lose_nothing():
    straight = replace(at_one_end(rig()[0]), run_id="straight", config_id="b000")
    assert "same_channel" not in {r.rule for r in gate.remarks([*rig(), straight])}


def interpolated(r: Run) -> Run:
    """Return a run whose output was recorded at a tenth of the rate, and filled up to that of the input."""
    return replace(r, tension_out_n=np.interp(r.time_s, r.time_s[::10], r.tension_out_n[::10]))


@pytest.mark.parametrize("digits", [None, 4])
def test_an_output_that_was_interpolated_in_one_run_has_no_noise(digits):
    def slow(r: Run) -> Run:
        y = interpolated(r).tension_out_n
        return replace(r, tension_out_n=y if digits is None else np.round(y, digits))

    (said,) = gate.remarks(changed(slow, "sstl-b050"))
    assert (said.rule, said.run_ids) == ("odd_run", ("sstl-b050",)) and "down to the rounding" in said.sentence


def test_a_converter_that_hides_the_noise_of_one_run_is_no_program():
    t = np.arange(2000) / 100.0
    read = [loop(0.4, seed=k, sd=0.05, run_id=f"r{k}") for k in range(5)]
    x = 15.0 + 10.0 * np.sin(2.0 * np.pi * t / 20.0)
    slow = Run("slow", "act", t, x, play(x, lines(0.4)))
    log = [replace(r, **{c: np.round(getattr(r, c) / 0.05) * 0.05 for c in ("tension_in_n", "tension_out_n")}) for r in (*read, slow)]
    assert "odd_run" not in {r.rule for r in gate.remarks(log)}


def test_numbers_without_noise_in_all_runs_are_not_told_apart_by_their_rounding():
    assert "odd_run" not in {r.rule for r in gate.remarks(changed(interpolated))}


def test_a_run_whose_noise_is_far_below_the_others_was_smoothed():
    def smoothed(r: Run) -> Run:
        return replace(r, tension_out_n=np.convolve(np.pad(r.tension_out_n, 10, mode="edge"), np.full(21, 1.0 / 21.0), "valid"))

    def louder(r: Run) -> Run:
        return replace(r, tension_out_n=r.tension_out_n + 0.1 * np.random.default_rng(2).standard_normal(len(r)))

    # four runs of one system tell it among themselves
    log = [*rig(), *(replace(bend(name, theta, "act", 50, movement=9), run_id=f"{name}-again") for name, theta in BENDS.items())]
    for slip, word in ((smoothed, "probably smoothed"), (louder, "sensor was probably changed")):
        (said,) = [m for m in gate.remarks([slip(r) if r.run_id == "act-b050" else r for r in log]) if m.rule == "odd_run"]
        assert said.run_ids == ("act-b050",) and word in said.sentence


@pytest.mark.slow
def test_an_output_behind_a_low_pass_whose_friction_is_plain_is_no_command():
    def filtered(r: Run) -> Run:
        """Return a run whose amplifier has a low-pass of third order, 0.1 s."""
        y, keep = r.tension_out_n, np.exp(-0.01 / 0.1)
        for _ in range(3):
            y = np.array(list(accumulate(y, lambda state, v: keep * state + (1.0 - keep) * v)))
        return replace(r, tension_out_n=y + 1e-4 * np.random.default_rng(1).standard_normal(len(y)))

    def commanded(r: Run) -> Run:
        return replace(r, tension_out_n=np.round(0.9 * multisine(7, 3.0, 26.0, seconds=90.0)[1][::3], 5))

    for slip, said in ((filtered, "friction is plain"), (commanded, "probably the command")):
        (told,) = [m for m in gate.remarks(changed(slip)) if m.rule == "noiseless"]
        assert said in told.sentence


@pytest.mark.parametrize(("noise", "rubs", "told"), [(0.05, 1.6, True), (0.05, 1.0, False), (0.02, 1.6, False)])
def test_a_rig_whose_bends_rub_more_and_both_of_whose_sensors_are_others_is_another_one(noise, rubs, told):
    """One bend of it rubs only some percent more; noise alone may be that of the drive, friction alone that of the movement."""

    def there(name: str, theta: float, system: str, seed: int) -> Run:
        wrap = theta * (1.2 if name == "b080" and rubs > 1.0 else rubs)
        return replace(bend(name, wrap, system, seed, noise, movement=9), run_id=f"{system}-{name}-B", trajectory="other")

    others = [there(name, theta, system, 70 + k) for k, (name, theta) in enumerate(BENDS.items()) for system in ("act", "sstl")]
    said = [m for m in gate.remarks([*rig(), *others]) if m.rule == "two_rigs"]
    assert len(said) == told and all(name.endswith("-B") for m in said for name in m.run_ids)


def clocks(rate_hz: float, other_hz: float, stamp) -> list[Run]:
    """Return runs of one rate, the last of another one, their stamps as a clock shows them."""
    runs = [loop(0.4, seed=k, run_id=f"r{k}") for k in range(5)]
    ticks = np.arange(len(runs[0]))
    return [replace(r, time_s=stamp(ticks / (other_hz if r is runs[-1] else rate_hz), k)) for k, r in enumerate(runs)]


@pytest.mark.parametrize("other_hz", [400.0, 417.0, 600.0])
def test_rates_that_are_a_fifth_apart_are_told(other_hz):
    (said,) = [m for m in gate.remarks(clocks(500.0, other_hz, lambda t, _: t)) if m.rule == "rate"]
    assert said.run_ids == ("r4",) and said.number == pytest.approx(other_hz)


def jittered(t: np.ndarray, seed: int) -> np.ndarray:
    """Return stamps that come late now and then, in the last run by more: the median step is shorter there, the mean one is not."""
    spread = 0.55 if seed == 4 else 0.1
    return t[1] * np.cumsum(np.random.default_rng(seed).lognormal(-0.5 * spread**2, spread, len(t)))


def losing(t: np.ndarray, seed: int) -> np.ndarray:
    return t + t[1] * np.cumsum(np.random.default_rng(seed).random(len(t)) < 0.2 * (seed == 4))


@pytest.mark.parametrize("stamp", [jittered, losing])
def test_one_rate_on_another_clock_is_none_of_its_own(stamp):
    assert "rate" not in {m.rule for m in gate.remarks(clocks(400.0, 400.0, stamp))}


@pytest.mark.parametrize("noise", [0.0, 0.012])
def test_a_connector_that_lets_go_reads_one_level_but_for_noise(noise):
    rng = np.random.default_rng(3)

    def loose(r: Run) -> Run:
        y = r.tension_out_n.copy()
        for at in rng.integers(100, len(y) - 100, 9):
            y[at : at + 6] = noise * rng.standard_normal(6)
        return replace(r, tension_out_n=y)

    (said,) = gate.remarks(changed(loose, "act-b050"))
    assert (said.rule, said.run_ids) == ("filled", ("act-b050",)) and ("connector" in said.sentence) == (noise > 0.0)


def test_readings_that_are_no_tensions_fail_the_check_and_no_run():
    (run, *_) = rig()
    dates = np.random.default_rng(4).choice(len(run), 12, replace=False)
    y = run.tension_out_n.copy()
    y[dates] = 45000.0 + np.arange(12.0)

    def spikes(values: np.ndarray) -> list[samples.Finding]:
        columns = {"time_s": run.time_s, "tension_in_n": run.tension_in_n, "tension_out_n": values}
        return [f for f in samples.findings(samples.Piece("a", columns)) if f.what == "spikes"]

    (said,) = spikes(y)
    assert said.level == samples.FAILURE and "12 numbers of another kind" in said.detail and "interpolate" in said.fix
    assert not [r for r in gate.remarks([replace(run, tension_out_n=y)]) if r.failed]
    # interference that a rig may have
    y[dates] = 150.0
    assert [f.level for f in spikes(y)] == [samples.REMARK]
