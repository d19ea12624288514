"""What no recorder can have measured is set aside, pauses end a run, and the work stays bounded by the samples."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sstl_cli.core.aside import _LEDGER, open_ledger
from sstl_cli.core.provenance import Provenance
from sstl_cli.core.runs import Run, read_runs, recorded_runs, write_runs
from sstl_cli.core.sound import cuts, sound, unsound, why_unsound


def make(n: int = 200, **more: object) -> Run:
    t = np.arange(n) * 0.01
    return Run(**{"run_id": "a", "system": "act", "time_s": t, "tension_in_n": 5 + np.sin(t), "tension_out_n": 3 + t, **more})


def test_a_good_run_passes_untouched() -> None:
    run = make(position_in_mm=np.full(200, np.nan))
    pieces, aside = sound(run)
    assert pieces[0] is run and not aside


@pytest.mark.parametrize(
    ("value", "why"),
    [(np.nan, "not a number"), (np.inf, "infinite"), (-np.inf, "infinite"), (1e308, "beyond any sensor"), (-2e15, "beyond")],
)
@pytest.mark.parametrize("channel", ["tension_in_n", "tension_out_n"])
def test_samples_no_sensor_can_give_go_with_all_their_channels(channel: str, value: float, why: str) -> None:
    values = getattr(make(), channel).copy()
    values[[3, 7]] = value
    [piece], [entry] = sound(make(**{channel: values}, position_in_mm=np.arange(200.0), extra={"x": np.arange(200.0)}))
    assert (entry.samples, entry.of, entry.run_id) == (2, 200, "a") and why in entry.why and channel in entry.why
    assert len(piece) == 198 and not {3.0, 7.0} & set(piece.position_in_mm) and not {3.0, 7.0} & set(piece.extra["x"])


def test_all_of_it_unsound_leaves_a_run_without_samples() -> None:
    [piece], [entry] = sound(make(tension_in_n=np.full(200, np.inf)))
    assert len(piece) == 0 and piece.run_id == "a" and entry.samples == 200


@pytest.mark.parametrize(
    ("change", "why"),
    [
        (lambda r: replace(r, tension_in_n=r.tension_in_n * 1e-320), "tension_in_n never exceeds"),
        (lambda r: replace(r, tension_out_n=r.tension_out_n * 1e-13), "tension_out_n never exceeds"),
        (lambda r: replace(r, time_s=np.arange(200) * 5e-324), "faster than any recorder"),
        (lambda r: replace(r, time_s=r.time_s * 1e9 + 1.7e18), "beyond any clock"),
    ],
)
def test_runs_in_no_possible_unit(change, why: str) -> None:
    [piece], [entry] = sound(change(make()))
    assert len(piece) == 0 and entry.samples == 200 and why in entry.why


def test_a_silent_channel_is_no_wrong_unit() -> None:
    assert sound(make(tension_out_n=np.zeros(200)))[1] == []


def test_other_channels_lose_only_the_value() -> None:
    position = np.arange(200.0)
    position[[5, 6]] = np.inf, 1e300
    [piece], [entry] = sound(make(position_in_mm=position))
    assert len(piece) == 200 and np.isnan(piece.position_in_mm[[5, 6]]).all() and entry.samples == 2
    assert np.isinf(position[5])


@pytest.mark.parametrize("pause", [1.5, 3600.0, 86400.0, 1.7e9])
def test_a_pause_ends_the_run(pause: float) -> None:
    time = np.arange(200) * 0.01
    time[120:] += pause
    pieces, [entry] = sound(make(time_s=time))
    assert [(p.run_id, len(p)) for p in pieces] == [("a", 120), ("a~2", 80)]
    assert np.array_equal(np.concatenate([p.tension_out_n for p in pieces]), make().tension_out_n)
    assert entry.samples == 0 and "1 pause" in entry.why


def test_stretches_too_short_between_pauses_are_counted() -> None:
    time = np.arange(200) * 0.01 + 100.0 * (np.arange(200) >= 100) + 100.0 * (np.arange(200) >= 110)
    pieces, aside = sound(make(time_s=time))
    assert [len(p) for p in pieces] == [100, 90] and [e.samples for e in aside] == [0, 10]


def test_short_gaps_and_jitter_and_time_that_runs_back_cut_nothing() -> None:
    time = np.arange(200) * 0.01
    time[100:] += 0.9
    assert not len(cuts(time))
    assert not len(cuts(np.sort(np.random.default_rng(0).uniform(0, 2, 400))))
    assert not len(cuts(np.array([0.0, 1, 2, 3, 4, 1e9, 5, 6])))
    assert not len(cuts(np.array([0.0, 1e9]))) and not len(cuts(np.empty(0)))


@settings(max_examples=200, deadline=None)
@given(st.lists(st.tuples(st.sampled_from([1e-9, 1e-6, 1e-3, 0.5, 0.9, 3.0, 1e3, 1e9]), st.integers(1, 60)), min_size=1, max_size=12))
def test_an_even_grid_over_any_piece_is_bounded_by_its_samples(steps: list) -> None:
    time = np.cumsum(np.concatenate([np.full(n, s) for s, n in steps]))
    edges = [0, *cuts(time).tolist(), len(time)]
    for a, b in zip(edges[:-1], edges[1:], strict=True):
        if b - a > 2 and np.all(np.diff(time[a:b]) > 0):
            step = np.diff(time[a:b])
            assert step.sum() / np.median(step) <= 11.0 * (b - a)


def test_unsound_and_why() -> None:
    values = np.array([1.0, np.nan, np.inf, -1e16, 1e15])
    assert unsound(values).tolist() == [False, True, True, True, False]
    assert why_unsound("time_s", values) == {"not a number": 1, "infinite": 1, "beyond any clock (over 1e+15)": 1}


def test_reading_notes_what_it_sets_aside(tmp_path: Path) -> None:
    x = np.full(50, 2.0)
    x[4] = np.inf
    write_runs(tmp_path / "l.parquet", [make(), make(50, run_id="b", tension_in_n=x)], Provenance("test"))
    book = open_ledger()
    assert [len(r) for r in read_runs(tmp_path / "l.parquet")] == [200, 49]
    assert [str(e) for e in book.entries] == ["run b: 1 of 50 samples: 1 infinite in tension_in_n"]
    _LEDGER.set(None)
    with pytest.warns(UserWarning, match="run b: 1 of 50 samples"):
        list(read_runs(tmp_path / "l.parquet"))
    assert [len(r) for r in recorded_runs(tmp_path / "l.parquet")] == [200, 50] and len(book.entries) == 1
