"""The withheld-effect check from Python: the same set, the same answers and the same score as those of the program."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import NoReturn

import pytest
from program import inside

import sstl_cli as sstl
from sstl_cli.blind import folder
from sstl_cli.blind.seal import Planned
from sstl_cli.core.errors import SstlError
from sstl_cli.physics.scenario import Scenario
from sstl_cli.steps import blind_run, blind_set


@pytest.fixture
def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    """A diagnosis that fails at once, which is a result: what is asked here is who calls whom, not who is named."""

    def fails(*_: object) -> NoReturn:
        raise SstlError("nothing usable", code="E901")

    def one(job: tuple[str, str, Planned]) -> None:
        root, case, asked = job
        folder.keep_result(folder.Folder(Path(root)), case, blind_run.run(case, [], Scenario(), (), fails), asked)

    monkeypatch.setattr(blind_set, "_diagnose_one", one)


def test_a_set_is_made_diagnosed_and_scored_as_the_program_does(quick: None, tmp_path: Path) -> None:
    check = sstl.BlindSet(tmp_path / "set")
    how = {"cases": 2, "quick": True, "simulator": "rig", "recordings": "plain", "seed": 3, "workers": 1}
    made = check.make(**how)
    words = [w for name, value in how.items() if name != "quick" for w in (f"--{name}", value)]
    assert inside("blind", "make", tmp_path / "other", "--quick", *words).returncode == 0
    files = sorted(p.relative_to(tmp_path / "set") for p in (tmp_path / "set").rglob("*") if p.is_file())
    assert made.cases == 2 and len(files) >= 5
    assert all((tmp_path / "set" / f).read_bytes() == (tmp_path / "other" / f).read_bytes() for f in files)
    with pytest.raises(SstlError, match="E959"):
        check.score()
    # one case, then the other: a run goes on where it stopped
    plan = json.loads((tmp_path / "set/plan.json").read_text(encoding="utf-8"))
    assert check.cases == [row["case"] for row in plan["cases"]] == ["case-0001", "case-0002"]
    done = check.run(workers=1)
    (tmp_path / "set/results/case-0002.json").unlink()
    with pytest.warns(UserWarning, match="1 cases without a result"):
        assert check.score(realised=False).cases == 1
    again = check.run(workers=1)
    assert (done.diagnosed, done.kept, again.diagnosed, again.kept) == (2, 0, 1, 1)
    told = inside("blind", "score", tmp_path / "set", "--json")
    assert told.returncode == 0, told.stderr
    assert check.score().plain() == json.loads(told.stdout)


def test_what_cannot_be_drawn_is_said_before_anything_is(tmp_path: Path) -> None:
    check = sstl.BlindSet(tmp_path / "new" / "set")
    for wrong in ({"simulator": "brissle"}, {"recordings": "field"}, {"cases": 0}, {"nulls": -1}):
        with pytest.raises(SstlError) as said:
            check.make(quick=True, workers=1, **wrong)
        assert said.value.code == "E961"
    assert not list(tmp_path.iterdir())
    (tmp_path / "set").mkdir()
    with pytest.raises(SstlError):
        sstl.BlindSet(tmp_path / "set").make(quick=True, workers=1, simulator="brissle")
    # a folder that was there stays
    assert not list((tmp_path / "set").iterdir())
    with pytest.raises(SstlError) as said:
        sstl.blind_library(tmp_path / "l.parquet", cases=3, simulator="brissle")
    assert said.value.code == "E961" and not list(tmp_path.glob("l.parquet*"))


def test_the_weights_of_a_file_that_is_no_library_are_not_learned(tmp_path: Path) -> None:
    shutil.copy(Path(__file__).parents[2] / "data/samples/log.parquet", tmp_path / "log.parquet")
    with pytest.raises(SstlError):
        sstl.blind_learn(tmp_path / "log.parquet", out=tmp_path / "w.json")
    assert not (tmp_path / "w.json").exists()
