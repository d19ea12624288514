"""Ctrl-C wherever it meets the program: the exit code is the program's own, and no process is waited for."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from tests.batch.batch_processes import group

CAUGHT = """
import os, signal, sys
from sstl_cli.core.workers import stop_on_signals

def ctrl_c():
    os.kill(os.getpid(), getattr(signal, sys.argv[1]))

stop_on_signals("")
try:
    # as inspect and dataclasses do: code from a string
    exec("ctrl_c()\\nfor _ in range(1000): pass")
except KeyboardInterrupt:
    sys.exit(7)
"""

LOST = """
import os, signal, sys, time
from pathlib import Path
from sstl_cli.core import workers

class Unlucky:
    def __del__(self):
        os.kill(os.getpid(), signal.SIGINT)
        # Python throws away what is raised here
        time.sleep(0.1)

workers.PATIENCE_S = 0.5
sys.unraisablehook = lambda _: None
workers.stop_on_signals("interrupted\\n")
os.mkdir("half")
with workers.at_work_in(Path("half")):
    Unlucky()
    if sys.argv[1:]:
        workers.goes_on()
    time.sleep(3 if sys.argv[1:] else 100)
"""

SHARED = """
import sys, time
from sstl_cli.core.processes import processes
from sstl_cli.core.workers import stop_on_signals

def work(seconds):
    print("working", flush=True)
    time.sleep(seconds)

if __name__ == "__main__":
    stop_on_signals("")
    try:
        with processes(2) as pool:
            for job in [pool.submit(work, 100) for _ in range(6)]:
                job.result()
    except KeyboardInterrupt:
        sys.exit(7)
"""

HELD = """
import os, signal
from sstl_cli.core.processes import processes

def held(_):
    return signal.SIGINT in signal.pthread_sigmask(signal.SIG_BLOCK, ())

if __name__ == "__main__":
    with processes(2) as pool:
        print(all(pool.map(held, range(8))), flush=True)
"""

HELD_IN_BATCH = """
import os, signal
from joblib import Parallel, delayed
from sstl_cli.core.workers import interrupts_held

def held(_):
    return signal.SIGINT in signal.pthread_sigmask(signal.SIG_BLOCK, ())

if __name__ == "__main__":
    import tried
    with interrupts_held():
        print(all(Parallel(n_jobs=2, batch_size=1)(delayed(tried.held)(i) for i in range(8))), flush=True)
"""


def _start(folder: Path, text: str, *words: str) -> subprocess.Popen[str]:
    (folder / "tried.py").write_text(text)
    path = os.pathsep.join([str(folder), str(Path(__file__).parents[2])])
    return subprocess.Popen(
        # a module: a script's end is another path through the interpreter
        [sys.executable, "-m", "tried", *words],
        text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE, start_new_session=True, cwd=folder,
        env={**os.environ, "PYTHONPATH": path},
    )  # fmt: skip


@pytest.mark.parametrize("how", ["SIGINT", "SIGTERM", "SIGHUP"])
def test_ctrl_c_in_code_from_a_string_keeps_the_exit_code(tmp_path: Path, how: str) -> None:
    tried = _start(tmp_path, CAUGHT, how)
    _, told = tried.communicate(timeout=60)
    assert (tried.returncode, told) == (7, "")


def test_a_program_that_lost_its_ctrl_c_ends_all_the_same(tmp_path: Path) -> None:
    tried = _start(tmp_path, LOST)
    _, told = tried.communicate(timeout=60)
    assert (tried.returncode, told) == (1, "interrupted\n")
    assert not (tmp_path / "half").exists()


def test_a_program_that_goes_on_after_ctrl_c_is_left_alone(tmp_path: Path) -> None:
    tried = _start(tmp_path, LOST, "goes on")
    _, told = tried.communicate(timeout=60)
    assert (tried.returncode, told) == (0, "")
    assert (tmp_path / "half").exists()


@pytest.mark.parametrize("whole_group", [False, True])
def test_ctrl_c_throws_away_what_processes_are_at(tmp_path: Path, whole_group: bool) -> None:
    tried = _start(tmp_path, SHARED)
    assert tried.stdout is not None and tried.stdout.readline() == "working\n"
    (os.killpg if whole_group else os.kill)(tried.pid, signal.SIGINT)
    begun = time.monotonic()
    _, told = tried.communicate(timeout=60)
    assert (tried.returncode, told) == (7, "")
    # the jobs would have gone on for 100 s
    assert time.monotonic() - begun < 50
    while group(tried.pid):
        assert time.monotonic() - begun < 60
        time.sleep(0.05)


@pytest.mark.parametrize("text", [HELD, HELD_IN_BATCH], ids=["processes", "batch"])
def test_the_first_process_leaves_ctrl_c_to_the_program_too(tmp_path: Path, text: str) -> None:
    said, told = _start(tmp_path, text).communicate(timeout=60)
    assert (said, told) == ("True\n", "")
