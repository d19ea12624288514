"""The notebook runs from its first cell to its last on the public recordings."""

from __future__ import annotations

import json
from pathlib import Path

import matplotlib
import pytest

ROOT = Path(__file__).resolve().parents[2]
DATA = ROOT.parent / "shared" / "data" / "pneu-cylinder"
FOLDER = DATA if DATA.is_dir() else None


@pytest.mark.skipif(FOLDER is None, reason="the folder ../shared/data/pneu-cylinder is absent")
@pytest.mark.slow
def test_the_notebook_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("SSTL_NOTEBOOK_DATA", str(FOLDER))
    matplotlib.use("Agg")
    cells = json.loads((ROOT / "docs/notebook.ipynb").read_text(encoding="utf-8"))["cells"]
    names: dict = {"__name__": "__main__"}
    for number, cell in enumerate(cells):
        if cell["cell_type"] == "code":
            exec(compile("".join(cell["source"]), f"cell {number}", "exec"), names)
    widths = names["widths"]
    # what the authors of the recordings measured: 5.6 to 6.7 N, and 3.3 to 11.6 N growing with the pressure
    assert widths["KDN"].max() < 1.5 * widths["KDN"].min()
    assert widths["NAPN"].is_monotonic_increasing and widths["NAPN"].iloc[-1] > 2.5 * widths["NAPN"].iloc[0]
    for diagnosis in names["found"].values():
        assert diagnosis.verdict.status != "none"
        assert diagnosis.gap.rmse_with_effect_n <= diagnosis.gap.rmse_retuned_n
    assert "<svg" in (tmp_path / "cylinders.html").read_text(encoding="utf-8")
    matplotlib.pyplot.close("all")
