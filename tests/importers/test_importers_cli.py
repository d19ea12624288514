"""``sstl import`` as users call it: exit codes, one line, nothing half-written, the same bytes."""

from __future__ import annotations

import json
from pathlib import Path

import h5py
from program import inside as sstl
from seeds import signals

from sstl_cli.core.runs import read_runs

HEAD = "run_id,system,time_s,tension_in_n,tension_out_n\n"


def log_csv(folder: Path, repeat: bool = False) -> Path:
    rows = [f"r{r},act,{i * 0.01:.2f},{5 + i % 7},{3 + i % 5}" for r in (1, 2) for i in range(50)]
    if repeat:
        rows.insert(3, rows[2])
    (folder / "log.csv").write_text(HEAD + "\n".join(rows) + "\n")
    return folder / "log.csv"


def test_canonical_csv_needs_no_mapping_and_is_repeatable(tmp_path: Path) -> None:
    source = log_csv(tmp_path)
    done = sstl("import", source, "--out", tmp_path / "a.parquet", "--json", "--force")
    assert done.returncode == 0, done.stderr
    document = json.loads(done.stdout)
    assert (document["schema"], document["runs"], document["samples_out"]) == ("sstl.import/1", 2, 100)
    assert [r.run_id for r in read_runs(tmp_path / "a.parquet")] == ["r1", "r2"]
    first = (tmp_path / "a.parquet").read_bytes()
    again = sstl("import", source, "--out", tmp_path / "a.parquet", "--json", "--force")
    assert again.returncode == 0 and (tmp_path / "a.parquet").read_bytes() == first


def test_exit_codes(tmp_path: Path) -> None:
    source = log_csv(tmp_path, repeat=True)
    out = tmp_path / "a.parquet"
    aside = sstl("import", source, "--out", out)
    assert aside.returncode == 3 and "set aside in all: 1 samples" in aside.stderr
    exists = sstl("import", source, "--out", out)
    assert exists.returncode == 1 and "--force" in exists.stderr and exists.stderr.count("\n") == 1
    usage = sstl("import", source)
    assert usage.returncode == 2
    wrong = sstl("import", source, "--out", tmp_path / "b.parquet", "--on-gap", "jump")
    assert wrong.returncode == 2 and "split, fill or fail" in wrong.stderr
    source.write_text(HEAD + "r,act,0,1,2\nr,act,1,x,2\n")
    bad = sstl("import", source, "--out", tmp_path / "b.parquet")
    assert bad.returncode == 1 and "line 3" in bad.stderr and "Traceback" not in bad.stderr
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a.parquet", "log.csv"]


def test_guess_proposes_a_mapping_that_works(tmp_path: Path) -> None:
    source = tmp_path / "rec.csv"
    import math

    rows = [f"{i * 2},{5 + math.sin(i / 30):.5f},{3 + math.sin(i / 30 - 0.3):.5f}" for i in range(500)]
    source.write_text("time_ms,force_in_N,force_out_N\n" + "\n".join(rows) + "\n")
    guess = sstl("import", "--guess", source, "--out", tmp_path / "rig.toml")
    assert guess.returncode == 0 and "by their names" in guess.stderr
    ask = sstl("import", source, "--mapping", tmp_path / "rig.toml", "--out", tmp_path / "a.parquet")
    assert ask.returncode == 1 and "still asks: system" in ask.stderr and not (tmp_path / "a.parquet").exists()
    done = sstl("import", source, "--mapping", tmp_path / "rig.toml", "--map", "system=act", "--out", tmp_path / "a.parquet")
    assert done.returncode == 0, done.stderr
    (one,) = read_runs(tmp_path / "a.parquet")
    assert len(one) == 500 and abs(one.dt_s - 0.002) < 1e-9


def test_output_that_is_no_tension_is_recorded(tmp_path: Path) -> None:
    source = tmp_path / "rec.csv"
    source.write_text("t,f,a\n" + "\n".join(f"{i},{i},{2 * i}" for i in range(5)) + "\n")
    (tmp_path / "m.toml").write_text(
        '[columns]\ntime_s = {column = "t", unit = "s"}\ntension_in_n = {column = "f", unit = "N"}\n'
        'tension_out_n = {column = "a", unit = "deg", as = "N"}\n[constants]\nsystem = "act"\n'
    )
    done = sstl("import", source, "--mapping", tmp_path / "m.toml", "--out", tmp_path / "a.parquet", "--json")
    assert done.returncode == 0 and json.loads(done.stdout)["not_a_tension"] == {"tension_out_n": "deg"}
    import pyarrow.parquet as pq

    stored = json.loads(pq.read_schema(tmp_path / "a.parquet").metadata[b"sstl"])
    assert stored["extra"]["not_a_tension"] == {"tension_out_n": "deg"} and set(stored["inputs"]) == {"rec.csv", "m.toml"}


def test_recordings_of_one_file_come_from_one_file(tmp_path: Path) -> None:
    with h5py.File(tmp_path / "two.h5", "w") as file:
        for name in ("first", "second"):
            for column, values in signals().items():
                file[f"{name}/{column}"] = values
    done = sstl("import", tmp_path / "two.h5", "--map", "system=act", "--out", tmp_path / "two.parquet")
    assert done.returncode == 0 and done.stdout.startswith("Imported 2 runs from 1 file ->"), done


def test_a_recording_that_is_missing_among_others_is_named(tmp_path):
    """The system's own words were shown, with advice on space and rights."""
    (tmp_path / "there.csv").write_text("time_s,tension_in_n,tension_out_n,system\n" + "".join(f"{i},1,1,act\n" for i in range(20)))
    for more in ([], ["--guess"]):
        done = sstl("import", tmp_path / "there.csv", tmp_path / "absent.csv", *more, "--out", tmp_path / "x.parquet")
        assert done.returncode == 1 and "[E306]" in done.stderr and "absent.csv: file not found" in done.stderr
    assert not (tmp_path / "x.parquet").exists()
