"""The two commands as a user runs them."""

import json
import subprocess
import sys
from pathlib import Path

import pytest
import reporting_inputs as made
from program import inside

SIGNATURE = {"png": b"\x89PNG", "svg": b"<?xml", "pdf": b"%PDF"}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    path = tmp_path_factory.mktemp("cli")
    made.write_all(path)
    return path


def sstl(folder, *words):
    return inside(*words, cwd=folder)


def test_report_as_json(folder):
    done = sstl(folder, "report", "log.parquet", "theta.parquet", "diagnosis.json", "--out", "r.html", "--title", "My rig", "--json")
    assert done.returncode == 0 and done.stderr == ""
    document = json.loads(done.stdout)
    assert document["schema"] == "sstl.report/1" and document["sections"] == ["diagnosis", "logs", "theta", "effects"]
    html = (folder / "r.html").read_text()
    assert "<h1>My rig</h1>" in html and len(html.encode()) == document["bytes"]
    again = sstl(folder, "report", "log.parquet", "--out", "r.html")
    assert again.returncode == 1 and "E102" in again.stderr
    assert (folder / "r.html").read_text() == html


PLOTS = [
    ("png", ["log.parquet", "phases.parquet", "theta.parquet"], "loop"), ("svg", ["diagnosis.json"], "waterfall"),
    ("pdf", ["theta.parquet"], "theta"), ("svg", ["commands.parquet"], "tracking"),
    ("svg", ["blind.json"], "confusion"),
]  # fmt: skip
# one process for all of them, as its start takes longer than they do; in an order of its own
APART = """
import json, sys
sys.path.insert(0, sys.argv[1])
from program import inside
for words in json.loads(sys.argv[2]):
    inside(*words).check_returncode()
"""


@pytest.fixture(scope="module")
def apart(folder):
    """The folder in which another process has drawn all figures of PLOTS."""
    made = [["plot", *files, "--out", f"b-{kind}.{form}"] for form, files, kind in reversed(PLOTS)]
    words = [sys.executable, "-c", APART, str(Path(__file__).parents[1]), json.dumps(made)]
    subprocess.run(words, cwd=folder, check=True, timeout=120)
    return folder


@pytest.mark.parametrize(("form", "files", "kind"), PLOTS)
def test_plot_chooses_the_figure_and_repeats_its_bytes(apart, form, files, kind):
    done = sstl(apart, "plot", *files, "--out", f"a-{kind}.{form}", "--json")
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["kind"] == kind
    # one process and another: nothing that a process holds may show in the bytes
    outs = [(apart / f"{name}-{kind}.{form}").read_bytes() for name in "ab"]
    assert outs[0] == outs[1] and outs[0].startswith(SIGNATURE[form])


@pytest.mark.parametrize(("words", "status", "text"), [
    (["plot", "log.parquet", "--out", "x.gif"], 2, "E610"),
    (["plot", "log.parquet", "--out", "x.png", "--kind", "lop"], 2, "did you mean 'loop'?"),
    (["plot", "log.parquet", "--out", "x.png", "--run", "nobody"], 1, "E609"),
    (["plot", "model.safetensors", "--out", "x.png"], 1, "E609"),
    (["report", "model.safetensors", "nothing.json", "--out", "x.html"], 1, "E601"),
    (["report", "log.parquet"], 2, "--out"),
])  # fmt: skip
def test_failures_are_one_line_and_leave_nothing(folder, words, status, text):
    before = sorted(folder.iterdir())
    done = sstl(folder, *words)
    assert done.returncode == status and text in done.stderr and "Traceback" not in done.stderr
    assert sorted(folder.iterdir()) == before


@pytest.mark.parametrize("command", ["report", "plot"])
def test_help_has_an_example(folder, command):
    done = sstl(folder, command, "--help")
    assert done.returncode == 0 and "Example: sstl " + command in " ".join(done.stdout.split())
