"""The two commands as a user runs them."""

import json
import subprocess
import sys

import pytest
import reporting_inputs as made
from program import inside

SIGNATURE = {"png": b"\x89PNG", "svg": b"<?xml", "pdf": b"%PDF"}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    path = tmp_path_factory.mktemp("cli")
    made.write_all(path)
    return path


def sstl(folder, *words, apart=False):
    """Run the program in this process, or in one ``apart``, whose start takes longer than most of what is asked here."""
    if apart:
        return subprocess.run([sys.executable, "-m", "sstl_cli", *words], cwd=folder, capture_output=True, text=True, timeout=120)
    return inside(*words, cwd=folder)


def test_report_as_json(folder):
    done = sstl(
        folder, "report", "log.parquet", "theta.parquet", "diagnosis.json", "--out", "r.html", "--title", "My rig", "--json", apart=True
    )
    assert done.returncode == 0 and done.stderr == ""
    document = json.loads(done.stdout)
    assert document["schema"] == "sstl.report/1" and document["sections"] == ["diagnosis", "logs", "theta", "effects"]
    html = (folder / "r.html").read_text()
    assert "<h1>My rig</h1>" in html and len(html.encode()) == document["bytes"]
    again = sstl(folder, "report", "log.parquet", "--out", "r.html")
    assert again.returncode == 1 and "E102" in again.stderr
    assert (folder / "r.html").read_text() == html


@pytest.mark.parametrize(("form", "files", "kind"), [
    ("png", ["log.parquet", "phases.parquet", "theta.parquet"], "loop"), ("svg", ["diagnosis.json"], "waterfall"),
    ("pdf", ["theta.parquet"], "theta"), ("svg", ["commands.parquet"], "tracking"),
    ("svg", ["blind.json"], "confusion"),
])  # fmt: skip
def test_plot_chooses_the_figure_and_repeats_its_bytes(folder, form, files, kind):
    outs = []
    for name in ("a", "b"):
        # one process and another: nothing that a process holds may show in the bytes
        done = sstl(folder, "plot", *files, "--out", f"{name}-{kind}.{form}", "--json", apart=name == "b")
        assert done.returncode == 0, done.stderr
        assert json.loads(done.stdout)["kind"] == kind
        outs.append((folder / f"{name}-{kind}.{form}").read_bytes())
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
