"""Follow recordings that grow until there is nothing more to come: loops, alarms, and what a diagnosis makes of a change."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

from sstl_cli.core.documents.watch import AlarmDocument, WatchDocument
from sstl_cli.core.errors import SstlError, UsageError
from sstl_cli.core.workers import end_if_asked
from sstl_cli.physics.scenario import Scenario
from sstl_cli.steps.watch import Alarm, Loop, Watcher, joined
from sstl_cli.steps.watch_name import Naming, name_change
from sstl_cli.steps.watch_sources import Source


@dataclass(frozen=True)
class FollowOptions:
    """Whether changes are named, when a watch ends (``until_idle`` in s), and the time between two looks (s)."""

    diagnose: bool = True
    once: bool = False
    until_idle: float | None = None
    poll_s: float = 0.5

    def __post_init__(self) -> None:
        if self.once and self.until_idle is not None:
            raise UsageError("once and until-idle exclude one another", fix="give one", code="E250")


@dataclass(frozen=True)
class Told:
    """An alarm of which all is known, with what a diagnosis makes of the change (None where it was not asked)."""

    alarm: Alarm
    naming: Naming | None

    def document(self) -> AlarmDocument:
        """Return the alarm as one JSON line."""
        return self.alarm.document(None if self.naming is None else self.naming.document())


Event = Loop | Alarm | Told


class Following:
    """The loop of looks, and what came of it.

    Parameters
    ----------
    watcher : Watcher
        What loops and alarms are found by.
    sources : sequence of Source
        Where samples come from.
    options : FollowOptions
        Naming, end and looks.
    sim : Scenario, optional
        The simulator that a change is compared with.
    note : callable
        Called with what sources say on the way, as it comes.
    """

    def __init__(
        self,
        watcher: Watcher,
        sources: Sequence[Source],
        options: FollowOptions,
        sim: Scenario | None = None,
        note: Callable[[str], None] = lambda _: None,
    ) -> None:
        self.watcher, self.sources, self.options, self.sim, self.note = watcher, sources, options, sim, note
        self.alarms: list[AlarmDocument] = []
        self._unnamed: list[Alarm] = []
        self._noted = 0
        self._found = False

    def follow(self) -> Iterator[Event]:
        """Look until there is nothing more to come, and yield every loop, every alarm as it is raised, and again once it is named."""
        once, until_idle, poll_s = self.options.once, self.options.until_idle, self.options.poll_s
        quiet_since = time.monotonic()
        while True:
            yield from self._look(once)
            if self._found:
                quiet_since = time.monotonic()
            if once:
                break
            end_if_asked()
            quiet = time.monotonic() - quiet_since
            if until_idle is not None and quiet >= until_idle:
                yield from self._look(True)
                break
            time.sleep(poll_s if until_idle is None else min(poll_s, max(until_idle - quiet, 0.01)))
        for event in self.watcher.end():
            yield from self._one(event)

    def rest(self) -> Iterator[Told]:
        """Name the changes that are not named yet: no more loops will come."""
        for alarm in list(self._unnamed):
            yield self._told(alarm)

    def summary(self) -> WatchDocument:
        """Return what was seen so far."""
        aside: dict[str, int] = dict(self.watcher.intake.set_aside)
        for source in self.sources:
            for reason, count in source.set_aside.items():
                aside[reason] = aside.get(reason, 0) + count
        return WatchDocument(
            schema="sstl.watch/1",
            loops=self.watcher.loops,
            samples=self.watcher.intake.samples,
            breaks=self.watcher.intake.breaks,
            alarms=self.alarms,
            set_aside=aside,
            not_armed=self.watcher.not_armed(),
            learn=self.watcher.options.learn,
        )

    def _look(self, last: bool) -> Iterator[Event]:
        """Take what every source has, and remember whether there was anything."""
        self._found = False
        for source in self.sources:
            for piece in source.look(last):
                self._found = True
                for event in self.watcher.feed(piece):
                    yield from self._one(event)
        notes = [n for s in self.sources for n in s.notes]
        for text in notes[self._noted :]:
            self.note(text)
        self._noted = len(notes)

    def _one(self, event: Loop | Alarm) -> Iterator[Event]:
        """Yield an event, and the changes since which there are loops enough now."""
        # whoever takes the events may be interrupted at any of them
        self._unnamed += [event] if isinstance(event, Alarm) else []
        yield event
        if isinstance(event, Alarm) and event.kind == "range":
            yield self._told(event)
        for alarm in list(self._unnamed):
            if self.watcher.loops_since(alarm) >= self.watcher.options.name_after:
                yield self._told(alarm)

    def _told(self, alarm: Alarm) -> Told:
        naming = None
        if self.options.diagnose and alarm.kind == "change":
            before, since = self.watcher.around(alarm)
            naming = name_change(joined(before), joined(since), self.sim)
        told = Told(alarm, naming)
        self._unnamed.remove(alarm)
        self.alarms.append(told.document())
        return told


def require_samples(seen: WatchDocument, names: Sequence[str]) -> None:
    """Raise where a watch read nothing; ``names`` are the logs, as the call gave them."""
    if seen.samples == 0:
        fix = "is the name right, and are there whole lines?"
        raise SstlError("no sample was read", where=", ".join(names[:3]), fix=fix, code="E251")
