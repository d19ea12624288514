"""Windows of holds, which of them count and what they leave possible, by hand and by dense linear algebra."""

from __future__ import annotations

from dataclasses import dataclass
from dataclasses import replace as changed
from types import SimpleNamespace

import numpy as np
import pytest
from made_windows import Held, coloured
from scipy.stats import chi2

from sstl_cli.diagnosis import holds
from sstl_cli.diagnosis.constants import ALIKE, AT_MOST, CORRELATIONS_S, LEAST_WINDOWS, LEVELS, MEASURED, SHORTEST_WINDOW
from sstl_cli.diagnosis.whitening import step_of

RNG = np.random.default_rng(20)
SECOND = 100


def of_windows(squares, free=8, nats=None):
    """Return costs of one level on windows with these whitened squares."""
    return np.stack((0.5 * np.asarray(squares) if nats is None else nats, squares), axis=1)[None]


def holding(*lengths):
    """Return a record of holds of so many samples, a slide of one sample behind each, and where it slides."""
    held = [np.append(np.zeros(n), 1.0) for n in lengths]
    return Held(np.arange(sum(lengths) + float(len(lengths)))), np.concatenate(held)


@pytest.mark.parametrize("readings", [1, 3])
def test_the_cost_of_a_window_with_missing_readings_is_the_dense_restricted_likelihood_of_those_it_has(readings):
    n, length_s, tau = 12, 0.06, 0.2
    rows = RNG.standard_normal((4, n))
    rows[1, 3], rows[2, [0, 5, 6]] = np.nan, np.nan
    # each reading of a window is the mean of so many of a first-order noise
    fine = np.arange(n * readings)
    sample = np.exp(-np.abs(np.subtract.outer(fine, fine)) * length_s / readings / tau)
    mean = np.kron(np.eye(n), np.full((1, readings), 1.0 / readings))
    whites, levels = np.array([0.3, 0.2, 0.4]), np.array([0.1, 0.5, 0.9])
    found = holds._window_costs(rows, whites, levels, step_of(float(readings), length_s / tau))
    assert found.shape == (3, 4, 2)
    for k, (white, level) in enumerate(zip(whites, levels, strict=True)):
        for row, (nats, square) in zip(rows, found[k], strict=True):
            read = np.isfinite(row)
            sigma = (level**2 * mean @ sample @ mean.T + white**2 * np.eye(n))[np.ix_(read, read)]
            # any basis of what is free of a straight line
            away = np.linalg.svd(np.vander(np.arange(n)[read], 2))[0][:, 2:]
            inner, x = away.T @ sigma @ away, away.T @ row[read]
            expected = float(x @ np.linalg.solve(inner, x))
            assert square == pytest.approx(expected) and nats == pytest.approx(0.5 * (expected + np.linalg.slogdet(inner)[1]))


def test_windows_of_a_hold_have_to_have_enough_readings():
    y, held = np.arange(24.0), np.ones(24, bool)
    # three windows of eight readings fill a hold of 24, and the last sample of a hold counts
    assert [p[0] for p in holds._pieces(y, held, 8)] == [0.0, 8.0, 16.0]
    assert [p[0] for p in holds._pieces(y[:23], held[:23], 8)] == [0.0, 8.0]
    sparse = np.where(np.isin(np.arange(24), [1, 2, 13, 14, 15]), np.nan, y)
    # of twelve readings eight are enough
    assert [np.isfinite(p).sum() for p in holds._pieces(sparse, held, 12)] == [10, 9]
    sparse[[3, 4, 16, 17]] = np.nan
    assert [np.isfinite(p).sum() for p in holds._pieces(sparse, held, 12)] == [SHORTEST_WINDOW]


@pytest.mark.parametrize(
    ("lengths", "length", "count"),
    [
        ([3 * SECOND] * LEAST_WINDOWS, 3 * SECOND, LEAST_WINDOWS),
        # one too few of three seconds: windows of a second, three of which fit into each
        ([3 * SECOND] * (LEAST_WINDOWS - 1), SECOND, 3 * (LEAST_WINDOWS - 1)),
        ([SECOND - 1] * 4, 40, 8),
        ([40], 40, 1),
        ([39], 40, 0),
    ],
)
def test_windows_are_the_longest_of_which_there_are_enough(lengths, length, count):
    record, slide = holding(*lengths)
    windows = holds._windows([record], [slide])
    assert windows.rows.shape == (count, length) and len(windows.slow) == count
    assert windows.free.tolist() == [length - 2.0] * count
    # what has no weight was not read
    if count:
        blind = changed(record, read=(np.arange(len(record)) != 1).astype(float))
        assert holds._windows([blind], [slide]).free[0] == length - 3.0


def test_windows_of_louder_runs_are_brought_to_the_noise_of_the_others():
    record, slide = holding(*[3 * SECOND] * LEAST_WINDOWS)
    loud = changed(record, louder=4.0, slower=6.0)
    plain, quieter = (holds._windows([r], [slide]) for r in (record, loud))
    assert quieter.rows == pytest.approx(plain.rows / 4.0) and set(plain.slow) == {1.0} and set(quieter.slow) == {1.5}
    # a step at the analysis rate is as many of the simulation's as the factor says
    coarse = changed(record, factor=3)
    assert holds._windows([coarse], [slide]).rows.shape[1] == SECOND


def test_costs_are_those_of_every_white_noise_time_and_level():
    record, slide = holding(*[3 * SECOND] * LEAST_WINDOWS)
    record = changed(record, y=0.1 * RNG.standard_normal(len(record)), factor=1)
    mixed = holds._windows([record, changed(record, slower=2.0)], [slide, slide])
    whites, levels = np.array([0.1, 0.2]), np.array([0.05, 0.1, 0.3])
    found = holds._costs(mixed, record, whites, levels)
    assert found.shape == (2, len(CORRELATIONS_S) * 3, 2 * LEAST_WINDOWS, 2)
    for i, white in enumerate(whites):
        for k, tau in enumerate(CORRELATIONS_S):
            for slow in (1.0, 2.0):
                at = mixed.slow == slow
                own = holds._window_costs(mixed.rows[at], white, slow * levels, step_of(1.0, 0.01 / tau))
                assert found[i, 3 * k : 3 * k + 3, at] == pytest.approx(own.swapaxes(0, 1))
    # white noise is that of a reading, of several in a sample there is less
    several = SimpleNamespace(readings=np.full(5, 4.0), dt_s=0.01, factor=1)
    own = holds._window_costs(mixed.rows[:1], 0.05, levels, step_of(4.0, 0.01 / CORRELATIONS_S[0]))
    assert holds._costs(mixed, several, whites[:1], levels)[0, :3, :1] == pytest.approx(own)


def test_windows_count_that_noise_alone_can_have_made():
    free, n = np.full(10, 8.0), 10
    # the largest of ten windows exceeds this in half of all cases
    most = chi2.isf(0.5 / n, 8)
    squares = np.concatenate((np.linspace(5.0, 12.0, 8), [0.999 * most, 1.001 * most]))
    assert holds._undisturbed(of_windows(squares), free).tolist() == [True] * 9 + [False]
    # too few that noise can have made: those of the quieter half
    loud = np.where(np.arange(10) < LEAST_WINDOWS - 1, np.arange(10.0) + 1.0, 1e3 + np.arange(10.0))
    assert holds._undisturbed(of_windows(loud), free).tolist() == [True] * 5 + [False] * 5
    # with one more there are enough
    loud[LEAST_WINDOWS - 1] = 6.0
    assert holds._undisturbed(of_windows(loud), free).tolist() == [True] * 6 + [False] * 4


def test_windows_are_judged_by_the_level_that_the_kept_ones_like():
    free = np.full(8, 8.0)
    # the first level leaves far too much, the second what noise makes; the quieter half by the first likes the second
    first, second = np.linspace(80.0, 150.0, 8), np.array([8.0] * 7 + [90.0])
    costs = np.concatenate((of_windows(first, nats=np.full(8, 50.0)), of_windows(second, nats=np.full(8, 9.0))))
    assert holds._undisturbed(costs, free).tolist() == [True] * 7 + [False]
    # quiet is by degrees of freedom, not by squares: seven windows of 22 readings are, five of 10 are not
    free, long = np.repeat([20.0, 8.0], [7, 5]), np.repeat([True, False], [7, 5])
    costs = np.concatenate(
        (
            of_windows(np.where(long, 20.0, 25.0), nats=np.where(long, 0.0, 10.0)),
            of_windows(np.where(long, 99.0, 8.0), nats=np.where(long, 5.0, 0.0)),
        )
    )
    assert holds._undisturbed(costs, free).tolist() == long.tolist()


def test_what_windows_leave_possible_is_weighed_with_what_is_usual():
    levels, usual = [0.01, 0.02, 0.08], 0.02
    tries = [(c, tau) for tau in (0.1, 0.4) for c in levels]
    nats = np.array([3.0, 2.0, 6.0, 3.5, 2.6, 4.0])
    price = [nats[i] + np.log(1.0 + (np.log(c / usual) / ALIKE) ** 2) for i, (c, _) in enumerate(tries)]
    weight = np.exp(-np.array(price))
    weight /= weight.sum()
    logs = np.log([c for c, _ in tries])
    centre = float(np.sum(weight * logs))
    spread = np.sqrt(np.sum(weight * (logs - centre) ** 2))
    found, cost = holds._believed(tries, nats, usual)
    assert found.coloured_n == pytest.approx(np.exp(centre)) and found.spread == pytest.approx(np.clip(spread, MEASURED, ALIKE))
    assert cost == pytest.approx(-np.log(np.mean(np.exp(-np.array(price)))))
    # its time is the likelier one of the level nearest to what is believed
    assert abs(np.log(0.02) - centre) < 0.2 and found.correlation_s == 0.1
    slower = holds._believed(tries, np.array([3.0, 3.6, 6.0, 3.5, 2.6, 4.0]), usual)[0]
    assert slower.correlation_s == 0.4
    # what windows are sure of is known as well as holds show it at best, and what they do not say as two sensors are alike
    assert holds._believed(tries, np.array([0.0, 90.0, 90.0, 90.0, 90.0, 90.0]), usual)[0] == holds.Held(pytest.approx(0.01), 0.1, MEASURED)
    assert holds._believed(tries, np.zeros(6), 0.001)[0].spread == ALIKE


def test_an_input_moves_where_it_goes_further_than_its_noise_while_a_window_lasts():
    # 0.4 s at 0.75 N/s are 0.3 N: three times a noise of 0.1 N
    rate = np.repeat([0.74, 0.76, -0.76, 0.0], 2)
    record = SimpleNamespace(rate=rate, factor=2)
    assert holds.moving(record, 0.4 * 0.75 / AT_MOST).tolist() == [0.0, 1.0, 1.0, 0.0]


@dataclass
class Driven:
    raw: SimpleNamespace
    y: np.ndarray
    thin: int = 2
    factor: int = 3
    louder: float = 2.0
    slower: float = 3.0

    def __len__(self):
        return len(self.y)


def test_the_input_of_a_record_stands_in_the_place_of_its_output():
    tension = RNG.standard_normal(20)
    found = holds.of_input(Driven(SimpleNamespace(tension_in_n=tension), np.zeros(3)))
    assert found.y == pytest.approx([tension[:6].mean(), tension[6:12].mean(), tension[12:18].mean()])
    assert (found.louder, found.slower) == (1.0, 1.0)


def test_of_two_sets_of_holds_the_likelier_is_the_one_with_less_left():
    lengths = [3 * SECOND] * LEAST_WINDOWS
    record, slide = holding(*lengths)
    quiet = changed(record, y=0.03 * RNG.standard_normal(len(record)))
    wandering = changed(quiet, y=quiet.y + coloured(RNG, len(quiet), 0.01, 0.1, 0.2))
    levels = 0.03 * LEVELS
    assert holds.likelier([quiet], [wandering], [slide], 0.03, levels) and not holds.likelier([wandering], [quiet], [slide], 0.03, levels)
    # which is as likely is not likelier, and too few windows say nothing
    assert not holds.likelier([quiet], [quiet], [slide], 0.03, levels)
    short, slides = holding(*[40] * (LEAST_WINDOWS - 1))
    still, loud = (changed(short, y=k * RNG.standard_normal(len(short))) for k in (0.03, 0.3))
    assert not holds.likelier([still], [loud], [slides], 0.03, levels)
