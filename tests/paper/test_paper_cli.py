"""``sstl reproduce`` as a user calls it."""

import json
import sys

import pyarrow.parquet as pq
import pytest
from program import inside


def sstl(*words):
    return inside("reproduce", *words)


def test_tables_and_files(tmp_path):
    out = tmp_path / "new" / "results"
    done = sstl("--table", "I,II", "--out", str(out))
    assert done.returncode == 0, done.stderr
    assert "Table I:" in done.stdout and max(len(line) for line in done.stdout.splitlines()[:-1]) <= 80
    table = pq.read_table(out / "tables.parquet")
    assert table.num_rows == 42 and set(table.column("verdict").to_pylist()) == {"met"}
    page = (out / "reproduction.html").read_text()
    assert "<table" in page and "http" not in page and "<script" not in page
    assert r"\toprule" in (out / "tables.tex").read_text()
    first = {p.name: p.read_bytes() for p in out.iterdir()}
    again = sstl("--table", "I,II", "--out", str(out))
    assert again.returncode == 1 and "E102" in again.stderr
    assert sstl("--table", "I,II", "--out", str(out), "--force").returncode == 0
    differing = [n for n, b in first.items() if n.endswith(".tex") and b != (out / n).read_bytes()]
    assert not differing


def test_json_and_usage():
    done = sstl("--table", "I", "--json")
    document = json.loads(done.stdout)
    assert document["schema"] == "sstl.reproduce/1" and document["verdicts"]["met"] == 10
    wrong = sstl("--table", "VI")
    assert wrong.returncode == 2 and "E803" in wrong.stderr and "Traceback" not in wrong.stderr
    assert "E804" in sstl("--spread").stderr
    assert "E805" in sstl("--table", "I", "--gap-logs", "x").stderr


def test_folder_that_is_a_file(tmp_path):
    (tmp_path / "f").write_text("x")
    done = sstl("--table", "I", "--out", str(tmp_path / "f"))
    assert done.returncode == 1 and "E806" in done.stderr


def test_outside_the_committed_spread_ends_with_4(monkeypatch, capsys, tmp_path):
    from sstl_cli.cli.app import main
    from sstl_cli.paper import reproduce
    from sstl_cli.paper.gate import Outside

    wrong = Outside("rig", ("IV", "sinusoid DI", "rmse_CP"), 0.01, 0.46, 11.0)
    monkeypatch.setattr(reproduce, "run", lambda *_: reproduce.Reproduction(outside=(wrong,)))
    monkeypatch.setattr(sys, "argv", ["sstl", "reproduce", "--table", "R"])
    with pytest.raises(SystemExit) as stopped:
        main()
    said = capsys.readouterr().err
    assert stopped.value.code == 4
    assert "E809" in said and "sinusoid DI rmse_CP is 0.01, committed 0.46" in said


def test_what_was_rebuilt_is_told_beside_the_missed_gate(monkeypatch, capsys):
    """One document on stdout: the tables; the gate is an error beside it, as it is of ``evaluate``."""
    from sstl_cli.cli.app import main
    from sstl_cli.paper import reproduce
    from sstl_cli.paper.gate import Outside

    wrong = Outside("rig", ("IV", "sinusoid DI", "rmse_CP"), 0.01, 0.46, 11.0)
    monkeypatch.setattr(reproduce, "run", lambda *_: reproduce.Reproduction(outside=(wrong,)))
    monkeypatch.setattr(sys, "argv", ["sstl", "reproduce", "--table", "R", "--json"])
    with pytest.raises(SystemExit) as stopped:
        main()
    out, err = capsys.readouterr()
    document = json.loads(out)
    assert stopped.value.code == 4 and "E809" in err
    assert document["schema"] == "sstl.reproduce/1" and document["tables"] == ["R"] and "E809" not in out


def test_progress_tells_as_much_as_the_bar_has(monkeypatch, capsys):
    from contextlib import contextmanager

    from sstl_cli.cli.app import main
    from sstl_cli.cli.render import Screen

    told, paces = [], []

    @contextmanager
    def progress(self, label, total=None, pace=None):
        paces.append(pace)
        yield lambda amount: told.append(amount / total)

    monkeypatch.setattr(Screen, "progress", progress)
    monkeypatch.setattr(sys, "argv", ["sstl", "reproduce", "--table", "I,II"])
    with pytest.raises(SystemExit) as stopped:
        main()
    assert stopped.value.code == 0 and sum(told) == pytest.approx(1.0) and paces[0] is not None
    # it stands at the loading until the first part is told
    assert told[0] == 0.0
