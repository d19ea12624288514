"""What holds for the whole suite."""

from __future__ import annotations

import gc
import os
import signal
import sys
from collections.abc import Iterator

import pytest
from hypothesis import HealthCheck, settings

# workers share the cores: threads of a linear algebra in each of them wait for one another, and a diagnosis takes several times
# as long; numpy and scipy ask for it when they are loaded, here and in the processes that tests start
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

# jsonschema would have it build grammars of addresses for seconds in each worker; no schema asks for that format
sys.modules.setdefault("rfc3987_syntax", None)  # type: ignore[arg-type]

# a shell that starts the suite in the background has its children ignore Ctrl-C, and nohup a terminal that closes: what some
# tests are about
for number, usual in ((signal.SIGINT, signal.default_int_handler), (signal.SIGHUP, signal.SIG_DFL)):
    if signal.getsignal(number) is signal.SIG_IGN:
        signal.signal(number, usual)


def pytest_collection_finish() -> None:
    """What is loaded by then stays to the end: the collector need not look through a million objects again and again."""
    gc.collect()
    gc.freeze()
    gc.set_threshold(50_000, 20, 50)


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Of a test marked ``each_once``, leave to the slow suite what asks a pair of values of which each is asked already."""
    from tests import soon

    soon.thin(items)


# how fast a busy machine draws inputs is no fault of what is tested
settings.register_profile("suite", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("suite")


@pytest.fixture(scope="session", autouse=True)
def measured_once() -> Iterator[None]:
    """The gate judges the same runs in many tests, and before every diagnosis: it measures them once."""
    from sstl_cli.identification import gate
    from tests import known_runs

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(gate, "evidence_of", known_runs.evidence_of)
        yield


# parts whose tests ask the same of the same recording, of the program and from Python, and change nothing of how it is found
DIAGNOSED_ONCE = ("api", "cli", "docs", "reporting")


@pytest.fixture(scope="module", autouse=True)
def diagnosed_once(request: pytest.FixtureRequest) -> Iterator[None]:
    """In some parts a diagnosis of the same runs is gathered once."""
    with pytest.MonkeyPatch.context() as patch:
        if request.path.parent.name in DIAGNOSED_ONCE:
            from sstl_cli.diagnosis import gathering
            from tests import known_diagnoses

            patch.setattr(gathering, "gather", known_diagnoses.gather)
        yield


@pytest.fixture(scope="session", autouse=True)
def declared() -> Iterator[None]:
    """A document that the program shows while a test runs it has no field that its schema does not name."""
    from sstl_cli.cli.render import Screen
    from tests import told

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Screen, "document", told.guarded(Screen.document))
        yield


@pytest.fixture(scope="session", autouse=True)
def drawn_once() -> Iterator[None]:
    """Many tests ask for a page of the same recording: its pictures are drawn once. Where no test has drawing loaded, nor does this."""
    drawing = sys.modules.get("sstl_cli.reporting.drawing")
    with pytest.MonkeyPatch.context() as patch:
        if drawing is not None:
            from tests import known_pictures

            patch.setattr(drawing, "picture", known_pictures.picture)
        yield
