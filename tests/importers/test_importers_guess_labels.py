"""Proposals for files that hold several runs: labels in columns, and elements of a struct array."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from header_table import N, T, X, Y, rows
from scipy.io import savemat
from test_importers_guess import answered

from sstl_cli.importers.guess import guess
from sstl_cli.importers.mapping import read_mapping
from sstl_cli.steps.import_ import run

RUNS = (("C20", "act"), ("C20", "act"), ("C40", "act"), ("C40", "sstl"))


def table(trials: list[int]) -> str:
    body = (rows(str(n), config, system, T, X, Y) for n, (config, system) in zip(trials, RUNS, strict=True))
    return "trial,config,system,time (s),T_prox (N),T_dist (N)\n" + "".join(body)


@pytest.mark.parametrize("trials", [[1, 2, 3, 4], [1, 2, 1, 1]])
def test_labels_in_columns_tell_runs_apart(trials: list[int], tmp_path: Path) -> None:
    path = tmp_path / "all.csv"
    path.write_text(table(trials))
    found = guess([path])
    assert not found.questions if trials[-1] == 4 else {q.target for q in found.questions} <= {"time_s"}
    # a trial that begins anew with each configuration names no run
    assert ('run_id = "trial"' in found.toml) == (trials[-1] == 4)
    (tmp_path / "rig.toml").write_text(found.toml.replace("(?)", ""))
    runs = list(run([path], read_mapping(tmp_path / "rig.toml")).runs)
    assert [(r.config_id, r.system, len(r)) for r in runs] == [(c, s, N) for c, s in RUNS]


@pytest.mark.parametrize(
    ("values", "line"),
    [(30 + 0.3 * X, ""), (np.full(N, 30.0), 'config_id = "bend (deg)"'), (np.arange(N) // 200, "does it name the configuration")],
)
def test_a_bend_that_is_measured_is_no_label(values: np.ndarray, line: str, tmp_path: Path) -> None:
    path = tmp_path / "act.csv"
    path.write_text("Time (s),bend (deg),Fin (N),Fout (N)\n" + rows(T, values, X, Y))
    found = guess([path])
    assert line in found.toml and ("config_id" in found.toml) == bool(line)
    assert bool(found.questions) == line.startswith("does")


def test_the_elements_of_a_struct_array_are_runs(tmp_path: Path) -> None:
    kind = [(n, object) for n in ("time_s", "tension_in", "tension_out", "bend_deg", "system")]
    runs = np.array([(T, (k + 1) * X, Y, 20.0 * k, s) for k, (_, s) in enumerate(RUNS)], dtype=kind)
    savemat(tmp_path / "all.mat", {"runs": runs})
    found = guess([tmp_path / "all.mat"])
    assert "runs of their own" in found.reasons[1] and "tendon" not in found.toml.partition("[constants]")[0]
    done = list(run([tmp_path / "all.mat"], answered(found.toml.replace("(?)", ""), tmp_path, "lead_mm=5")).runs)
    assert [(r.config_id, r.system) for r in done] == [(str(20 * k), s) for k, (_, s) in enumerate(RUNS)]
    np.testing.assert_allclose(done[2].tension_in_n, 3 * X)
