"""What a user meets of the physics gate: sentences, documents and exit codes of ``check`` and ``segment``."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
from identification_loops import ACT, record, trapezoid
from test_identification_cli import ORIGIN, registered_once, sstl  # noqa: F401

from sstl_cli.core.parquet import open_table
from sstl_cli.core.runs import write_runs
from sstl_cli.core.tables import THETA

SOUND = [record(*trapezoid(rate=100.0), ACT, s, run_id=f"run-{s}") for s in range(3)]


def counts(run):
    return replace(run, tension_in_n=np.round(60 * run.tension_in_n), tension_out_n=np.round(60 * run.tension_out_n))


@pytest.fixture
def mixed(tmp_path):
    write_runs(tmp_path / "log.parquet", [*SOUND, counts(record(*trapezoid(rate=100.0), ACT, 9, run_id="bad"))], ORIGIN)
    return tmp_path / "log.parquet"


def test_check_tells_the_run_the_number_and_what_mends_it(mixed):
    done = sstl("check", mixed, "--json")
    document = json.loads(done.stdout)
    assert done.returncode == 1 and document["failures"] == 1 and not document["ok"]
    (said,) = document["physics"]
    assert said["rule"] == "counts" and said["run_ids"] == ["bad"] and said["severity"] == "failure"
    assert "bad" in said["sentence"] and "counts" in said["mend"] and said["number"] > 1000
    shown = sstl("check", mixed).stdout
    assert said["sentence"][:40] in shown and shown.index("Physics (counts)") < shown.index("Sensors")
    assert sstl("check", mixed, "--no-physics").returncode == 0


def test_check_lists_how_channels_were_sampled(tmp_path):
    held = replace(SOUND[0], tension_out_n=np.repeat(SOUND[0].tension_out_n[::10], 10))
    write_runs(tmp_path / "log.parquet", [held], ORIGIN)
    sensors = {s["column"]: s for s in json.loads(sstl("check", tmp_path / "log.parquet", "--json").stdout)["sensors"]}
    assert sensors["tension_out_n"]["refresh_s"] == pytest.approx(0.1) and sensors["tension_out_n"]["held"]
    assert sensors["tension_in_n"]["refresh_s"] == pytest.approx(0.01) and not sensors["tension_in_n"]["held"]
    assert "sample and hold" in sstl("check", tmp_path / "log.parquet").stdout


def test_two_logs_are_judged_together(tmp_path):
    for name, runs in (("a", SOUND), ("b", [replace(SOUND[1], time_s=2.0 * SOUND[1].time_s)])):
        write_runs(tmp_path / f"{name}.parquet", runs, ORIGIN)
    document = json.loads(sstl("check", tmp_path / "a.parquet", tmp_path / "b.parquet", "--json").stdout)
    assert {r["rule"] for r in document["physics"]} == {"duplicate"}
    assert document["physics"][0]["run_ids"] == [f"{tmp_path / 'b.parquet'}: run-1"]


def test_segment_sets_a_failed_run_aside(mixed, tmp_path):
    done = sstl("segment", mixed, "--out", tmp_path / "t.parquet", "--json")
    document = json.loads(done.stdout)
    assert done.returncode == 3 and [r["rule"] for r in document["remarks"]] == ["counts"]
    assert [r["run_id"] for r in document["set_aside_runs"]] == ["bad"]
    rows = {r["run_id"]: r for r in open_table(tmp_path / "t.parquet", THETA).table().to_pylist()}
    assert rows["bad"]["gamma_p"] is None and "counts" in rows["bad"]["status"]
    assert rows["run-0"]["gamma_p"] == pytest.approx(ACT[0], rel=0.01)
    regardless = sstl("segment", mixed, "--out", tmp_path / "u.parquet", "--no-physics", "--json")
    assert regardless.returncode == 0 and json.loads(regardless.stdout)["remarks"] == []


def test_segment_ends_where_no_run_can_be_right(tmp_path):
    write_runs(tmp_path / "log.parquet", [counts(r) for r in SOUND], ORIGIN)
    done = sstl("segment", tmp_path / "log.parquet", "--out", tmp_path / "t.parquet")
    assert done.returncode == 1 and "[E223]" in done.stderr and "--no-physics" in done.stderr
    assert not (tmp_path / "t.parquet").exists()


def test_remarks_stand_on_top_and_stop_nothing(tmp_path):
    write_runs(tmp_path / "log.parquet", [record(*trapezoid(0.2, 40.0, rate=100.0), (0.25, 0.0, 4.2, 0.0), 1)], ORIGIN)
    done = sstl("segment", tmp_path / "log.parquet", "--out", tmp_path / "t.parquet")
    assert done.returncode == 0 and done.stdout.startswith("Remark (passes): run r: labelled act")
    assert (tmp_path / "t.parquet").exists()


def test_the_headline_counts_the_sentences_below_it(tmp_path):
    runs = [replace(r, run_id=f"late-{i}", tension_out_n=-r.tension_out_n) for i, r in enumerate((SOUND[0], SOUND[1]))]
    write_runs(tmp_path / "log.parquet", runs, ORIGIN)
    said = sstl("check", tmp_path / "log.parquet").stdout
    sentences = sum(line.startswith("Physics (") for line in said.splitlines())
    rows = sum(line.startswith("failure") for line in said.splitlines())
    assert f"{sentences + rows} failure" in said and json.loads(sstl("check", tmp_path / "log.parquet", "--json").stdout)[
        "failures"
    ] >= len(runs)


def test_a_log_with_remarks_is_not_called_sound(tmp_path):
    other = record(*trapezoid(rate=100.0), ACT, 9, run_id="other")
    for name, runs in (
        ("fine", SOUND),
        ("odd", [*SOUND, replace(other, time_s=2.0 * other.time_s)]),
        ("more", [record(*trapezoid(rate=100.0), ACT, 7)]),
    ):
        write_runs(tmp_path / f"{name}.parquet", runs, ORIGIN)
    fine, odd, both = ([tmp_path / f"{n}.parquet" for n in names] for names in (["fine"], ["odd"], ["odd", "more"]))
    assert sstl("check", *fine).stdout.startswith("fine.parquet is sound. 1 file: 0 failures, 0 remarks")
    assert sstl("check", *odd).stdout.startswith("odd.parquet has no failure, but look at what is remarked. 1 file: 0 failures, 1 remark")
    assert sstl("check", *both).stdout.startswith("None has a failure, but look at what is remarked. 2 files: 0 failures, 1 remark")
