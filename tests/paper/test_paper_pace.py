"""The progress of ``reproduce`` moves with time: which parts there are, and how long each takes beside the others."""

from contextlib import nullcontext
from unittest.mock import MagicMock

import pytest

from sstl_cli.cli._progress import Pace
from sstl_cli.paper import pace, reproduce
from sstl_cli.paper.chosen import DEFAULT, TABLES


def test_parts_are_those_that_are_run_in_their_order():
    assert list(pace.parts(DEFAULT, 5, 3, 2)) == ["I", "III", "IV", "gap", "diagnosis", "R"]
    # nothing is beside it: block R comes first, and the diagnosis has its table
    assert list(pace.parts(DEFAULT, 5, 3, 1))[-2:] == ["R", "diagnosis"]
    assert list(pace.parts(("II",), 5, 3, 2)) == ["I"]
    # figures need what is tracked, but no parts of the fit
    assert list(pace.parts(("figures",), 5, 3, 2)) == ["I", "III", "IV"]
    assert list(pace.parts(("probe",), 5, 3, 2)) == ["calibration", "probe"]
    assert list(pace.parts(TABLES, 5, 3, 2))[-8:] == ["diagnosis", "withheld", "R", "tendons", "calibration", "better", "probe", "distal"]
    assert list(pace.parts(("tendons",), 5, 3, 2)) == ["tendons"]


def test_seeds_cost_time_and_processes_save_it():
    def cost(part, *words):
        return pace.parts(DEFAULT, *words)[part]

    assert cost("III", 10, 3, 2) > cost("III", 5, 3, 2)
    assert cost("R", 5, 6, 1) == pytest.approx(2 * cost("R", 5, 3, 1))
    # another process began it with the parts before it
    paper = ("I", "II", "III", "IV", "R")
    before = sum(pace.parts(paper, 5, 3, 2)[part] for part in ("I", "III", "IV", "gap"))
    assert pace.parts(paper, 5, 3, 2)["R"] == pytest.approx(pace.parts(paper, 5, 3, 1)["R"] - before)
    assert pace.parts(paper, 5, 30, 4)["R"] < pace.parts(paper, 5, 30, 2)["R"] and pace.parts(paper, 5, 1, 2)["R"] == 1.0
    # the diagnosis waits for what is left of it
    assert cost("R", 5, 30, 2) == 1.0 and cost("diagnosis", 5, 30, 2) > cost("diagnosis", 5, 3, 2) > cost("diagnosis", 5, 3, 1)


def test_every_part_tells_all_of_itself(monkeypatch):
    """Every table with its work left out: what is told adds up to what the bar has."""
    for name in ("table_i_ii", "table_iii", "table_iv", "table_iv_gap", "diagnosed", "better", "probe", "tendons", "distal"):
        monkeypatch.setattr(reproduce, name, _Instead())
    monkeypatch.setattr(reproduce.data_seeds, "beside", _beside)
    monkeypatch.setattr(reproduce, "_rig", lambda made, drawn: made)
    monkeypatch.setattr(reproduce, "compare", lambda *_: [])
    monkeypatch.setattr(reproduce, "_judged", lambda *_: [])
    seconds = pace.parts(TABLES, 5, 3, 2)
    told = []
    reproduce.run(reproduce.Options(TABLES, workers=2), advance=told.append)
    assert sum(told) == pytest.approx(sum(seconds.values()))


class _Instead:
    """A module whose functions take their time to tell what they do, and return nothing that is looked at."""

    def __getattr__(self, name):
        return lambda *given, advance=None, **_: _tell(advance or (given[-1] if name == "run" and callable(given[-1]) else None))


def _tell(advance):
    for _ in range(4):
        if advance is not None:
            advance(0.25)
    return MagicMock()


def _beside(*_):
    return nullcontext(list)


def test_the_bar_follows_what_was_measured():
    """When a call with all tables told its parts (s since its beginning), two cores shared with other work."""
    told = {"I": 8, "III": 41, "IV": 46, "gap": 89, "diagnosis": 246, "R": 246}
    end = 252
    now = [0.0]
    seconds = pace.parts(DEFAULT, 5, 3, 2)
    bar = Pace(pace.curve(seconds), clock=lambda: now[0])
    done, far, still, before = 0.0, 0.0, 0, -1.0
    for now[0] in range(4, end):
        while told and now[0] >= min(told.values()):
            done += seconds[next(iter(told))]
            told.pop(next(iter(told)))
        bar.told(done / sum(seconds.values()))
        share = bar.share()
        far = max(far, abs(share - now[0] / end))
        still = max(still, 0 if share > before else still + 1)
        before = share
    assert far < 0.05 and still < 30


def test_the_bar_follows_parts_that_take_as_long_as_they_say():
    now = [0.0]
    seconds = pace.parts(DEFAULT, 5, 3, 2)
    whole = pace.LOADING_S + sum(seconds.values())
    bar = Pace(pace.curve(seconds), clock=lambda: now[0])
    ends, done = [], 0.0
    for name, length in seconds.items():
        ends.append((pace.LOADING_S + done, done))
        done += length
        assert length > 0, name
    far = 0.0
    while now[0] < whole:
        while ends and ends[0][0] <= now[0]:
            bar.told(ends.pop(0)[1] / done)
        if now[0] > pace.LOADING_S:
            far = max(far, abs(bar.share() - now[0] / whole))
        now[0] += 1.0
    assert far < 0.02
