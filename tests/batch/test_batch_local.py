"""``sstl batch``: same bytes for any worker, resumed where it stopped, a bad file listed and no more."""

from __future__ import annotations

import json
import os
from dataclasses import replace
from pathlib import Path

import pytest
from program import inside as sstl
from trust_program import document, write_csv, write_log

from sstl_cli.core.errors import SstlError, UsageError
from sstl_cli.steps import batch as step


@pytest.fixture(scope="module")
def logs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("logs")
    for i in range(3):
        write_log(folder / f"r{i}.parquet", seed=i)
    return folder


def _bytes(folder: Path) -> dict[str, bytes]:
    return {p.name: p.read_bytes() for p in folder.iterdir() if p.is_file()}


def test_outputs_are_those_of_the_subcommand_for_any_number_of_workers(logs: Path, tmp_path: Path) -> None:
    files = sorted(logs.glob("*.parquet"))
    for workers in (1, 3):
        done = sstl(
            "batch", "segment", *files, "--out-dir", tmp_path / f"w{workers}", "--workers", workers,
            "--", "--cutoff-hz", "20", "--phases", "{name}-phases.parquet",
        )  # fmt: skip
        assert done.returncode == 0, done.stderr
    alone = tmp_path / "alone"
    alone.mkdir()
    for path in files:
        name = path.stem
        words = ("--cutoff-hz", "20", "--phases", alone / f"{name}-phases.parquet")
        assert sstl("segment", path, "--out", alone / path.name, *words).returncode == 0
    assert _bytes(tmp_path / "w1") == _bytes(tmp_path / "w3") == _bytes(alone)
    assert len(_bytes(alone)) == 6


def test_a_bad_file_is_listed_and_the_rest_is_done_and_resumed(logs: Path, tmp_path: Path) -> None:
    bad = tmp_path / "bad.parquet"
    bad.write_bytes((logs / "r0.parquet").read_bytes()[:2000])
    files = [logs / "r0.parquet", bad, logs / "r1.parquet"]
    first = sstl("batch", "segment", *files, "--out-dir", tmp_path / "out", "--json")
    assert first.returncode == 3
    states = {Path(r["input"]).name: r["state"] for r in document(first)["results"]}
    assert states == {"r0.parquet": "done", "bad.parquet": "failed", "r1.parquet": "done"}
    line = document(first)["results"][1]["line"]
    assert line.startswith("[E130]") and "bad.parquet" in line and line in " ".join(first.stderr.split())
    assert not (tmp_path / "out" / "bad.parquet").exists()

    before = (tmp_path / "out" / "r0.parquet").stat().st_mtime_ns
    bad.write_bytes((logs / "r2.parquet").read_bytes())
    second = sstl("batch", "segment", *files, "--out-dir", tmp_path / "out", "--json")
    assert second.returncode == 0
    assert [r["state"] for r in document(second)["results"]] == ["skipped", "done", "skipped"]
    assert (tmp_path / "out" / "r0.parquet").stat().st_mtime_ns == before


def test_changed_input_and_damaged_output_are_made_again(tmp_path: Path) -> None:
    log, out = write_log(tmp_path / "a.parquet"), tmp_path / "out"
    run = lambda: document(sstl("batch", "segment", log, "--out-dir", out, "--json"))  # noqa: E731
    run()
    good = (out / "a.parquet").read_bytes()
    (out / "a.parquet").write_bytes(good[:100])
    assert run()["results"][0]["state"] == "done"
    assert (out / "a.parquet").read_bytes() == good
    write_log(log, seed=9)
    assert run()["results"][0]["state"] == "done"
    assert (out / "a.parquet").read_bytes() != good


def test_files_that_no_batch_made_are_kept(tmp_path: Path) -> None:
    log, out = write_log(tmp_path / "a.parquet"), tmp_path / "out"
    out.mkdir()
    (out / "a.parquet").write_text("mine")
    refused = sstl("batch", "segment", log, "--out-dir", out)
    assert refused.returncode == 1 and "E023" in refused.stderr
    assert (out / "a.parquet").read_text() == "mine"
    assert sstl("batch", "segment", log, "--out-dir", out, "--force").returncode == 0
    other = sstl("batch", "segment", log, "--out-dir", out, "--", "--cutoff-hz", "9")
    assert other.returncode == 1 and "E024" in other.stderr


def test_check_keeps_its_document_and_its_verdict(logs: Path, tmp_path: Path) -> None:
    bad = tmp_path / "bad.parquet"
    bad.write_bytes(b"PAR1 and no more")
    for state in ("failed", "failed"):
        done = sstl("batch", "check", logs / "r0.parquet", bad, "--out-dir", tmp_path / "out", "--json")
        assert done.returncode == 3
        assert document(done)["results"][1]["state"] == state
    assert json.loads((tmp_path / "out" / "bad.json").read_text())["ok"] is False
    assert json.loads((tmp_path / "out" / "r0.json").read_text())["ok"] is True


def test_options_of_the_subcommand_are_checked_once(logs: Path, tmp_path: Path) -> None:
    done = sstl("batch", "segment", logs / "r0.parquet", "--out-dir", tmp_path / "out", "--", "--cutof-hz", "9")
    assert done.returncode == 2 and "cutof-hz" in done.stderr
    assert not (tmp_path / "out").exists()


def test_a_mapping_that_changed_is_a_changed_input(tmp_path: Path) -> None:
    write_csv(tmp_path / "r.csv")
    (tmp_path / "m.toml").write_text('[constants]\nconfig_id = "A"\n')
    words = ("batch", "import", "r.csv", "--out-dir", "out", "--json", "--", "--mapping", "m.toml")
    assert sstl(*words, cwd=tmp_path).returncode == 0
    assert document(sstl(*words, cwd=tmp_path))["skipped"] == 1
    (tmp_path / "m.toml").write_text('[constants]\nconfig_id = "B"\n')
    assert document(sstl(*words, cwd=tmp_path))["done"] == 1


def test_memory_and_file_addresses_give_the_same_bytes(logs: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    import fsspec

    from sstl_cli.cli._batch_worker import call_program

    source = logs / "r0.parquet"
    memory = fsspec.filesystem("memory")
    memory.pipe_file("/in/r0.parquet", source.read_bytes())
    out = f"file://{tmp_path}/out"
    for where in ("memory://out", out):
        for given in ("memory://in/*.parquet", f"file://{source}"):
            code, _, told = call_program(["batch", "segment", given, "--out-dir", where, "--force"], {})
            assert code == 0, told
            made = memory.cat_file("/out/r0.parquet") if where.startswith("memory") else None
            made = made or (tmp_path / "out" / "r0.parquet").read_bytes()
            assert sstl("segment", source, "--out", tmp_path / "r0.parquet", "--force").returncode == 0
            assert made == (tmp_path / "r0.parquet").read_bytes()
    code, printed, _ = call_program(["batch", "segment", "memory://in/*.parquet", "--out-dir", "memory://out", "--json"], {})
    # the first input came from another address, so the last record is of file://
    assert code == 0 and json.loads(printed)["done"] + json.loads(printed)["skipped"] == 1


def test_environment_of_the_subcommand_reaches_the_workers(logs: Path, tmp_path: Path) -> None:
    words = ("batch", "segment", logs / "r0.parquet", "--out-dir", tmp_path / "out", "--workers", 2, "--json")
    assert sstl(*words, SSTL_SEGMENT_CUTOFF_HZ="-3").returncode == 1
    assert sstl(*words, SSTL_SEGMENT_CUTOFF_HZ="15").returncode == 0
    assert document(sstl(*words))["done"] == 1


def test_a_file_in_the_place_of_the_folder_is_named(logs: Path, tmp_path: Path) -> None:
    (tmp_path / "out").write_text("mine")
    done = sstl("batch", "info", logs / "r0.parquet", "--out-dir", "out", cwd=tmp_path)
    assert done.returncode == 1 and "[E032] out: is a file" in done.stderr and (tmp_path / "out").read_text() == "mine"


def test_two_batches_do_not_share_a_folder(logs: Path, tmp_path: Path) -> None:
    import fcntl

    (tmp_path / "out" / ".batch").mkdir(parents=True)
    with open(tmp_path / "out" / ".batch" / "lock", "a") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        refused = sstl("batch", "segment", logs / "r0.parquet", "--out-dir", tmp_path / "out")
        assert refused.returncode == 1 and "E035" in refused.stderr
    assert sstl("batch", "segment", logs / "r0.parquet", "--out-dir", tmp_path / "out").returncode == 0


def test_a_worker_that_dies_costs_only_its_file(logs: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from sstl_cli.cli import _batch_pool as pool
    from sstl_cli.cli._batch_worker import Job

    (tmp_path / "out" / ".batch").mkdir(parents=True)
    # what loads least, in each of the processes that are started after one died
    items = step.plan("info", [str(logs / f"r{i}.parquet") for i in range(3)], [])
    jobs = [Job("info", item, str(tmp_path / "out"), False, {}, os.getcwd()) for item in items]
    monkeypatch.setattr(pool, "run_here", dies_on_r1)
    told: list[step.Outcome] = []
    states = [o.state for o in pool.run_all(jobs, 2, None, told.append)]
    # what was finished when the pool broke is found complete when it is tried again
    assert [s.replace("skipped", "done") for s in states] == ["done", "failed", "done"]
    assert sorted(o.source for o in told) == [i.source for i in items]


def dies_on_r1(job: object, program: int) -> step.Outcome:
    from sstl_cli.cli._batch_worker import run_here

    if job.item.source.endswith("r1.parquet"):  # type: ignore[attr-defined]
        os.kill(os.getpid(), 9)
    return run_here(job, program)  # type: ignore[arg-type]


def test_plan_refuses_clashes_and_shared_side_outputs() -> None:
    with pytest.raises(UsageError, match="E022"):
        step.plan("segment", ["a/log.parquet", "b/log.parquet"], [])
    with pytest.raises(UsageError, match="E025"):
        step.plan("segment", ["a.parquet"], ["--phases", "p.parquet"])
    with pytest.raises(UsageError, match="E021"):
        step.plan("segment", ["a.parquet"], ["--out=x"])
    with pytest.raises(UsageError, match="did you mean 'segment'"):
        step.plan("segmnt", ["a.parquet"], [])
    assert step.plan("export", ["a.parquet"], ["--format", "mat"])[0].output == "a.mat"
    item = step.plan("segment", ["x/a.parquet"], ["--phases={name}.ph", "--seed", "3"])[0]
    assert item.options == ("--phases=a.ph", "--seed", "3") and item.side == ("a.ph",)


def test_decide() -> None:
    wanted = step.Record("segment", (), "v", {"a": "1"}, {})
    done = replace(wanted, state=step.DONE, outputs={"a": "9"})
    decide = lambda record, present: step.decide(record, wanted, present, False, "a")  # noqa: E731
    assert decide(None, {"a": None})
    assert not decide(done, {"a": "9"})
    assert decide(done, {"a": "8"}) and decide(replace(done, inputs={"a": "2"}), {"a": "9"})
    assert decide(wanted, {"a": "half"})
    with pytest.raises(SstlError, match="E023"):
        decide(None, {"a": "9"})
    with pytest.raises(SstlError, match="E024"):
        decide(replace(done, options=("--seed", "2")), {"a": "9"})


def test_a_record_survives_its_document_and_what_is_none_is_none() -> None:
    begun = step.Record("segment", ("--seed", "2"), "v", {"a": "1"}, {"SSTL_SEGMENT_SEED": "2"})
    ended = replace(begun, state=step.DONE, exit_code=3, line="set aside", outputs={"a": "9"})
    for record in (begun, ended):
        assert step.Record.of(json.loads(json.dumps(record.document()))) == record
    assert "outputs" not in begun.document()
    assert step.Record.of(None) is None and step.Record.of({"schema": "sstl.batch/1"}) is None
    assert step.Record.of({"schema": step.RECORD, "options": 5, "inputs": []}).state != step.DONE


@pytest.mark.parametrize("how", ["config", "config itself", "variable", "manifest", "option"])
def test_what_the_subcommand_reads_is_not_overwritten(how: str, tmp_path: Path) -> None:
    write_csv(tmp_path / "r.csv")
    (tmp_path / "out").mkdir()
    precious = tmp_path / "out" / "r.parquet"
    precious.write_text(
        "" if how == "config itself" else "file,config_id\nr.csv,A\n" if how == "manifest" else '[constants]\nconfig_id = "A"\n'
    )
    # under another name, as a link gives it
    (tmp_path / "m.toml").symlink_to(precious)
    if how == "manifest":
        (tmp_path / "m.toml").unlink()
        (tmp_path / "m.toml").write_text('manifest = "out/r.parquet"\n')
    (tmp_path / "c.toml").write_text('mapping = "m.toml"\n')
    rest = {"config": ["--config", "c.toml"], "config itself": ["--config", "m.toml"], "variable": []}.get(how, ["--mapping", "m.toml"])
    before = precious.read_text()
    variables = {"SSTL_IMPORT_MAPPING": "m.toml"} if how == "variable" else {}
    done = sstl("batch", "import", "r.csv", "--out-dir", "out", "--force", *(["--", *rest] if rest else []), cwd=tmp_path, **variables)
    assert done.returncode == 2 and "[E109]" in done.stderr and precious.read_text() == before


@pytest.mark.parametrize("how", ["config", "variable", "manifest"])
def test_a_file_that_options_name_elsewhere_is_an_input_too(how: str, tmp_path: Path) -> None:
    write_csv(tmp_path / "r.csv")
    (tmp_path / "c.toml").write_text('mapping = "m.toml"\n')
    changes = tmp_path / ("labels.csv" if how == "manifest" else "m.toml")
    form = "file,config_id\nr.csv,{}\n" if how == "manifest" else '[constants]\nconfig_id = "{}"\n'
    if how == "manifest":
        (tmp_path / "m.toml").write_text('manifest = "labels.csv"\n')
    rest = [] if how == "variable" else ["--", "--config", "c.toml"]
    variables = {"SSTL_IMPORT_MAPPING": "m.toml"} if how == "variable" else {}
    states = []
    for label in ("A", "A", "B"):
        changes.write_text(form.format(label))
        done = sstl("batch", "import", "r.csv", "--out-dir", "out", "--json", *rest, cwd=tmp_path, **variables)
        states.append(document(done)["results"][0]["state"])
    assert states == ["done", "skipped", "done"]


def test_side_outputs_in_the_folder_of_the_call_are_resumed(logs: Path, tmp_path: Path) -> None:
    words = ("batch", "segment", logs / "r0.parquet", "--out-dir", ".", "--json", "--", "--phases", "{name}-phases.parquet")
    assert document(sstl(*words, cwd=tmp_path))["done"] == 1
    assert document(sstl(*words, cwd=tmp_path))["skipped"] == 1


@pytest.mark.parametrize(
    ("command", "rest", "says"),
    [
        ("segment", ["-omine.parquet"], "'mine.parquet' would be one output for all"),
        ("segment", ["--config", "c.toml"], "--phases: 'p.parquet' would be one file for all"),
        ("diagnose", ["--junit", "j.xml"], "--junit: 'j.xml' would be one file for all"),
        ("diagnose", ["--summary", "s.md"], "--summary: 's.md' would be one file for all"),
        ("export", ["-fcsv"], "'csv' is not the format that names the outputs"),
        ("export", ["--config", "e.toml"], "'csv' is not the format that names the outputs"),
    ],
)
def test_no_output_is_that_of_all_files(command: str, rest: list[str], says: str, logs: Path, tmp_path: Path) -> None:
    """They were written beside the folder of the batch, each over the one before, or under the ending of another format."""
    (tmp_path / "c.toml").write_text('phases = "p.parquet"\n')
    (tmp_path / "e.toml").write_text('format = "csv"\n')
    done = sstl("batch", command, *sorted(logs.glob("*.parquet")), "--out-dir", "out", "--", *rest, cwd=tmp_path)
    assert done.returncode == 2 and says in done.stderr and {p.name for p in tmp_path.iterdir()} == {"c.toml", "e.toml"}


def test_a_file_with_the_name_of_an_output_is_kept_where_an_option_reads_it(tmp_path: Path) -> None:
    """Named like the output it was taken for the output."""
    (tmp_path / "in").mkdir()
    (tmp_path / "in" / "t.parquet").write_bytes(b"theta")
    (tmp_path / "t.parquet").write_bytes(b"recorded")
    words = ("--out-dir", ".", "--force", "--", "--recorded", "t.parquet")
    done = sstl("batch", "compensate", "in/t.parquet", *words, cwd=tmp_path)
    assert done.returncode == 2 and "[E109]" in done.stderr and (tmp_path / "t.parquet").read_bytes() == b"recorded"
