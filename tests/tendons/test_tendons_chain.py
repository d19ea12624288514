"""The name of a tendon goes with its runs, from the recording to Theta."""

from __future__ import annotations

import numpy as np
import pyarrow.parquet as pq
import pytest
from tendon_logs import act, sstl
from typer.testing import CliRunner

from sstl_cli.cli.app import _register, app
from sstl_cli.core.errors import SstlError
from sstl_cli.core.provenance import Provenance
from sstl_cli.core.runs import read_runs, write_runs

MADE = Provenance("test")


@pytest.fixture(scope="module")
def runs():
    return [sstl("c1", 0.5, "ramps", {}, 0), act("A", "c1", 0.5, "ramps", {}, 1), act("B", "c1", 0.55, "ramps", {}, 2)]


def call(*words):
    _register()
    done = CliRunner().invoke(app, [str(w) for w in words])
    assert done.exit_code == 0, (done.output, done.exception)


def test_from_csv_to_theta(runs, tmp_path):
    log, csv, again, theta = (tmp_path / n for n in ("log.parquet", "log.csv", "again.parquet", "theta.parquet"))
    write_runs(log, runs, MADE, tendons=lambda: True)
    call("export", log, "--format", "csv", "--out", csv)
    call("import", csv, "--out", again)
    assert [(r.run_id, r.tendon) for r in read_runs(again)] == [(r.run_id, r.tendon) for r in runs]
    call("segment", again, "--out", theta)
    rows = pq.read_table(theta).to_pylist()
    assert [r["tendon"] for r in rows] == [None, "A", "B"]
    assert rows[2]["gamma_p"] == pytest.approx(np.exp(-0.55), rel=0.02)


def test_a_tendon_is_never_dropped_silently(runs, tmp_path):
    with pytest.raises(SstlError, match="names a tendon"):
        write_runs(tmp_path / "log.parquet", runs, MADE)
    assert list(tmp_path.iterdir()) == []


def test_logs_without_tendons_keep_their_columns(runs, tmp_path):
    write_runs(tmp_path / "log.parquet", runs[:1], MADE)
    assert "tendon" not in pq.read_schema(tmp_path / "log.parquet").names
