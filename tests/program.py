"""The program run inside the process of the tests, which is quicker by the start of another."""

from __future__ import annotations

import contextlib
import subprocess
from pathlib import Path

from sstl_cli.cli._batch_worker import call_program


def inside(*words: object, cwd: Path | None = None, **environment: str) -> subprocess.CompletedProcess[str]:
    """Run ``sstl`` in this process, in a folder and with variables of its own."""
    told = [str(w) for w in words]
    with contextlib.chdir(cwd or Path.cwd()):
        return subprocess.CompletedProcess(told, *call_program(told, environment))
