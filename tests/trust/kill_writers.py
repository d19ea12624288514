"""kill -9 at random moments: an output is the old file or the new one, whole, and a rerun completes.

As a script: ``python tests/trust/kill_writers.py KILLS [SEED]`` (200 kills take some minutes).
"""

from __future__ import annotations

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

COMMANDS = ("import", "segment", "batch")


class Writer:
    """One command that writes into ``out``, and the bytes that it writes when nothing disturbs it."""

    def __init__(self, command: str, folder: Path) -> None:
        self.folder = folder / command
        self.out = self.folder / "out"
        self.out.mkdir(parents=True)
        if command == "import":
            source = write_csv(self.folder / "r.csv", samples=20_000)
            self.words = ["import", str(source), "--out", str(self.out / "r.parquet"), "--force"]
        elif command == "segment":
            source = write_log(self.folder / "r.parquet", runs=6, samples=4000)
            phases = str(self.out / "phases.parquet")
            self.words = ["segment", str(source), "--out", str(self.out / "t.parquet"), "--phases", phases, "--force"]
        else:
            logs = [str(write_log(self.folder / f"r{i}.parquet", seed=i)) for i in range(4)]
            self.words = ["batch", "segment", *logs, "--out-dir", str(self.out), "--workers", "2"]
        started = time.monotonic()
        subprocess.run([*SSTL, *self.words], check=True, capture_output=True)
        self.seconds = time.monotonic() - started
        self.good = self.visible()

    def visible(self) -> dict[str, bytes]:
        """Return the files that a user or another command would take for outputs."""
        return {p.name: p.read_bytes() for p in self.out.iterdir() if p.is_file() and not p.name.startswith(".")}

    def kill_once(self, rng: random.Random, old: bytes | None) -> bool:
        """Start, kill, look; return whether the kill fell into the run."""
        shutil.rmtree(self.out)
        self.out.mkdir()
        before = {name: old for name in self.good} if old is not None and "batch" not in self.words else {}
        for name, body in before.items():
            (self.out / name).write_bytes(body)
        process = subprocess.Popen([*SSTL, *self.words], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        time.sleep(self.seconds * rng.uniform(0.3, 1.05))
        process.send_signal(signal.SIGKILL)
        hit = process.wait() == -signal.SIGKILL
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


def run(kills: int, seed: int, folder: Path, rerun_every: int = 4) -> int:
    """Kill each command in turn; return how many kills fell into a run."""
    rng = random.Random(seed)
    writers = [Writer(command, folder) for command in COMMANDS]
    hits = 0
    for i in range(kills):
        writer = writers[i % len(writers)]
        hits += writer.kill_once(rng, b"old" if rng.random() < 0.5 else None)
        if (i // len(writers)) % rerun_every == rerun_every - 1:
            writer.rerun()
    return hits


if __name__ == "__main__":
    kills = int(sys.argv[1])
    with tempfile.TemporaryDirectory() as name:
        hits = run(kills, int(sys.argv[2]) if len(sys.argv) > 2 else 0, Path(name))
    print(f"{kills} kills, {hits} of them in mid-run: every output whole, every rerun complete (pid {os.getpid()})")
