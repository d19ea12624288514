"""The jobs of a batch on a Dask cluster: joblib's dask backend, watched so that a lost cluster ends the batch."""

from __future__ import annotations

import logging
import queue
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from sstl_cli import __version__
from sstl_cli.cli._batch_worker import Job, run_one
from sstl_cli.core.errors import SstlError
from sstl_cli.steps.batch import Outcome

CONNECT_S = 15
# a worker that is started again by its nanny is back well within this
LOST_S = 30
LOOK_S = 1.0


@contextmanager
def connected(scheduler: str) -> Iterator[Any]:
    """Yield a client of the scheduler whose workers run this version; SstlError where there is none."""
    try:
        from distributed import Client
    except ImportError:
        raise SstlError("needs the package distributed", where="--scheduler", fix="pip install 'sstl-cli[cluster]'", code="E041") from None
    # a connection that ends is told by our own line; the libraries would add the stack of whichever callback saw it first
    for name in list(logging.root.manager.loggerDict):
        if name.partition(".")[0] in ("distributed", "tornado", "asyncio"):
            logging.getLogger(name).setLevel(logging.CRITICAL + 1)
    try:
        client = Client(scheduler, timeout=CONNECT_S, set_as_default=False)
    except (OSError, ValueError, TimeoutError) as error:
        text = " ".join(str(error).split())[:120]
        raise SstlError(f"no scheduler answers ({text})", where=scheduler, fix="start one with 'dask scheduler'", code="E042") from None
    try:
        _check_workers(client, scheduler)
        yield client
    finally:
        client.close(timeout=5)


def spread(jobs: list[Job], client: Any, scheduler: str, ahead: int) -> Iterator[Outcome]:
    """Yield outcomes as the workers of the cluster finish jobs, ``ahead`` of which are handed out at once.

    Raises
    ------
    SstlError
        If the scheduler goes away, or is without workers for ``LOST_S``.
    """
    results: queue.SimpleQueue[Outcome | BaseException | None] = queue.SimpleQueue()
    # joblib waits without an end for a cluster that is gone: it waits in a thread, and this one looks after the cluster
    threading.Thread(target=_submit, args=(jobs, client, ahead, results), daemon=True).start()
    alive = time.monotonic()
    while True:
        try:
            result = results.get(timeout=LOOK_S)
        except queue.Empty:
            alive = _look(client, scheduler, alive)
            continue
        if result is None:
            return
        if isinstance(result, BaseException):
            raise result
        alive = time.monotonic()
        yield result


def _submit(jobs: list[Job], client: Any, ahead: int, results: queue.SimpleQueue[Any]) -> None:
    from joblib import Parallel, delayed, parallel_config

    try:
        with parallel_config(backend=_backend(client), n_jobs=-1):
            pool = Parallel(batch_size=1, pre_dispatch=ahead, return_as="generator_unordered")
            for outcome in pool(delayed(run_one)(job) for job in jobs):
                results.put(outcome)
        results.put(None)
    except BaseException as error:
        results.put(error)


def _backend(client: Any) -> Any:
    """Return joblib's dask backend without two of its traps."""
    from joblib._dask import DaskDistributedBackend

    class Backend(DaskDistributedBackend):  # type: ignore[misc]
        def effective_n_jobs(self, n_jobs: int) -> int:
            # with one, joblib would run the jobs here instead of on the one worker there is
            workers: int = super().effective_n_jobs(n_jobs)
            return max(2, workers)

        def submit(self, func: Any, callback: Any = None) -> Any:
            future = super().submit(func, callback)
            # the library tells of results only: a job whose workers all died would be waited for without an end
            future.add_done_callback(lambda done: callback(done.exception()) if done.exception() else None)
            return future

        def retrieve_result_callback(self, out: Any) -> Any:
            if isinstance(out, BaseException):
                raise out
            return super().retrieve_result_callback(out)

    return Backend(client=client, wait_for_workers_timeout=CONNECT_S)


def _look(client: Any, scheduler: str, alive: float) -> float:
    """Return when the cluster was last seen with a worker; SstlError when that is too long ago."""
    try:
        if client.status == "running" and client.nthreads(callback_timeout=5):
            return time.monotonic()
        gone = client.status in ("closing", "closed")
    except (OSError, TimeoutError):
        gone = False
    again = "start it again and repeat the command: what is complete is skipped"
    if gone:
        raise SstlError("the scheduler is gone", where=scheduler, fix=again, code="E042")
    if time.monotonic() - alive > LOST_S:
        raise SstlError("the scheduler or all its workers are gone", where=scheduler, fix=again, code="E043")
    return alive


def _check_workers(client: Any, scheduler: str) -> None:
    try:
        client.wait_for_workers(1, timeout=CONNECT_S)
    except TimeoutError:
        raise SstlError(
            "the scheduler has no workers", where=scheduler, fix=f"start one with 'dask worker {scheduler}'", code="E043"
        ) from None
    for address, version in client.run(worker_version, on_error="return").items():
        if version != __version__:
            shown = version if isinstance(version, str) else type(version).__name__
            raise SstlError(
                f"worker {address} has sstl {shown}, this is {__version__}",
                where=scheduler,
                fix="install the same version everywhere",
                code="E044",
            )


def worker_version() -> str:
    """Return the version of this program where it is called."""
    return __version__
