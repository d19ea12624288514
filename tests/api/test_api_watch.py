"""Following logs from Python tells what the program tells, as it comes; so do the installation and the schemas."""

from __future__ import annotations

import json
from itertools import takewhile
from pathlib import Path

import numpy as np
import pytest
from program import inside

import sstl_cli as sstl

HZ, PERIOD_S = 50.0, 6.0


def rows(count: int, slope: float, start: int = 0) -> str:
    """Loops of a line with two slopes, with noise, as the lines of a CSV."""
    t = np.arange(start * 300, (start + count) * 300) / HZ
    pull = np.interp(t % PERIOD_S, [0.0, 2.7, 3.0, 5.7, PERIOD_S], [2.0, 20.0, 20.0, 2.0, 2.0])
    out = np.empty_like(pull)
    at = slope * pull[0]
    for k, x in enumerate(pull):
        at = out[k] = min(max(at, slope * x), x / slope)
    noise = 0.02 * np.random.default_rng(start).standard_normal((2, len(t)))
    return "".join(f"r1,A,act,{a:.4f},{b:.5f},{c:.5f}\n" for a, b, c in zip(t, pull + noise[0], out + noise[1], strict=True))


HEAD = "run_id,config_id,system,time_s,tension_in_n,tension_out_n\n"


def test_a_log_gives_the_documents_of_the_command(tmp_path: Path) -> None:
    log = tmp_path / "log.csv"
    log.write_text(HEAD + rows(14, 0.7) + rows(12, 0.6, 14))
    told = list(sstl.watch(log, learn=10, diagnose=False, once=True))
    done = inside("watch", log, "--learn", 10, "--no-diagnose", "--once", "--json")
    assert [d.plain() for d in told] == [json.loads(line) for line in done.stdout.splitlines()]
    (alarm,) = [d for d in told if isinstance(d, sstl.AlarmDocument)]
    assert alarm.began_with_loop in (14, 15, 16) and isinstance(told[-1], sstl.WatchDocument) and told[-1].alarms == [alarm]


def test_a_change_is_named_as_the_diagnosis_of_the_loops_says(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from sstl_cli.steps import watch_follow
    from sstl_cli.steps.watch_name import Naming

    asked: list[tuple[int, int, object]] = []

    def name_change(before: list, since: list, sim: object) -> Naming:
        asked.append((len(before), len(since), sim))
        return Naming("identified", ("zero_offset",), ("zero_offset",), 0.9, None, "a test says so")

    monkeypatch.setattr(watch_follow, "name_change", name_change)
    log = tmp_path / "log.csv"
    log.write_text(HEAD + rows(14, 0.7) + rows(12, 0.6, 14))
    told = list(sstl.watch(log, learn=10, once=True, sim="sample"))
    place, alarm = next((k, d) for k, d in enumerate(told) if isinstance(d, sstl.AlarmDocument))
    assert alarm.likely is not None and alarm.likely.effects == ["zero_offset"] and len(asked) == 1
    assert asked[0][:2] == (1, 1) and isinstance(asked[0][2], sstl.Scenario)
    # four loops since the change, not at the end of the log
    assert sum(isinstance(d, sstl.LoopDocument) for d in told[:place]) < 26


def test_a_file_that_grows_is_followed_until_it_is_idle(tmp_path: Path) -> None:
    log = tmp_path / "log.csv"
    log.write_text(HEAD + rows(3, 0.7))
    following = sstl.watch(log, until_idle=1.0, poll=0.05)
    first = next(following)
    assert isinstance(first, sstl.LoopDocument) and first.loop == 1
    with log.open("a") as file:
        file.write(rows(3, 0.7, 3))
    rest = list(following)
    assert [d.loop for d in takewhile(lambda d: isinstance(d, sstl.LoopDocument), rest)] == list(range(2, rest[-1].loops + 1))
    assert rest[-1].samples == 1800 and rest[-1].loops >= 5


def test_who_stops_asking_ends_the_watch(tmp_path: Path) -> None:
    log = tmp_path / "log.csv"
    log.write_text(HEAD + rows(4, 0.7))
    for seen in sstl.watch(log):
        if seen.loop == 2:
            break
    assert seen.system == "act"


def test_wrong_use_is_told_at_once_and_nothing_read_at_the_end(tmp_path: Path) -> None:
    for wrong, code in (({"once": True, "until_idle": 3.0}, "E250"), ({"learn": 5}, "E252"), ({"name_after": 9}, "E252")):
        with pytest.raises(sstl.SstlError) as told:
            sstl.watch(tmp_path / "log.csv", **wrong)
        assert told.value.code == code
    with pytest.raises(sstl.SstlError, match="no sample was read"):
        list(sstl.watch(tmp_path / "log.csv", once=True))


def test_the_installation_and_the_schemas_are_those_of_the_program() -> None:
    assert sstl.schema("diagnosis") == json.loads(inside("schema", "diagnosis").stdout)
    known = [d["name"] for d in json.loads(inside("schema", "--json").stdout)["documents"]]
    assert list(sstl.schema()) == known
    here, there = sstl.doctor().plain(), json.loads(inside("doctor", "--json").stdout)
    # the last probe tells how long it took
    assert {k: v for k, v in here.items() if k != "probes"} == {k: v for k, v in there.items() if k != "probes"}
    with pytest.raises(sstl.SstlError, match="diagnosis"):
        sstl.schema("diagnosys")
