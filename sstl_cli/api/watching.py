"""Recordings that grow, followed loop by loop."""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Sequence
from os import PathLike
from pathlib import Path

from sstl_cli.api.mapping import Mapping
from sstl_cli.core.documents.watch import AlarmDocument, LoopDocument, WatchDocument
from sstl_cli.identification import SegmentOptions
from sstl_cli.importers.mapping import Mapping as Columns
from sstl_cli.importers.mapping import read_mapping
from sstl_cli.physics.scenario import Scenario, load
from sstl_cli.steps.watch import Loop, Watcher, WatchOptions
from sstl_cli.steps.watch_follow import Event, Following, FollowOptions, Told, require_samples
from sstl_cli.steps.watch_sources import source_of

__all__ = ["AlarmDocument", "LoopDocument", "WatchDocument", "watch"]


# long: one parameter for each option of the command, each told; the body fits a screen
def watch(
    *logs: str | PathLike[str],
    model: Mapping | None = None,
    sim: str | PathLike[str] | Scenario | None = None,
    mapping: str | PathLike[str] | None = None,
    learn: int = 20,
    false_alarms: float = 500.0,
    diagnose: bool = True,
    name_after: int = 4,
    once: bool = False,
    until_idle: float | None = None,
    poll: float = 0.5,
    seed: int = 0,
) -> Iterator[LoopDocument | AlarmDocument | WatchDocument]:
    """Return the loops of growing logs as they end, each alarm once it is named, and what was seen in all, as ``sstl watch`` tells it.

    Without ``once`` and ``until_idle`` it goes on for ever: leave the loop that asks for the next. Sources that speak warn.

    Parameters
    ----------
    logs : str or path
        Growing text logs, folders of Parquet chunks, or patterns.
    model : Mapping, optional
        Its inputs are checked, loops of the actuation tendon compared with it.
    sim : str, path or Scenario, optional
        Simulator that the loops are compared with.
    mapping : str or path, optional
        A mapping file (TOML) with columns and units.
    learn : int
        Loops that show what is usual, 10 to 100.
    false_alarms : float
        Accept one false alarm in so many loops, 50 to 5000.
    diagnose : bool
        Name the likely effect of a change.
    name_after : int
        Loops since a change before it is named, 2 to 8.
    once : bool
        Take what is there, then end.
    until_idle, poll : float
        End after so many seconds without new samples (never by default); seconds between two looks.
    seed : int
        Seed of the sampler.

    Raises
    ------
    SstlError
        If a file cannot be followed, or no sample was read when the watch ends.

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> from sstl_cli.api.log import simulate
    >>> with TemporaryDirectory() as folder:
    ...     simulate("two-tendons", seed=1).write(Path(folder, "log.parquet"))
    ...     seen = list(watch(Path(folder, "log.parquet"), once=True))
    >>> seen[0].system, round(seen[0].gamma_p, 2), seen[-1].samples
    ('act', 0.61, 48000)
    """
    columns = Columns() if mapping is None else read_mapping(Path(mapping))
    scenario = load(str(sim)) if sim is not None and not isinstance(sim, Scenario) else sim
    watcher = Watcher(
        WatchOptions(learn, false_alarms, name_after, SegmentOptions(seed=seed)), None if model is None else model.model, scenario
    )
    names = [str(p) for p in logs]
    following = Following(
        watcher,
        [source_of(name, columns) for name in names],
        FollowOptions(diagnose, once, until_idle, poll),
        scenario,
        lambda text: warnings.warn(text, stacklevel=2),
    )
    return _documents(following, names)


def _documents(following: Following, names: Sequence[str]) -> Iterator[LoopDocument | AlarmDocument | WatchDocument]:
    """Yield what a watch tells, as documents."""

    def told(events: Iterator[Event] | Iterator[Told]) -> Iterator[LoopDocument | AlarmDocument]:
        for event in events:
            # what is raised is told again once it is named
            if isinstance(event, Loop | Told):
                yield event.document()

    yield from told(following.follow())
    yield from told(following.rest())
    seen = following.summary()
    require_samples(seen, names)
    yield seen
