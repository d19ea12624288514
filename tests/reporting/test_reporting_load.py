"""Files are recognised by what they hold, and refused with one clear line."""

import json

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
import reporting_inputs as made

from sstl_cli.core.errors import SstlError, UsageError
from sstl_cli.reporting.load import kind_of, load

KINDS = {
    "log.parquet": "log", "phases.parquet": "phases", "theta.parquet": "theta", "commands.parquet": "command",
    "scores.parquet": "score", "history.parquet": "history", "evaluation.parquet": "evaluation",
    "predictions.parquet": "predictions", "model.safetensors": "model", "diagnosis.json": "diagnosis",
    "blind.json": "blind", "check.json": "document",
}  # fmt: skip


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    return made.write_all(tmp_path_factory.mktemp("inputs"))


def test_kinds_by_content(files):
    assert {f.name: kind_of(f) for f in files} == KINDS


def test_names_do_not_matter(files, tmp_path):
    theta = next(f for f in files if f.name == "theta.parquet")
    (tmp_path / "diagnosis.json").write_bytes(theta.read_bytes())
    assert kind_of(tmp_path / "diagnosis.json") == "theta"


def test_tables_of_other_programs_are_known_by_their_columns(tmp_path):
    log = {"run_id": ["a", "a"], "system": ["act", "act"], "time_s": [0.0, 1.0], "tension_in_n": [1.0, 2.0], "tension_out_n": [1.0, 1.0]}
    pq.write_table(pa.table(log), tmp_path / "own.parquet")
    assert kind_of(tmp_path / "own.parquet") == "log"
    pq.write_table(pa.table({"x": [1]}), tmp_path / "x.parquet")
    with pytest.raises(SstlError, match="E602"):
        kind_of(tmp_path / "x.parquet")


def test_everything_is_read(files):
    found = load(files)
    assert [r.run_id for r in found.log] == [name for name, *_ in made.runs(4)]
    assert set(found.phases) == {r.run_id for r in found.log}
    assert len(found.theta) == 4 and len(found.history) == 240 and len(found.evaluation) == 6 and len(found.predictions) == 80
    assert [v.method for v in found.command] == ["none", "no-bias", "proposed", "DI"]
    assert found.model[0].parameters == 16 and found.model[0].metadata["variant"] == "full"
    assert len(found.files) == len(files)


def test_error_by_phase_is_that_of_all_samples(files):
    table = pq.read_table(next(f for f in files if f.name == "commands.parquet")).to_pandas()
    for v in load(files).command:
        own = table[table.method == v.method]
        assert len(v.time_s) < len(own)
        for phase, value in v.rmse_by_phase_n.items():
            part = own[own.phase == phase]
            assert value == pytest.approx(np.sqrt(np.mean((part.tension_out_n - part.tension_ref_n) ** 2)))


def test_phases_follow_their_samples(files):
    table = pq.read_table(next(f for f in files if f.name == "phases.parquet")).to_pandas()
    found = load(files).phases
    for run_id, own in table.groupby("run_id"):
        codes = found[run_id].at(own.time_s.to_numpy())
        assert [("PB", "PP", "RB", "RP")[c] for c in codes] == own.phase.tolist()


@pytest.mark.parametrize(
    ("name", "content", "code"),
    [
        ("a.txt", b"hello", "E601"), ("a.csv", b"time_s,x\n1,2\n", "E601"), ("empty.json", b"", "E601"),
        ("a.json", json.dumps({"x": 1}).encode(), "E603"), ("b.json", b'{"schema": "other/1"}', "E603"),
        ("broken.json", b'{"schema": ', "E111"), ("short.safetensors", b"\x01", "E605"),
        ("long.safetensors", b"\xff" * 8 + b"{}", "E605"), ("odd.safetensors", b"\x02" + bytes(7) + b"[]", "E605"),
        ("cut.parquet", b"PAR1 and no more", "E130"),
    ],
)  # fmt: skip
def test_refused_with_one_line(tmp_path, name, content, code):
    path = tmp_path / name
    path.write_bytes(content)
    with pytest.raises(SstlError) as caught:
        load([path])
    assert caught.value.code == code and name in caught.value.line() and "\n" not in caught.value.line()


def test_missing_and_repeated_files(files, tmp_path):
    with pytest.raises(SstlError, match="E601"):
        load([tmp_path / "none.parquet"])
    with pytest.raises(UsageError, match="E607"):
        load([files[0], files[0]])
