"""Rows that were left out under the rate of all, and rows sorted by a tension that mostly rests."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from identification_loops import multisine, play
from identification_slips import lines

from sstl_cli.core.runs import Run
from sstl_cli.identification.gate import remarks

RATE = 100.0


def recorded(
    name: str, theta: float, system: str, seed: int, *, faster: int = 1, held: int = 1, lag_s: float = 0.0, movement: int = 7
) -> Run:
    """Return a run of one movement, played ``faster``, its output held for some samples and its input behind a reference by ``lag_s``."""
    n = 3000 // faster
    _, command = multisine(movement, 3.0, 26.0, seconds=90.0)
    command = command[::3]
    now = np.arange(n) / RATE
    x = np.interp((now - lag_s) * faster, np.arange(3000) / RATE, command)
    noise = 0.02 * np.random.default_rng(seed).standard_normal((2, n))
    y = (play(x, lines(theta * (2 if system == "sstl" else 1))) + noise[1])[np.arange(n) // held * held]
    reference = np.interp(now * faster, np.arange(3000) / RATE, command) if lag_s else None
    return Run(f"{system}-{name}", system, now, x + noise[0], y, config_id=name, tension_ref_n=reference)


def log(**how: float) -> list[Run]:
    bends = {"b020": 0.2, "b050": 0.4, "b080": 0.6}
    return [recorded(n, theta, s, i, **how) for i, ((n, theta), s) in enumerate((b, s) for b in bends.items() for s in ("act", "sstl"))]


def thinned(r: Run, k: int) -> Run:
    """Return every k-th row of a run under the stamps of the first ones."""
    n = len(r.tension_in_n[::k])
    reference = r.tension_ref_n[::k] if r.tension_ref_n is not None else None
    return replace(r, time_s=r.time_s[:n], tension_in_n=r.tension_in_n[::k], tension_out_n=r.tension_out_n[::k], tension_ref_n=reference)


def said(runs: list[Run]) -> list[tuple[tuple[str, ...], str]]:
    return [(r.run_ids, r.sentence) for r in remarks(runs) if r.rule == "rate"]


@pytest.mark.each_once
@pytest.mark.parametrize("how", [{"held": 4}, {"lag_s": 0.05}])
@pytest.mark.parametrize("k", [2, 3])
def test_rows_left_out_are_told_where_a_sensor_or_a_drive_keeps_time(how: dict[str, float], k: int) -> None:
    # on the same bend another movement was recorded as well
    runs = [*log(**how), replace(recorded("b050", 0.4, "act", 9, movement=8, **how), run_id="other")]
    ((ids, sentence),) = said([*runs[:2], thinned(runs[2], k), *runs[3:]])
    assert ids == ("act-b050",) and "probably holds every" in sentence
    # and a movement that was played faster is none of them
    assert said([*runs[:2], recorded("b050", 0.4, "act", 2, faster=k, **how), *runs[3:]]) == []


def test_rows_left_out_are_asked_for_where_nothing_tells_them_from_a_faster_movement() -> None:
    runs = log()
    for odd in (thinned(runs[2], 2), recorded("b050", 0.4, "act", 2, faster=2)):
        ((ids, sentence),) = said([*runs[:2], odd, *runs[3:]])
        assert ids == ("act-b050",) and sentence.endswith("or was this movement alone played 2 times as fast?")
    # a name of its own, a run of the usual speed beside it and other speeds of this name answer that
    named = [replace(r, trajectory="slow") for r in runs]
    assert said([*named[:2], replace(thinned(named[2], 2), trajectory="fast"), *named[3:]]) == []
    assert said([*runs, replace(thinned(runs[2], 2), run_id="again")]) == []
    assert said([*runs[:2], thinned(runs[2], 2), *runs[3:], replace(recorded("b020", 0.2, "act", 9, faster=4), run_id="fastest")]) == []


def around(name: str, theta: float, system: str, seed: int, loops: int, lag_s: float = 0.0) -> Run:
    """Return a run that goes round some times, 8 s each."""
    now = np.arange(800 * loops) / RATE
    x, command = (14.0 - 11.0 * np.cos(2.0 * np.pi * (now - late) / 8.0) for late in (lag_s, 0.0))
    noise = 0.02 * np.random.default_rng(seed).standard_normal((2, len(now)))
    y = play(x, lines(theta * (2 if system == "sstl" else 1))) + noise[1]
    return Run(
        f"{system}-{name}-{loops}",
        system,
        now,
        x + noise[0],
        y,
        config_id=name,
        trajectory="sine",
        tension_ref_n=command if lag_s else None,
    )


@pytest.mark.parametrize("lag_s", [0.0, 0.05])
def test_rows_left_out_are_seen_by_the_loop_however_often_each_run_goes_round(lag_s: float) -> None:
    bends = {"b020": 0.2, "b050": 0.4, "b080": 0.6}
    runs = [around(n, v, s, i, 2 + i % 3, lag_s) for i, ((n, v), s) in enumerate((b, s) for b in bends.items() for s in ("act", "sstl"))]
    assert said(runs) == []
    ((ids, sentence),) = said([*runs[:2], thinned(runs[2], 2), *runs[3:]])
    assert ids == (runs[2].run_id,) and "every second row" in sentence
    # beside a run of the usual speed only what keeps time tells it
    again = around("b050", 0.4, "act", 8, 3, lag_s)
    found = said([*runs[:2], thinned(runs[2], 2), *runs[3:], again])
    assert ["probably holds every second row" in sentence for _, sentence in found] == ([True] if lag_s else [])


@pytest.mark.each_once
@pytest.mark.parametrize("by", ["tension_in_n", "tension_out_n"])
@pytest.mark.parametrize("wrap", [0.4, 1.2])
def test_rows_sorted_by_a_tension_are_told_though_the_other_one_mostly_rests(by: str, wrap: float) -> None:
    t, x = multisine(3, 4.0, 20.0, seconds=40.0)
    noise = 0.01 * np.random.default_rng(2).standard_normal((2, len(t)))
    r = Run("r", "sstl", t, x + noise[0], play(x, lines(wrap)) + noise[1])
    at = np.argsort(getattr(r, by), kind="stable")
    assert "order" in [s.rule for s in remarks([replace(r, tension_in_n=r.tension_in_n[at], tension_out_n=r.tension_out_n[at])])]
    assert "order" not in [s.rule for s in remarks([r])]


def test_a_slow_pull_beside_a_noisy_output_is_in_order() -> None:
    # the command of a pull never falls, and the noise of the output goes to and fro at every sample
    x = 4.0 + 0.004 * np.arange(4000)
    for size in (0.0, 0.02, 0.05):
        y = 3.0 + 0.002 * np.arange(4000) + size * np.random.default_rng(2).standard_normal(4000)
        assert "order" not in [s.rule for s in remarks([Run("r", "act", np.arange(4000) / RATE, x, y)])]
