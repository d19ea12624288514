"""docs/errors.md knows every code the program uses, and no other."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools"))

import errors_doc  # noqa: E402


def test_page_is_complete() -> None:
    done = subprocess.run([sys.executable, ROOT / "tools" / "errors_doc.py", "--check"], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def test_a_missing_and_an_unused_code_are_found(tmp_path: Path, monkeypatch) -> None:  # type: ignore[no-untyped-def]
    text = errors_doc.PAGE.read_text()
    lines = [line for line in text.splitlines() if not line.startswith("| E134 ")]
    page = tmp_path / "errors.md"
    page.write_text("\n".join([*lines, "| E199 | a code of nothing | nothing |"]))
    monkeypatch.setattr(errors_doc, "PAGE", page)
    found = " ".join(errors_doc.problems())
    assert "E134 is used" in found and "E199 is documented" in found
