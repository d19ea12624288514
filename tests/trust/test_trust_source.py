"""What must not stand in the program: code that runs what it reads."""

from __future__ import annotations

import ast
import json
import re
import subprocess
import sys
import tomllib
from fnmatch import fnmatch
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2] / "sstl_cli"
CALLS = {"eval", "exec", "compile", "__import__", "system", "popen"}
MODULES = {"pickle", "cPickle", "dill", "shelve", "marshal", "cloudpickle", "code"}


def offences(text: str) -> list[str]:
    """Return the calls and imports that would run what is read, with their lines."""
    found = []
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, (ast.Import, ast.ImportFrom)):
            names = [a.name for a in node.names] if isinstance(node, ast.Import) else [node.module or ""]
            found += [f"line {node.lineno}: import {n}" for n in names if n.split(".")[0] in MODULES]
        if not isinstance(node, ast.Call):
            continue
        f = node.func
        owner = f.value.id if isinstance(f, ast.Attribute) and isinstance(f.value, ast.Name) else ""
        name = f.id if isinstance(f, ast.Name) else f"{owner}.{f.attr}" if isinstance(f, ast.Attribute) else ""
        if name in CALLS or name in {f"os.{c}" for c in CALLS} or name in {"torch.load", "joblib.load", "yaml.load"}:
            found.append(f"line {node.lineno}: {name}")
        for key in node.keywords:
            value = key.value.value if isinstance(key.value, ast.Constant) else None
            if (key.arg == "shell" and value is not False) or (key.arg == "allow_pickle" and value is not False):
                found.append(f"line {node.lineno}: {key.arg}")
    return found


@pytest.mark.parametrize(
    "text",
    ["import pickle", "from pickle import load", "eval(x)", "os.system(x)", "run(x, shell=True)", "torch.load(p)",
     "np.load(p, allow_pickle=True)", "exec(x)"],
)  # fmt: skip
def test_the_scan_finds_them(text: str) -> None:
    assert offences(text)


def test_the_program_has_none() -> None:
    found = {str(p.relative_to(ROOT)): o for p in ROOT.rglob("*.py") if (o := offences(p.read_text(encoding="utf-8")))}
    assert found == {}


def gone(text: str) -> list[str]:
    """Return the modules of our own that are imported, at whatever depth, and do not exist."""
    named = set()
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Import):
            named |= {a.name for a in node.names}
        elif isinstance(node, ast.ImportFrom) and not node.level:
            named.add(node.module or "")
    own = [n for n in named if n.split(".")[0] == "sstl_cli"]
    at = {n: ROOT.parent.joinpath(*n.split(".")) for n in own}
    return sorted(n for n, path in at.items() if not path.with_suffix(".py").is_file() and not (path / "__init__.py").is_file())


def test_every_import_of_a_module_of_our_own_finds_it() -> None:
    assert gone("def f():\n    import sstl_cli.gone\n    from sstl_cli.cli import check\n    import numpy") == ["sstl_cli.gone"]
    found = {str(p.relative_to(ROOT)): g for p in ROOT.rglob("*.py") if (g := gone(p.read_text(encoding="utf-8")))}
    assert found == {}


def test_types_are_missing_of_named_libraries_only() -> None:
    mypy = tomllib.loads((ROOT.parent / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["mypy"]
    named = [name for part in mypy["overrides"] for name in part["module"]]
    assert "ignore_missing_imports" not in mypy and not any(n.startswith(("*", "sstl")) for n in named)


def spelled(pattern: str) -> list[str]:
    """Return the patterns that one with braces stands for."""
    if not (found := re.search(r"\{([^}]*)\}", pattern)):
        return [pattern]
    return [p for word in found[1].split(",") for p in spelled(pattern[: found.start()] + word + pattern[found.end() :])]


def test_every_rule_that_is_ignored_for_some_files_would_be_broken_there() -> None:
    root = ROOT.parent
    given = tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["ruff"]["lint"]["per-file-ignores"]
    asked = ["check", "--no-cache", "--exit-zero", "--output-format", "json", "--config", "lint.per-file-ignores={}", "."]
    done = subprocess.run([sys.executable, "-m", "ruff", *asked], cwd=root, capture_output=True, text=True, check=True)
    broken = {(Path(f["filename"]).relative_to(root).as_posix(), f["code"]) for f in json.loads(done.stdout)}
    ignored = [(p, rule) for pattern, rules in given.items() for p in spelled(pattern) for rule in rules]
    needless = [(p, rule) for p, rule in ignored if not any(fnmatch(file, p) and code.startswith(rule) for file, code in broken)]
    assert ignored and needless == []
