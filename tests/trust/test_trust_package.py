"""What is handed out: licence, citation, a source distribution that can be tested, and a Makefile that finds its Python."""

from __future__ import annotations

import os
import re
import shutil
import stat
import subprocess
import sys
import tarfile
import tomllib
import zipfile
from pathlib import Path

import pytest
import yaml

import sstl_cli

ROOT = Path(__file__).resolve().parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
LEAVE_OUT = (".venv", ".git", "build", "__pycache__", "*.egg-info", ".*_cache", ".hypothesis")


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the sdist and the wheel of this tree."""
    pytest.importorskip("setuptools.build_meta")
    folder = tmp_path_factory.mktemp("built")
    shutil.copytree(ROOT, folder / "tree", ignore=shutil.ignore_patterns(*LEAVE_OUT), symlinks=True)
    for part in (folder / "tree").rglob("*"):
        # a tree that cannot be written is built from a copy that can
        if not part.is_symlink():
            part.chmod(part.stat().st_mode | stat.S_IWUSR)
    (folder / "tree").chmod(0o755)
    code = "from setuptools import build_meta as b; b.build_sdist('..'); b.build_wheel('..')"
    environment = {k: v for k, v in os.environ.items() if k != "PYTHONPATH"}
    done = subprocess.run([sys.executable, "-c", code], cwd=folder / "tree", capture_output=True, text=True, env=environment)
    assert done.returncode == 0, done.stderr[-800:]
    return folder


def test_the_sdist_holds_what_is_needed_to_test_it(built: Path) -> None:
    with tarfile.open(next(built.glob("*.tar.gz"))) as archive:
        names = {n.partition("/")[2] for n in archive.getnames()}
    files = (
        ".pre-commit-config.yaml",
        "LICENSE",
        "CITATION.cff",
        "CHANGELOG.md",
        "CONTRIBUTING.md",
        "Makefile",
        "constraints.txt",
        "hashes.txt",
    )
    assert set(files) <= names
    for folder in ("tests", "docs", "data", "benchmarks", "tools", "sstl_cli"):
        missing = {str(p.relative_to(built / "tree")) for p in (built / "tree" / folder).rglob("*") if p.is_file()} - names
        assert not {m for m in missing if "__pycache__" not in m}, folder


def test_the_wheel_holds_the_licence_and_no_tests(built: Path) -> None:
    with zipfile.ZipFile(next(built.glob("*.whl"))) as archive:
        names = archive.namelist()
        [licence] = [n for n in names if n.endswith("LICENSE")]
        assert archive.read(licence) == (ROOT / "LICENSE").read_bytes()
    assert {n.split("/")[0].split("-")[0] for n in names} == {"sstl_cli"}


def test_licence_and_citation_agree_with_the_project() -> None:
    assert PROJECT["license"] == "MIT" and "MIT License" in (ROOT / "LICENSE").read_text(encoding="utf-8")
    citation = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    assert re.search(rf"^version: {re.escape(sstl_cli.__version__)}$", citation, re.MULTILINE)
    assert re.search(r"^license: MIT$", citation, re.MULTILINE)
    assert PROJECT["authors"][0]["name"] in citation


def test_the_changelog_begins_with_this_version_and_docs_cite_it() -> None:
    newest = re.search(r"^## (.+)$", (ROOT / "CHANGELOG.md").read_text(encoding="utf-8"), re.MULTILINE)
    assert newest is not None and newest[1] == sstl_cli.__version__
    assert f"version = {{{sstl_cli.__version__}}}" in (ROOT / "docs" / "cite.md").read_text(encoding="utf-8")


@pytest.mark.skipif(shutil.which("make") is None, reason="no make here")
@pytest.mark.parametrize(
    ("there", "taken"),
    [({"python3.11": True, "python3.12": True}, "python3.11"), ({"python3.11": False, "python3.13": True}, "python3.13"),
     ({"python3": True}, "python3"), ({"python3": False}, None)],
)  # fmt: skip
def test_make_takes_a_python_that_the_package_allows(there, taken, tmp_path: Path) -> None:
    path = tmp_path / "bin"
    path.mkdir()
    for name in ("make", "sh", "test", "echo", "find", "touch"):
        found = shutil.which(name)
        if found:
            (path / name).symlink_to(found)
    for name, fits in there.items():
        # stands for a Python of that name that answers whether its version fits
        (path / name).write_text(f"#!/bin/sh\n{f'echo {name}' if fits else 'exit 0'}\n")
        (path / name).chmod(0o755)
    shutil.copy(ROOT / "Makefile", tmp_path)
    for name in ("pyproject.toml", "constraints.txt"):
        (tmp_path / name).touch()
    (tmp_path / "sstl_cli").mkdir()
    words = ["make", "--dry-run", "install"] if taken else ["make", "install"]
    done = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True, env={"PATH": str(path)})
    if taken:
        assert f"{taken} -m venv .venv" in done.stdout, done.stderr
    else:
        assert done.returncode == 2 and "no Python 3.11, 3.12 or 3.13 found" in done.stderr


def test_what_runs_before_a_commit_is_what_lint_runs() -> None:
    lint = re.search(r"^lint:.*\n((?:\t.+\n)+)", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE)
    assert lint is not None
    wanted = [line.strip().replace("$(BIN)", ".venv/bin") for line in lint[1].splitlines()]
    hooks = yaml.safe_load((ROOT / ".pre-commit-config.yaml").read_text(encoding="utf-8"))["repos"][0]["hooks"]
    assert [h["entry"] for h in hooks] == wanted and all(h["language"] == "system" for h in hooks)
