"""Damaged files of every kind the program reads back: the answer is a value or one SstlError, soon and small."""

from __future__ import annotations

import contextlib
import signal
import sys
import tempfile
import time
import warnings
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parents[1]))
sys.path.insert(0, str(Path(__file__).parent))

from fuzz_mutations import mutated
from program import inside

from sstl_cli.core.errors import SstlError

MAX_SECONDS = 20


def _log(path: Path) -> None:
    from sstl_cli.core.runs import read_runs
    from sstl_cli.identification import segment_run

    for run in read_runs(path):
        segment_run(run)


def _table(path: Path) -> None:
    from sstl_cli.reporting.load import load

    load([path])


def _theta(path: Path) -> None:
    from sstl_cli.core.parquet import open_table
    from sstl_cli.core.tables import THETA
    from sstl_cli.steps.compensate import cases_of

    cases_of(open_table(path, THETA).table())


def _reference(path: Path) -> None:
    from sstl_cli.control.reference_file import read

    read(path, 0.01)


def _scenario(path: Path) -> None:
    from sstl_cli.physics.plan import plan
    from sstl_cli.physics.scenario import load

    plan(load(str(path)), 0)


def _mapping(path: Path) -> None:
    from sstl_cli.importers.mapping import read_mapping

    read_mapping(path)


def _config(path: Path) -> None:
    # an unknown log ends the command once its options are read
    done = inside("segment", "/no/log", "--out", "/no/theta", "--config", path)
    assert done.returncode in (1, 2) and "E003" not in done.stderr and "Traceback" not in done.stderr, done.stderr
    if "/no:" not in done.stderr:
        raise SstlError("refused", code="E150")


def _controller(path: Path) -> None:
    from sstl_cli.control import parameters
    from sstl_cli.core.files import read_json

    document = parameters.read(read_json(path, parameters.SCHEMA), str(path))
    for entry in document.configurations:
        parameters.controller_of(entry, document.options)


def _diagnosis(path: Path) -> None:
    from sstl_cli.reporting.load import load
    from sstl_cli.steps.report import run

    run(load([path]))


def _model(path: Path) -> None:
    from sstl_cli.mapping import load_model

    load_model(path)


READERS: dict[str, tuple[str, Callable[[Path], None]]] = {
    "log": (".parquet", _log),
    "theta": (".parquet", _theta),
    "phases": (".parquet", _table),
    "reference": (".parquet", _reference),
    "scenario": (".toml", _scenario),
    "mapping": (".toml", _mapping),
    "config": (".toml", _config),
    "controller": (".json", _controller),
    "diagnosis": (".json", _diagnosis),
    "model": (".safetensors", _model),
}


@dataclass
class Answers:
    """How the inputs of one kind were answered."""

    read: int = 0
    refused: int = 0
    slowest_s: float = 0.0

    @property
    def inputs(self) -> int:
        return self.read + self.refused


@contextlib.contextmanager
def at_most(seconds: int, what: str) -> Iterator[None]:
    """Raise AssertionError in the middle of a hang."""

    def stop(*_: Any) -> None:
        raise AssertionError(f"{what} hangs")

    old = signal.signal(signal.SIGALRM, stop)
    signal.alarm(seconds)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, old)


def fuzz_one(kind: str, data: bytes, what: str) -> bool:
    """Return whether damaged bytes were read; anything but a value or an SstlError raises, and so does a hang."""
    suffix, read = READERS[kind]
    with tempfile.TemporaryDirectory() as folder, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        path = Path(folder) / f"fuzz{suffix}"
        path.write_bytes(data)
        try:
            with at_most(MAX_SECONDS, what):
                read(path)
        except SstlError as error:
            assert "\n" not in error.line() and len(error.line()) < 2000, what
            return False
        except Exception as error:
            raise AssertionError(f"{what}: {type(error).__name__}: {error}"[:300]) from error
    return True


def fuzz(kind: str, count: int, first: int = 0) -> Answers:
    """Read damaged files one after another."""
    answers = Answers()
    for number in range(first, first + count):
        data = mutated(kind, number)
        started = time.monotonic()
        read = fuzz_one(kind, data, f"{kind} input {number}")
        answers.read += read
        answers.refused += not read
        answers.slowest_s = max(answers.slowest_s, time.monotonic() - started)
    return answers
