"""``sstl watch`` as a user runs it: growing files, chunks, alarms with their likely cause, exit codes."""

from __future__ import annotations

import json
import re
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from program import inside
from watch_logs import HEAD, lines, loops, write

from sstl_cli.core import workers
from sstl_cli.core.provenance import Provenance
from sstl_cli.core.runs import Run, write_runs
from sstl_cli.core.tables import THETA
from sstl_cli.steps.watch_follow import Following

FRICTION = {"const_friction": {"w_l_n": 0.2}}


def sstl(*words, code=0):
    done = inside("watch", *words)
    assert done.returncode == code, (done.stdout, done.stderr)
    return done


def documents(done):
    return [json.loads(line) for line in done.stdout.splitlines()]


@pytest.fixture(scope="module")
def changed(tmp_path_factory):
    """Fourteen sound loops, then six with constant friction."""
    folder = tmp_path_factory.mktemp("changed")
    return write(folder / "log.csv", lines([loops(14, {}, 1), loops(6, FRICTION, 2, start_s=84.0)]))


@pytest.fixture(scope="module")
def model(tmp_path_factory):
    """A mapping trained on theta between 0.40 and 0.60, with the slopes of the capstan."""
    folder = tmp_path_factory.mktemp("model")
    rng = np.random.default_rng(0)
    rows = []
    for i, theta in enumerate(np.linspace(0.40, 0.60, 24)):
        for system, n in (("act", 1), ("sstl", 2)):
            noise = np.exp(0.004 * rng.standard_normal(2))
            rows.append(
                dict.fromkeys(THETA.names)
                | {
                    "run_id": f"{i}-{system}",
                    "config_id": f"c{i:02d}",
                    "system": system,
                    "location": "CP",
                    "gamma_p": np.exp(-n * theta) * noise[0],
                    "gamma_r": np.exp(n * theta) * noise[1],
                    "beta_p": 0.0,
                    "beta_r": 0.0,
                    "loops": 3,
                    "status": "ok",
                }
            )
    pq.write_table(pa.Table.from_pylist(rows, schema=THETA.arrow()), folder / "theta.parquet")
    command = ["train", "theta.parquet", "--variants", "linear", "--seeds", "1", "--out", "model.safetensors"]
    inside(*command, cwd=folder).check_returncode()
    return folder / "model.safetensors"


def test_a_change_is_found_and_named(changed):
    done = sstl(changed, "--once", "--learn", 10, "--json", "--fail-on-alarm", code=4)
    found = documents(done)
    seen = [d for d in found if d["schema"] == "sstl.watch.loop/1"]
    assert [d["loop"] for d in seen] == list(range(1, 21))
    assert all(d["status"] == "ok" and d["gap_n"] > 0 for d in seen)
    (alarm,) = [d for d in found if d["schema"] == "sstl.watch.alarm/1"]
    assert alarm["kind"] == "change" and alarm["began_with_loop"] in (14, 15) and alarm["loop"] <= 20
    likely = alarm["likely"]
    # one configuration, one speed: offset and constant friction are a documented tie
    assert likely["status"] in ("identified", "ambiguous")
    assert "const_friction" in {*likely["effects"], *likely["ambiguity_group"]}
    assert found[-1]["schema"] == "sstl.watch/1" and found[-1]["alarms"] == [alarm]


def test_the_lines_for_people_say_the_same(changed):
    done = sstl(changed, "--once", "--learn", 10, "--no-diagnose")
    assert "ALARM  act A:" in done.stdout and re.search(r"since loop 1[45]", done.stdout)
    assert "likely" not in done.stdout
    assert "one false alarm in 500 loops" in done.stderr


def test_no_change_no_alarm(tmp_path):
    path = write(tmp_path / "log.csv", lines([loops(22, {}, 5)]))
    done = sstl(path, "--once", "--learn", 10, "--fail-on-alarm")
    assert "22 loops" in done.stdout and "0 alarms" in done.stdout and "not armed" not in done.stdout


def test_without_enough_loops_no_alarm_means_nothing_and_it_says_so(tmp_path):
    path = write(tmp_path / "log.csv", lines([loops(7, {}, 5)]))
    done = sstl(path, "--once")
    assert "7 loops" in done.stdout and "not armed: act A 7 of 20 loops" in done.stdout and "0 alarms" not in done.stdout
    assert documents(sstl(path, "--once", "--json"))[-1]["not_armed"] == {"act A": 7}


@pytest.mark.slow
def test_another_bend_is_called_a_bend(tmp_path):
    path = write(tmp_path / "log.csv", lines([loops(13, {}, 1), loops(6, {}, 2, theta=0.60, start_s=78.0)]))
    done = sstl(path, "--once", "--learn", 10, "--json")
    (alarm,) = documents(done)[-1]["alarms"]
    assert alarm["likely"]["status"] == "retuned" and alarm["likely"]["effects"] == []
    assert alarm["likely"]["theta_before"] == pytest.approx(0.53, abs=0.01)
    assert alarm["likely"]["theta_now"] == pytest.approx(0.60, abs=0.01)


def test_inputs_outside_the_trained_range_are_an_alarm(tmp_path, model):
    near = lines([loops(3, {}, 1, system="sstl")], "sstl", "near", "s")
    act = lines([loops(2, {}, 2)], "act", "near", "a")
    far = lines([loops(3, {}, 3, theta=0.70, system="sstl")], "sstl", "far", "f")
    path = write(tmp_path / "log.csv", near + act + far)
    found = documents(sstl(path, "--once", "--model", model, "--json", "--fail-on-alarm", code=4))
    seen = {(d["config_id"], d["system"]): d for d in found if d["schema"] == "sstl.watch.loop/1"}
    assert seen["near", "sstl"]["range"] == "inside" and seen["far", "sstl"]["range"] == "outside"
    assert seen["near", "sstl"]["mapped"]["gamma_p"] == pytest.approx(np.exp(-0.53), rel=0.02)
    # the mapping is right, so its prediction of the act loop leaves little more than noise
    assert seen["near", "act"]["gap_against"] == "mapping" and seen["near", "act"]["gap_n"] < 0.15
    (alarm,) = found[-1]["alarms"]
    assert (alarm["kind"], alarm["config_id"]) == ("range", "far")


def test_a_simulator_is_the_measure_of_the_gap(tmp_path):
    rig = tmp_path / "rig.toml"
    rig.write_text('schema = "sstl.scenario/1"\n[[configurations]]\nid = "A"\ntheta = 0.53\n')
    path = write(tmp_path / "log.csv", lines([loops(3, {}, 1), loops(3, FRICTION, 2, start_s=18.0)]))
    found = [d for d in documents(sstl(path, "--once", "--sim", rig, "--json")) if d["schema"] == "sstl.watch.loop/1"]
    gaps = [d["gap_n"] for d in found]
    assert {d["gap_against"] for d in found} == {"simulator"}
    assert max(gaps[:3]) < 0.06 < 0.15 < min(gaps[3:])


def test_a_log_that_grows_is_followed_until_it_is_idle(tmp_path):
    path = tmp_path / "log.csv"
    rows = lines([loops(6, {}, 4)])

    def writer():
        with path.open("w") as file:
            file.write(HEAD)
            for k in range(0, len(rows), 150):
                text = "".join(rows[k : k + 150])
                # half of a line now, the other half later
                file.write(text[:-7])
                file.flush()
                time.sleep(0.02)
                file.write(text[-7:])
            file.flush()

    thread = threading.Thread(target=writer)
    thread.start()
    done = sstl(path, "--until-idle", 0.8, "--poll", 0.03, "--json")
    thread.join()
    once = sstl(path, "--once", "--json")
    assert documents(done) == documents(once)
    assert documents(done)[-1]["loops"] == 6


def test_chunks_of_a_folder_are_one_recording(tmp_path):
    t, a, b = loops(6, {}, 4)
    edges = [0, 500, 1100, len(t)]
    for k, (i, j) in enumerate(zip(edges[:-1], edges[1:], strict=True)):
        part = Run("r1", "act", t[i:j], a[i:j], b[i:j], config_id="A")
        write_runs(tmp_path / f"part{k}.parquet", [part], Provenance("test"))
    whole = (tmp_path / "part2.parquet").read_bytes()
    assert documents(sstl(tmp_path, "--once", "--json"))[-1]["loops"] == 6
    assert documents(sstl(tmp_path / "part*.parquet", "--once", "--json"))[-1]["loops"] == 6
    # the last file is still being written: what is whole counts
    (tmp_path / "part2.parquet").write_bytes(whole[: len(whole) // 2])
    done = sstl(tmp_path, "--once", "--json", code=3)
    assert documents(done)[-1]["loops"] == 3
    assert documents(done)[-1]["set_aside"] == {"file that cannot be read": 1}


def test_samples_set_aside_end_with_three(tmp_path):
    rows = lines([loops(3, {}, 1)])
    rows[100] = rows[100].rsplit(",", 1)[0] + ",nan\n"
    done = sstl(write(tmp_path / "log.csv", rows), "--once", code=3)
    assert "set aside: 1 (not a number)" in done.stderr


def test_nothing_to_read_is_a_failure(tmp_path):
    done = sstl(tmp_path / "none.csv", "--once", "--json", code=1)
    assert "none.csv: no sample was read" in done.stderr and done.stderr.count("no sample was read") == 1
    account, error = documents(done)
    assert account["samples"] == 0 and (error["schema"], error["code"]) == ("sstl.error/1", "E251")


def test_ctrl_c_is_the_usual_end(tmp_path):
    path = write(tmp_path / "log.csv", lines([loops(3, {}, 1)]))
    command = [sys.executable, "-m", "sstl_cli", "watch", str(path), "--poll", "0.05"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        first = process.stdout.readline()
        process.send_signal(signal.SIGINT)
        rest, notes = process.communicate(timeout=30)
    assert process.returncode == 0
    assert first.split()[:3] == ["1", "act", "A"] and re.search(r"not armed: act A [1-3] of 20 loops", rest)
    assert "interrupted" in notes and "Traceback" not in notes


def test_ctrl_c_with_another_face_or_lost_is_the_usual_end_too(tmp_path, monkeypatch):
    path = write(tmp_path / "log.csv", lines([loops(2, {}, 1)]))
    look = Following._look

    def compiled(following, last):
        yield from look(following, last)
        # what Python makes of an exception in code that returned all the same
        raise SystemError("returned a result with an exception set") from workers.Interrupted()

    monkeypatch.setattr(Following, "_look", compiled)
    done = sstl(path, "--poll", "0.05")
    assert "interrupted" in done.stderr and "not armed: act A" in done.stdout

    def lost(following, last):
        # where nothing can be raised, as while an object is taken down, the handler leaves no more than this
        monkeypatch.setattr(workers, "_asked", True)
        yield from look(following, last)

    monkeypatch.setattr(Following, "_look", lost)
    done = sstl(path, "--poll", "0.05")
    assert "interrupted" in done.stderr and "not armed: act A" in done.stdout


def test_wrong_use_is_told(tmp_path):
    assert "exclude one another" in sstl(tmp_path / "x.csv", "--once", "--until-idle", "3", code=2).stderr
