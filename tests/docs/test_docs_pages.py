"""The documents hang together: links, drawings, examples for build servers, and the reference of every field."""

from __future__ import annotations

import json
import re
import subprocess
import sys
import tomllib
from pathlib import Path
from xml.etree import ElementTree

import pytest
import typer
import yaml

from sstl_cli.cli import _gates
from sstl_cli.cli import app as program
from sstl_cli.core.documents.diagnosis import Candidate, DiagnosisDocument, Gap, Place, Verdict

ROOT = Path(__file__).parents[2]
PAGES = sorted([*ROOT.glob("*.md"), *(ROOT / "docs").glob("*.md")])


def anchors(path: Path) -> set[str]:
    """Return the places in a document that a link may lead to."""
    heads = re.findall(r"^#+ (.*)$", path.read_text(encoding="utf-8"), re.M)
    return {re.sub(r"[^\w\- ]", "", h.lower()).replace(" ", "-") for h in heads}


@pytest.mark.parametrize("page", PAGES, ids=lambda p: p.name)
def test_every_link_leads_somewhere(page: Path) -> None:
    for target in re.findall(r"\]\((?!https?:)([^)\s]+)\)", page.read_text(encoding="utf-8")):
        name, _, place = target.partition("#")
        file = (page.parent / name) if name else page
        assert file.exists(), f"{page.name}: {target}"
        assert not place or place in anchors(file), f"{page.name}: {target}"


@pytest.mark.parametrize("name", ["rig.svg", "loop.svg"])
def test_drawings_are_well_formed_and_say_what_they_show(name: str) -> None:
    tree = ElementTree.parse(ROOT / "docs" / name).getroot()
    texts = [e.text for e in tree if e.tag.endswith(("title", "desc"))]
    assert len(texts) == 2 and all(texts) and tree.get("role") == "img"


def test_the_reference_has_every_field() -> None:
    done = subprocess.run([sys.executable, ROOT / "tools/reference_doc.py", "--check"], capture_output=True, text=True, cwd=ROOT)
    assert done.returncode == 0, done.stdout + done.stderr
    text = (ROOT / "docs/reference.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| `[^`]+` \| .* \|(.*)\|$", text, re.M)
    # a name and a type alone tell little
    assert len(rows) > 400 and sum(not r.strip() for r in rows) < 0.1 * len(rows)


def test_commands_that_pages_name_exist() -> None:
    program._register()
    known = typer.main.get_command(program.app).commands
    for page in PAGES:
        for name in re.findall(r"(?:`|\$ )sstl ([a-z]+)", page.read_text(encoding="utf-8")):
            assert name in known, f"{page.name}: sstl {name}"


def test_examples_for_build_servers_parse_and_use_real_options() -> None:
    text = (ROOT / "docs/ci.md").read_text(encoding="utf-8")
    flow, hooks = (yaml.safe_load(b) for b in re.findall(r"```yaml\n(.*?)```", text, re.S))
    lines = [s["run"] for s in flow["jobs"]["gap"]["steps"] if "run" in s] + [h["entry"] for r in hooks["repos"] for h in r["hooks"]]
    commands = [c for line in lines for c in re.findall(r"sstl [^\n&]+(?:\\\n[^\n]+)*", line.replace("\\\n", " ")) if "pip" not in line]
    assert len(commands) >= 5
    program._register()
    root = typer.main.get_command(program.app)
    for command in commands:
        words = command.split()
        options = {o for p in root.get_command(typer.Context(root), words[1]).params for o in p.opts}
        assert {w for w in words if w.startswith("--")} <= options, command


def test_the_scenario_and_config_examples_are_toml() -> None:
    for page in PAGES:
        for block in re.findall(r"```toml\n(.*?)```", page.read_text(encoding="utf-8"), re.S):
            tomllib.loads(block)


def test_the_container_copies_what_is_there() -> None:
    text = (ROOT / "Containerfile").read_text()
    for line in re.findall(r"^COPY (.*)$", text, re.M):
        assert all((ROOT / word).exists() for word in line.split()[:-1]), line
    assert re.search(r"^USER rig$", text, re.M)
    torch = re.search(r"torch==[\d.]+", text)[0]
    assert torch in (ROOT / "Makefile").read_text()


DOCUMENT = DiagnosisDocument.model_construct(
    sentence="It comes from <b>.",
    verdict=Verdict.model_construct(status="identified"),
    gap=Gap.model_construct(rmse_base_n=0.9, rmse_retuned_n=0.3, rmse_with_effect_n=None, noise_floor_n=0.02),
    where=[Place(system="sstl", phase="RB", config_id="a|b", share_pct=40.0, rmse_n=0.1)],
    candidates=[Candidate.model_construct(id="x_y", probability=1e-9, shrink_pct=1.0)],
)


def test_junit_has_a_case_a_gate() -> None:
    asked = {"--max-rmse": 0.1, "--max-gap-pct": None, "--expect": "none"}
    suite = ElementTree.fromstring(_gates.junit(asked, ["--expect: verdict is <identified>\x1b"], "It comes from <b>."))
    assert suite.get("tests") == "2" and suite.get("failures") == "1"
    failed = {c.get("name"): c.find("failure") for c in suite}
    assert failed["--max-rmse 0.1"] is None
    assert failed["--expect none"].get("message") == "--expect: verdict is <identified>\\x1b"
    # without a gate there is one case, and it passes
    assert ElementTree.fromstring(_gates.junit({"--expect": None}, [], "s")).get("failures") == "0"


def test_the_summary_is_plain_markdown() -> None:
    text = _gates.markdown(DOCUMENT, ["--expect: no"])
    assert "\\<b\\>" in text and "a\\|b" in text and "x\\_y" in text and "| with the effect | - |" in text
    assert "**gate missed**: --expect: no" in text and "0.001" in text
    assert "candidate" not in _gates.markdown(DOCUMENT.model_copy(update={"verdict": Verdict.model_construct(status="none")}), [])


def test_the_notebook_is_a_notebook_without_outputs() -> None:
    found = json.loads((ROOT / "docs/notebook.ipynb").read_text(encoding="utf-8"))
    assert found["nbformat"] == 4 and found["cells"][0]["cell_type"] == "markdown"
    assert all(not c["outputs"] and c["execution_count"] is None for c in found["cells"] if c["cell_type"] == "code")
