"""kill -9 at random moments: an output is the old file or the new one, whole, and a rerun completes.

As a script: ``python tests/trust/kill_writers.py KILLS [--publish]`` (200 kills take some minutes).
"""

from __future__ import annotations

import contextlib
import json
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

from trust_program import SSTL, write_csv, write_log

COMMANDS = ("import", "segment", "batch", "blind run")
# one in how many rounds a command takes part: a diagnosis takes seconds
EVERY = {"blind run": 3}


class Writer:
    """One command that writes into ``out``, and what it writes there when nothing disturbs it."""

    def __init__(self, command: str, folder: Path) -> None:
        self.command = command
        self.folder = folder / command.replace(" ", "-")
        self.out = self.folder / "out"
        self.folder.mkdir()
        self.words = self._words()
        self.out.mkdir(exist_ok=True)
        started = time.monotonic()
        subprocess.run([*SSTL, *self.words], check=True, capture_output=True)
        self.seconds = time.monotonic() - started
        self.good = self.visible()
        assert self.good

    def _words(self) -> list[str]:
        if self.command == "import":
            source = write_csv(self.folder / "r.csv", samples=20_000)
            return ["import", str(source), "--out", str(self.out / "r.parquet"), "--force"]
        if self.command == "segment":
            source = write_log(self.folder / "r.parquet", runs=6, samples=4000)
            phases = str(self.out / "phases.parquet")
            return ["segment", str(source), "--out", str(self.out / "t.parquet"), "--phases", phases, "--force"]
        if self.command == "batch":
            logs = [str(write_log(self.folder / f"r{i}.parquet", seed=i)) for i in range(4)]
            return ["batch", "segment", *logs, "--out-dir", str(self.out), "--workers", "2"]
        cases = self.folder / "set"
        make = ["blind", "make", str(cases), "--cases", "2", "--quick", "--seed", "5", "--workers", "1"]
        subprocess.run([*SSTL, *make], check=True, capture_output=True)
        self.out = cases / "results"
        return ["blind", "run", str(cases), "--workers", "1"]

    def visible(self) -> dict[str, bytes]:
        """Return the files that a user or another command would take for outputs."""
        found = {p.name: p.read_bytes() for p in self.out.iterdir() if p.is_file() and not p.name.startswith(".")}
        return {name: self._untimed(body) for name, body in found.items()}

    def _untimed(self, body: bytes) -> bytes:
        """Return a result of ``blind run`` without the seconds that it took, which differ from run to run."""
        if self.command != "blind run" or body == OLD:
            return body
        return json.dumps({k: v for k, v in json.loads(body).items() if k != "seconds"}).encode()

    def kill_once(self, rng: random.Random, old: bool) -> bool:
        """Start, kill, look; return whether the kill fell into the run."""
        shutil.rmtree(self.out)
        self.out.mkdir()
        # a batch keeps files that no batch made, and does not start
        before = dict.fromkeys(self.good, OLD) if old and self.command != "batch" else {}
        for name, body in before.items():
            (self.out / name).write_bytes(body)
        quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
        process = subprocess.Popen([*SSTL, *self.words], start_new_session=True, **quiet)
        time.sleep(self.seconds * rng.uniform(0.2, 1.05))
        process.send_signal(signal.SIGKILL)
        hit = process.wait() == -signal.SIGKILL
        with contextlib.suppress(ProcessLookupError):
            # workers whose program is gone
            os.killpg(process.pid, signal.SIGKILL)
        for name, body in self.visible().items():
            assert name in self.good, f"a stray file {name} looks like an output"
            assert body in (before.get(name), self.good[name]), f"{name} is neither old nor new"
        for name in before:
            assert (self.out / name).exists(), f"{name} was lost"
        return hit

    def rerun(self) -> None:
        """Run again after a kill: everything is there, whole."""
        done = subprocess.run([*SSTL, *self.words], capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
        assert self.visible() == self.good
        assert not list(self.out.glob(".batch/work-*")), "leftovers of a killed batch"


OLD = b"old"


def run(kills: int, seed: int, folder: Path, commands: tuple[str, ...] = COMMANDS, rerun_every: int = 4) -> dict[str, list[int]]:
    """Kill each command in turn; return, by command, how many kills, kills in mid-run and whole reruns there were."""
    rng = random.Random(seed)
    writers = [Writer(command, folder) for command in commands]
    told = {w.command: [0, 0, 0] for w in writers}
    number = 0
    while sum(t[0] for t in told.values()) < kills:
        for writer in writers:
            count = told[writer.command]
            if number % EVERY.get(writer.command, 1) or sum(t[0] for t in told.values()) >= kills:
                continue
            count[1] += writer.kill_once(rng, rng.random() < 0.5)
            count[0] += 1
            if count[0] % rerun_every == 0:
                writer.rerun()
                count[2] += 1
        number += 1
    return told


def main(kills: int, publish: bool) -> None:
    """Run, print and, on demand, put the table into docs/trust.md."""
    sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tools"))
    from page_part import put, table

    with tempfile.TemporaryDirectory() as name:
        told = run(kills, 4, Path(name))
    rows = [[f"`sstl {command}`", *counts, 0] for command, counts in told.items()]
    text = table(["command", "kills", "of them in mid-run", "reruns after a kill, all complete", "files damaged or lost"], rows)
    print(text)
    if publish:
        put("trust.md", "kill", text)


if __name__ == "__main__":
    main(int(sys.argv[1]), "--publish" in sys.argv)
