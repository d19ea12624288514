"""The documents say what the program does: README's commands run as they stand, and every link leads somewhere."""

from __future__ import annotations

import contextlib
import re
import shlex
import shutil
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest

from sstl_cli.cli._batch_worker import call_program
from sstl_cli.core.runs import read_runs

ROOT = Path(__file__).parents[2]
SAMPLE = ROOT / "data/samples/log.parquet"
README = (ROOT / "README.md").read_text(encoding="utf-8")
COMMANDS = [line[2:] for block in re.findall(r"```console\n(.*?)```", README, re.S) for line in block.splitlines() if line.startswith("$ ")]
LBF = 4.4482216152605


@pytest.fixture(scope="module")
def walked(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder after every command of README ran in it, in order."""
    folder = tmp_path_factory.mktemp("readme")
    shutil.copy(SAMPLE, folder / "log.parquet")
    (folder / "rig.toml").write_text(re.findall(r"```toml\n(.*?)```", README, re.S)[0])
    for run in read_runs(SAMPLE):
        if run.system == "act" and "trapezoid" in run.run_id:
            columns = (run.time_s * 1000, run.tension_in_n / LBF, run.tension_out_n / LBF)
            np.savetxt(folder / f"bend_{str(run.config_id)[-3:]}.txt", np.column_stack(columns), fmt="%.9g")
    (folder / "screens").mkdir()
    with pytest.MonkeyPatch.context() as patch, contextlib.chdir(folder):
        patch.setenv("COLUMNS", "80")
        for command in COMMANDS:
            words = shlex.split(command, comments=True)
            assert words[0] == "sstl", command
            stated = re.search(r"# exit (\d)", command)
            # two dozen starts of the program would take as long as its work
            code, out, err = call_program(words[1:], {})
            assert code == int(stated[1] if stated else 0), f"{command}\n{out[-800:]}\n{err}"
            assert "Traceback" not in err
            Path("screens", f"{words[1]} {Path(words[2]).stem}.txt").write_text(out)
            if command == "sstl diagnose log.parquet --out diagnosis.json":
                Path("screen.txt").write_text(out)
    return folder


def test_the_walk_through_runs(walked: Path) -> None:
    assert len(COMMANDS) >= 15
    assert (walked / "report.html").read_text(encoding="utf-8").count("<section") >= 4


def test_the_shown_screen_is_the_real_one(walked: Path) -> None:
    """Word for word, and number for number but for what another processor rounds otherwise."""
    number = re.compile(r"\d+(?:\.\d+)?")
    # how often such a verdict was right is learned anew with every library
    learned = re.compile(r"right in \d+ of 100")
    shown = re.findall(r"```text\n(.*?)```", README, re.S)[0].splitlines()
    real = (walked / "screen.txt").read_text().splitlines()[: len(shown)]
    assert [number.sub("#", line) for line in real] == [number.sub("#", line) for line in shown]
    for a, b in ((learned.sub("", x), learned.sub("", y)) for x, y in zip(real, shown, strict=True)):
        numbers = [float(x) for x in number.findall(a)]
        assert numbers == pytest.approx([float(x) for x in number.findall(b)], rel=0.02, abs=0.01), (a, b)


def test_every_screen_of_the_walk_through_fits_80_columns(walked: Path) -> None:
    screens = {p.stem: p.read_text().splitlines() for p in (walked / "screens").iterdir()}
    # a proposed mapping is shown as the file that it is
    wide = {name: line for name, lines in screens.items() if "--guess" not in name for line in lines if len(line) > 80}
    assert wide == {}
    # the names of the runs stand whole, and no number needs an exponent to say that it is nothing
    for name in ("info log", "segment log"):
        for run in read_runs(SAMPLE):
            assert any(run.run_id in line for line in screens[name]), (name, run.run_id)
    assert not [x for lines in screens.values() for line in lines for x in re.findall(r"\de-(?:0[4-9]|1\d)", line)]


def test_the_demo_compensates_inside_the_trained_range(walked: Path) -> None:
    shown = re.findall(r"```text\n(.*?)```", README, re.S)[1].split("\n", 1)
    scores = {r["method"]: r["rmse_n"] for r in pq.read_table(walked / "scores.parquet").to_pylist() if r["window"] != "all"}
    assert scores["proposed"] < 0.05 * scores["none"]
    gain = re.match(r"proposed tracks with an error of ([\d.]+) N instead of ([\d.]+) N", shown[0])
    assert (
        gain and float(gain[1]) == pytest.approx(scores["proposed"], rel=0.2) and float(gain[2]) == pytest.approx(scores["none"], rel=0.05)
    )
    assert "comes from the" in " ".join((walked / "screens/diagnose commands.txt").read_text().split())
    training = [r for r in pq.read_table(walked / "training_theta.parquet").to_pylist() if r["system"] == "sstl"]
    for row in pq.read_table(walked / "theta.parquet").to_pylist():
        for name in ("gamma_p", "gamma_r"):
            values = [r[name] for r in training]
            assert row["system"] == "act" or min(values) < row[name] < max(values), (row["run_id"], name)


def test_the_imported_log_gives_the_theta_of_the_sample(walked: Path) -> None:
    mine = pq.read_table(walked / "mine_theta.parquet").to_pylist()
    direct = {r["config_id"]: r for r in pq.read_table(walked / "theta.parquet").to_pylist() if r["run_id"].endswith("trapezoid-act")}
    assert [r["config_id"] for r in mine] == ["020", "080"]
    for row in mine:
        other = direct[f"CP-{row['config_id']}"]
        assert row["gamma_p"] == pytest.approx(other["gamma_p"], rel=1e-4)
        assert row["beta_p"] == pytest.approx(other["beta_p"], abs=1e-3)


def test_the_log_exported_as_csv_comes_back(walked: Path) -> None:
    for a, b in zip(read_runs(walked / "log.parquet"), read_runs(walked / "again.parquet"), strict=True):
        assert (a.run_id, a.config_id, a.system) == (b.run_id, b.config_id, b.system)
        np.testing.assert_array_equal(a.tension_out_n, b.tension_out_n)


def test_every_command_is_in_the_table() -> None:
    from sstl_cli.cli import app as program

    program._register()
    import typer

    real = set(typer.main.get_command(program.app).commands)
    listed = re.findall(r"^\| `([a-z]+)` \|", README, re.M)
    assert sorted(listed) == sorted(real)


def test_the_sample_is_small_and_was_made_as_stated() -> None:
    import json

    assert SAMPLE.stat().st_size < 1_000_000
    made = json.loads(pq.read_schema(SAMPLE).metadata[b"sstl"])["command"].replace(" --force", "")
    recipe = re.search(r"/sstl (simulate .*?--out log\.parquet)", (ROOT / "Makefile").read_text())
    assert recipe is not None and made == f"sstl {recipe[1]}"


def test_index_lists_every_document() -> None:
    index = (ROOT / "docs/index.md").read_text(encoding="utf-8")
    listed = re.findall(r"^\| \[([\w-]+\.md)\]\(\1\)", index, re.M)
    assert sorted(listed) == sorted(p.name for p in (ROOT / "docs").glob("*.md") if p.name != "index.md")


@pytest.mark.parametrize("name", ["README.md", "CONTRIBUTING.md", "CHANGELOG.md", "docs/index.md"])
def test_what_documents_name_exists(name: str) -> None:
    text = (ROOT / name).read_text(encoding="utf-8")
    files = set(re.findall(r"\b((?:docs|tests|sstl_cli|data)/[\w./-]*\w)", text))
    # NAME and PART stand for any name
    missing = [f for f in files if not (ROOT / f).exists() and not re.search("NAME|PART", f)]
    for file, test in re.findall(r"(tests/[\w/.]+\.py)::(\w+)", text):
        if f"def {test}(" not in (ROOT / file).read_text(encoding="utf-8"):
            missing.append(test)
    for target in re.findall(r"\bmake ([a-z-]+)`", text):
        if not re.search(rf"^{target}:", (ROOT / "Makefile").read_text(), re.M):
            missing.append(f"make {target}")
    assert missing == []
