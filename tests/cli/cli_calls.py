"""The program called as a user calls it: as a process of its own, or here."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from sstl_cli.cli import app as program


def sstl(*words: object, cwd: Path | None = None, **env: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "sstl_cli", *map(str, words)]
    return subprocess.run(command, cwd=cwd, capture_output=True, text=True, env={**os.environ, **env}, timeout=60)


def run_here(monkeypatch: pytest.MonkeyPatch, *words: object) -> int:
    """Run the program in this process and return its exit code."""
    monkeypatch.setattr(sys, "argv", ["sstl", *map(str, words)])
    with pytest.raises(SystemExit) as end:
        program.main()
    return int(end.value.code or 0)
