"""Progress: a bar appears by itself after a while, and moves with time where the steps of a work do not."""

from __future__ import annotations

import io
import time
from contextlib import contextmanager
from pathlib import Path

import pytest
from cli_calls import run_here

from sstl_cli.cli import _progress
from sstl_cli.cli._progress import Bar, Pace
from sstl_cli.cli.diagnose import PACE
from sstl_cli.cli.render import Screen
from tests import known_diagnoses

SAMPLE = Path(__file__).parents[2] / "data/samples/log.parquet"
# when a diagnosis had told which share of its steps, in s; the last is its end
RECORDED = [
    [(1.4, 0.0), (1.75, 0.1), (2.3, 0.2), (2.6, 0.4), (2.8, 0.5), (9.6, 0.6), (12.4, 0.7), (15.0, 0.8), (16.3, 0.9), (17.5, 0.9)],
    [(1.5, 0.0), (1.85, 0.1), (2.3, 0.2), (2.9, 0.4), (3.2, 0.5), (11.2, 0.6), (12.5, 0.7), (14.9, 0.8), (15.4, 0.8)],
    [(1.55, 0.0), (1.9, 0.1), (2.5, 0.2), (3.1, 0.4), (3.5, 0.5), (11.4, 0.6), (13.6, 0.7), (14.9, 0.8), (17.8, 0.9), (19.4, 0.9)],
]


def shown(trace, parts=1, at_part=0):
    """Where the bar stands every tenth of a second while a trace is played, and where time stands."""
    now = [0.0]
    pace = Pace(PACE, parts, clock=lambda: now[0])
    end, told, out = trace[-1][0], list(trace), []
    while now[0] < end:
        while told and told[0][0] <= now[0]:
            pace.told((at_part + told.pop(0)[1]) / parts)
        out.append((now[0] / end, pace.share()))
        now[0] += 0.1
    return out


@pytest.mark.parametrize("trace", RECORDED)
def test_a_diagnosis_moves_evenly(trace):
    found = shown(trace)
    assert max(abs(time - share) for time, share in found if time > 0.15) < 0.15
    shares = [share for _, share in found]
    assert shares == sorted(shares) and shares[-1] <= 1.0
    # it stands still for no more than a tenth of the time, though nothing is told for nearly half of it
    still = longest = 0
    for a, b in zip(shares, shares[1:], strict=False):
        still = still + 1 if a == b else 0
        longest = max(longest, still)
    assert longest < 0.12 * len(shares)


def test_work_that_is_slower_than_it_was_waits_for_its_next_step():
    now = [0.0]
    pace = Pace([(0.0, 0.0), (0.5, 0.5), (1.0, 1.0)], clock=lambda: now[0])
    now[0] = 1.0
    pace.told(0.25)
    now[0] = 100.0
    assert pace.share() == pytest.approx(0.5)
    pace.told(0.5)
    assert pace.share() == pytest.approx(0.5)


def test_work_that_is_done_twice_has_two_halves():
    now = [0.0]
    pace = Pace([(0.0, 0.0), (0.5, 0.2), (1.0, 1.0)], parts=2, clock=lambda: now[0])
    for told, gone in ((0.25, 0.1), (0.5, 0.5), (0.75, 0.6), (1.0, 1.0)):
        now[0] += 1.0
        pace.told(told)
        assert pace._gone(told) == pytest.approx(gone)
    assert pace.share() == pytest.approx(1.0)


@pytest.mark.slow
def test_a_diagnosis_tells_as_many_steps_as_the_bar_has(monkeypatch, capsys):
    told = []

    @contextmanager
    def progress(self, label, total=None, pace=None):
        yield lambda amount: told.append(amount / total)

    monkeypatch.setattr(Screen, "progress", progress)
    # what another test has asked tells no steps
    monkeypatch.setattr(known_diagnoses, "_found", {})
    assert run_here(monkeypatch, "diagnose", SAMPLE, "--effects", "pulley_friction,const_friction", "--max-effects", "1") == 0
    assert 0.75 < sum(told) <= 1.0 + 1e-9


class Terminal(io.StringIO):
    def isatty(self):
        return True


def test_work_that_tells_nothing_is_shown_too(monkeypatch):
    terminal = Terminal()
    monkeypatch.setattr("sys.stderr", terminal)
    monkeypatch.setattr(_progress, "SHOW_AFTER_S", 0.05)
    monkeypatch.setenv("TERM", "xterm")
    with Screen().progress("judging"):
        time.sleep(0.5)
    assert "judging" in terminal.getvalue()
    with Screen().progress("diagnosing", 1, Pace(PACE)) as advance:
        advance(0.5)
        time.sleep(0.5)
    # after half of the steps at once it has gone as far as the next step, and waits there
    assert "diagnosing" in terminal.getvalue() and "63%" in terminal.getvalue()


def test_short_work_shows_nothing(monkeypatch):
    terminal = Terminal()
    monkeypatch.setattr("sys.stderr", terminal)
    with Screen().progress("judging", 3) as advance:
        advance(1)
    assert terminal.getvalue() == ""


def test_a_bar_that_is_closed_before_it_is_drawn_stays_away():
    bar = Bar("x", 1)
    bar.close()
    bar._show()
    assert bar._bar is None
