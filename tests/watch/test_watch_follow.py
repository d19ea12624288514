"""Growing files: what is whole counts once, whatever the writer does meanwhile."""

from __future__ import annotations

import os
from dataclasses import replace

import numpy as np
import pytest
from watch_logs import HEAD, lines, loops, write

from sstl_cli.core.errors import SstlError
from sstl_cli.core.runs import Run
from sstl_cli.importers.follow import TextFollower
from sstl_cli.importers.inline import inline_mapping
from sstl_cli.importers.mapping import Mapping
from sstl_cli.steps.watch import Loop, Watcher, WatchOptions


def times(pieces):
    return [float(t) for piece in pieces for t in piece.time_s]


def row(t, text="1.5"):
    return f"r,A,act,{t},{text},0.5\n"


def test_a_half_written_line_waits(tmp_path):
    path = tmp_path / "log.csv"
    follower = TextFollower(path, Mapping())
    assert list(follower.look()) == []
    path.write_text(HEAD + "".join(row(k) for k in range(10)) + "r,A,act,10,1.")
    assert times(follower.look()) == list(range(10))
    with path.open("a") as file:
        file.write("5,0.5\nr,A,a")
    assert times(follower.look()) == [10.0]
    assert times(follower.look(last=True)) == []


def test_a_file_cut_short_or_replaced_is_begun_anew(tmp_path):
    path = tmp_path / "log.csv"
    path.write_text(HEAD + "".join(row(k) for k in range(20)))
    follower = TextFollower(path, Mapping())
    assert len(times(follower.look())) == 20
    path.write_text(HEAD + "".join(row(100 + k) for k in range(12)))
    assert times(follower.look()) == [100.0 + k for k in range(12)]
    with path.open("a") as file:
        file.write(row(112))
    os.rename(path, tmp_path / "log.1")
    path.write_text(HEAD + "".join(row(200 + k) for k in range(9)))
    # the line written just before the file was renamed is not lost
    assert times(follower.look()) == [112.0, *(200.0 + k for k in range(9))]


@pytest.mark.parametrize("begin", [100, 0])
def test_a_file_written_over_while_what_was_read_is_worked_on_is_begun_anew(tmp_path, begin):
    path = tmp_path / "log.csv"
    path.write_text(HEAD + "".join(row(k) for k in range(20)))
    follower = TextFollower(path, Mapping())
    look = follower.look()
    assert times([next(look)]) == list(range(20))
    # in its place, or cut short and gone on, and longer than it was when it is read again
    after = [*range(begin, begin + 10), *range(200, 220)]
    path.write_text(HEAD + "".join(row(k) for k in after))
    assert times(look) == []
    assert times(follower.look()) == after
    assert follower.set_aside == {} and len(follower.notes) == 1


@pytest.mark.parametrize("renamed", [True, False])
def test_a_file_that_is_written_once_more_for_every_line_counts_each_once(tmp_path, renamed):
    path, rows = tmp_path / "log.csv", [row(k, "1." + "5" * 400) for k in range(300)]
    follower, found = TextFollower(path, Mapping()), []
    # more than a block of what is known by its digest, and less
    for n in (100, 101, 180, 300):
        text = HEAD + "".join(rows[:n])
        if renamed:
            (tmp_path / "new").write_text(text)
            os.replace(tmp_path / "new", path)
        else:
            # it may be looked at while it is not yet as long as it was
            for part in ("", text[:150], text[: len(text) // 3]):
                path.write_text(part)
                found += times(follower.look()) if len(found) else []
            path.write_text(text)
        found += times(follower.look())
    assert found == list(range(300)) and follower.restarts == 0
    rows[7] = row(7, "2." + "5" * 400)
    path.write_text(HEAD + "".join(rows))
    other = tmp_path / "new"
    other.write_text(HEAD + "".join(rows) + row(300))
    os.replace(other, path)
    # one reading is another one: it is another log
    assert times(follower.look()) == list(range(301)) and follower.restarts == 1
    assert follower.notes == [f"{path} was begun anew; what follows is another run"]


def test_a_long_preamble_is_waited_for(tmp_path):
    path = tmp_path / "log.csv"
    path.write_text("# a word\n" * 12)
    follower = TextFollower(path, Mapping())
    assert list(follower.look()) == []
    path.write_text("# a word\n" * 12 + HEAD)
    assert list(follower.look()) == []
    path.write_text("# a word\n" * 12 + HEAD + "".join(row(k) for k in range(9)))
    assert times(follower.look()) == list(range(9))


def test_a_file_renamed_before_its_columns_are_known_does_not_lend_its_name(tmp_path):
    path = tmp_path / "log.csv"
    path.write_text(HEAD + row(0) + row(1))
    follower = TextFollower(path, Mapping())
    assert list(follower.look()) == []
    os.rename(path, tmp_path / "log.1")
    # another order of columns: with it the lines of the old file would be read wrongly
    path.write_text("time_s,run_id,config_id,system,tension_in_n,tension_out_n\n" + "".join(f"{k},r,A,act,1.5,0.5\n" for k in range(9)))
    assert times(follower.look()) == list(range(9)) and follower.set_aside == {}


def test_a_pipe_is_refused_at_once(tmp_path):
    os.mkfifo(tmp_path / "log.csv")
    with pytest.raises(SstlError, match="E356.*regular file"):
        list(TextFollower(tmp_path / "log.csv", Mapping()).look())


def test_cells_without_a_number_and_broken_lines(tmp_path):
    path = tmp_path / "log.csv"
    rows = [row(k) for k in range(12)]
    rows[5], rows[7], rows[8] = row(5, "oops"), "r,A,act,7\n", row(8, "nan")
    path.write_text(HEAD + "".join(rows))
    follower = TextFollower(path, Mapping())
    pieces = list(follower.look())
    assert times(pieces) == [0, 1, 2, 3, 4, 5, 6, 8, 9, 10, 11]
    assert np.isnan(pieces[0].tension_in_n[[5, 7]]).all() and np.isfinite(np.delete(pieces[0].tension_in_n, [5, 7])).all()
    assert follower.set_aside == {"lines of another width": 1}


def test_bytes_of_another_encoding_cost_their_cell_or_line_alone(tmp_path):
    """They were an internal error, and of a line of nothing else a traceback."""
    path = tmp_path / "log.csv"
    rows = [row(k).encode() for k in range(12)]
    rows[5], rows[7], rows[8] = b"r,A,act,5,1.5\xe9,0.5\n", bytes(range(128, 256)) + b"\n", b"r\xe9,A,act,8,1.5,0.5\n"
    path.write_bytes(HEAD.encode() + b"".join(rows))
    follower = TextFollower(path, Mapping())
    pieces = list(follower.look())
    assert sorted(times(pieces)) == [0, 1, 2, 3, 4, 5, 6, 8, 9, 10, 11] and {p.run_id for p in pieces} == {"r", "r\ufffd"}
    assert np.isnan(pieces[0].tension_in_n[5]) and follower.set_aside == {"lines of another width": 1}


def test_a_mapping_gives_units_and_labels(tmp_path):
    path = tmp_path / "bend_040.txt"
    path.write_text("".join(f"{1000 + 2 * k} {k / 10} {k / 20}\n" for k in range(12)))
    mapping = inline_mapping("time_s=col1:ms,tension_in_n=col2:kN,tension_out_n=col3:N,system=sstl")
    pieces = list(TextFollower(path, mapping).look())
    assert times(pieces) == pytest.approx([1.0 + 0.002 * k for k in range(12)])
    assert pieces[0].tension_in_n == pytest.approx([100.0 * k for k in range(12)])
    assert (pieces[0].system, pieces[0].run_id) == ("sstl", "bend_040")


def test_runs_may_take_turns(tmp_path):
    path = tmp_path / "log.csv"
    text = "".join(f"r{k % 2},A,{'act' if k % 2 else 'sstl'},{k},1,1\n" for k in range(10))
    path.write_text(HEAD + text)
    pieces = {p.system: times([p]) for p in TextFollower(path, Mapping()).look()}
    assert pieces == {"sstl": [0, 2, 4, 6, 8], "act": [1, 3, 5, 7, 9]}


def test_what_is_no_text_is_refused(tmp_path):
    path = tmp_path / "log.npz"
    np.savez(path, time_s=np.arange(50.0))
    with pytest.raises(SstlError, match="cannot grow in place"):
        list(TextFollower(path, Mapping()).look(last=True))


def run_of(part, run_id="r1"):
    return Run(run_id, "act", *part, config_id="A")


def cut(run, a, b):
    return Run(run.run_id, run.system, run.time_s[a:b], run.tension_in_n[a:b], run.tension_out_n[a:b], config_id="A")


def watched(pieces):
    watcher = Watcher(WatchOptions())
    events = [e for piece in pieces for e in watcher.feed(piece)]
    return watcher, [*events, *watcher.end()]


def test_the_same_samples_give_the_same_loops_however_they_arrive():
    run = run_of(loops(6, {}, 1))
    _, whole = watched([run])
    rng = np.random.default_rng(0)
    edges = [0, *np.sort(rng.choice(np.arange(1, len(run)), 60, replace=False)).tolist(), len(run)]
    _, pieces = watched([cut(run, a, b) for a, b in zip(edges[:-1], edges[1:], strict=True)])
    assert len(whole) == 6
    assert [e.document() for e in whole] == [e.document() for e in pieces]
    # every loop reaches from bottom to bottom
    assert [float(e.run.time_s[-1]) for e in whole] == pytest.approx([6.0 * k for k in range(1, 7)], abs=0.35)


def test_slopes_of_a_loop_are_those_of_the_capstan():
    _, found = watched([run_of(loops(3, {}, 1))])
    for loop in found[1:]:
        theta, se = loop.segmentation.theta, loop.segmentation.theta_se
        assert abs(theta["gamma_p"] - np.exp(-0.53)) < 4 * se["gamma_p"] + 1e-3
        assert abs(theta["gamma_r"] - np.exp(0.53)) < 4 * se["gamma_r"] + 3e-3


def test_nan_and_backward_stamps_are_counted_and_change_no_loop():
    t, a, b = loops(5, {}, 2)
    clean, expected = watched([run_of((t, a, b))])
    a = a.copy()
    a[400] = np.nan
    t = t.copy()
    t[[700, 701]] = t[[600, 601]]
    watcher, found = watched([run_of((t, a, b))])
    assert watcher.intake.set_aside == {"not a number": 1, "time repeats or runs backwards": 2}
    assert len(found) == len(expected) == 5 and clean.intake.set_aside == {}
    for x, y in zip(found, expected, strict=True):
        assert x.segmentation.theta["gamma_p"] == pytest.approx(y.segmentation.theta["gamma_p"], abs=0.003)


@pytest.mark.parametrize("shrink", [1e-12, 1e-310])
def test_a_clock_faster_than_any_recorder_is_set_aside(shrink):
    t, a, b = loops(3, {}, 2)
    watcher, found = watched([run_of((t * shrink, a, b))])
    assert not found and all("faster than any recorder" in why for why in watcher.intake.set_aside)
    assert sum(watcher.intake.set_aside.values()) >= len(t) - 64


def test_a_clock_set_back_begins_a_new_stretch():
    t, a, b = loops(4, {}, 3)
    half = 450
    t = np.where(np.arange(len(t)) < half, t, t - t[half])
    watcher, found = watched([run_of((t, a, b))])
    assert watcher.intake.breaks == 1
    assert all(np.all(np.diff(e.run.time_s) > 0) for e in found)
    # the loop in which the clock was set back is lost, no other
    assert len([e for e in found if isinstance(e, Loop) and len(e.run) > 250]) == 3


def test_a_new_run_of_the_same_rig_ends_the_one_before():
    watcher = Watcher(WatchOptions())
    first = list(watcher.feed(run_of(loops(1, {}, 1), "r1")))
    assert first == []
    (loop,) = watcher.feed(run_of(loops(1, {}, 2), "r2"))
    assert loop.run.run_id == "r1"
    assert [e.run.run_id for e in watcher.end()] == ["r2"]


def test_write_helper_round_trip(tmp_path):
    path = write(tmp_path / "log.csv", lines([loops(1, {}, 1)]))
    assert len(times(TextFollower(path, Mapping()).look(last=True))) == 300


def test_only_one_tendon_goes_into_a_naming():
    watcher = Watcher(WatchOptions(learn=10))
    part = loops(14, {}, 1)
    changed = loops(5, {"const_friction": {"w_l_n": 0.3}}, 2, start_s=84.0)
    alarms = []
    for tendon, parts in (("B", [part]), ("A", [part, changed])):
        for piece in parts:
            events = watcher.feed(replace(run_of(piece, f"run-{tendon}"), tendon=tendon))
            alarms += [e for e in events if not isinstance(e, Loop)]
    (alarm,) = alarms
    assert alarm.stream == "act A A"
    before, since = watcher.around(alarm)
    assert before and since and {k.run.tendon for k in [*before, *since]} == {"A"}
