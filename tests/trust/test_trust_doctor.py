"""``sstl doctor``: quick, complete, and bad where something is bad."""

from __future__ import annotations

import resource
from pathlib import Path

import pytest
from trust_program import document, sstl

from sstl_cli.core.kept import Kept
from sstl_cli.steps import doctor


def test_document() -> None:
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = sstl("doctor", "--json")
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    # of the processor, so that other work on the machine does not count
    assert after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime < 5.0
    found = document(done)
    assert done.returncode == 0 and found["schema"] == "sstl.doctor/1" and found["ok"]
    assert found["packages"]["numpy"] and set(found["extras"]) == {"robot", "onnx", "cluster"}
    assert {p["name"] for p in found["probes"]} == {"packages", "compile cache", "self-test"}


def test_self_test_fails_where_the_answer_is_wrong(monkeypatch: pytest.MonkeyPatch) -> None:
    assert doctor.self_test().ok
    monkeypatch.setitem(doctor.PLANTED, "gamma_p", 0.6)
    monkeypatch.setitem(doctor.TOLERANCE, "gamma_p", 1e-9)
    assert not doctor.self_test().ok


def test_cache_that_cannot_be_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = tmp_path / "file"
    file.write_text("")
    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)
    assert doctor.cache_probe(Kept(tmp_path)).ok
    assert doctor.cache_probe(Kept(tmp_path, "the home folder cannot be written")).detail.endswith("cannot be written")
    assert not doctor.cache_probe(Kept(tmp_path, as_asked=False)).ok
    done = sstl("doctor", NUMBA_CACHE_DIR=str(file))
    assert done.returncode == 1 and "NUMBA_CACHE_DIR" in done.stderr
