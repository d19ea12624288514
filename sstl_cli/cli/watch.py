"""``sstl watch``: follow growing logs, re-estimate Theta loop by loop, and say when something changes."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, NoReturn

import typer

from sstl_cli.cli import _watch_show as show
from sstl_cli.cli._gathered import gathered
from sstl_cli.cli.options import Config, Json, Seed
from sstl_cli.cli.render import Screen, width_of
from sstl_cli.core.workers import end_if_asked, goes_on, is_interrupt

if TYPE_CHECKING:
    from sstl_cli.cli._watch_sources import Source
    from sstl_cli.core.documents.base import Document
    from sstl_cli.core.documents.watch import AlarmDocument
    from sstl_cli.physics.scenario import Scenario
    from sstl_cli.steps.watch import Alarm, Loop, Watcher
    from sstl_cli.steps.watch_name import Naming

EPILOG = "Example: sstl watch rig.csv --model mapping.safetensors --until-idle 60 --fail-on-alarm"


def register(app: typer.Typer) -> None:
    """Add the subcommand."""
    app.command("watch", epilog=EPILOG)(watch)


@dataclass(frozen=True, kw_only=True)
class Asked:
    """What a call asks for."""

    logs: Annotated[list[str], typer.Argument(metavar="LOG", help="Growing text logs, folders of Parquet chunks, or 'glob*' patterns.")]
    model: Annotated[Path | None, typer.Option(help="Mapping of sstl train: its inputs are checked, act loops compared.")] = None
    sim: Annotated[str | None, typer.Option(help="Simulator (scenario TOML) that the loops are compared with.")] = None
    mapping: Annotated[Path | None, typer.Option(metavar="FILE.toml", help="Columns and units, as for sstl import.")] = None
    learn: Annotated[int, typer.Option(min=10, max=100, help="Loops that show what is usual.")] = 20
    false_alarms: Annotated[float, typer.Option(min=50, max=5000, help="Accept one false alarm in so many loops.")] = 500.0
    diagnose: Annotated[bool, typer.Option(help="Name the likely effect of a change.")] = True
    name_after: Annotated[int, typer.Option(min=2, max=8, help="Loops since a change before it is named.")] = 4
    once: Annotated[bool, typer.Option("--once", help="Take what is there, then end.")] = False
    until_idle: Annotated[float | None, typer.Option(min=0.1, help="End after so many seconds without new samples.")] = None
    poll: Annotated[float, typer.Option(min=0.01, max=3600, help="Seconds between two looks.")] = 0.5
    fail_on_alarm: Annotated[bool, typer.Option("--fail-on-alarm", help="Exit 4 if there was an alarm.")] = False
    seed: Seed = 0
    as_json: Json = False
    config: Config = None


@gathered
def watch(asked: Asked) -> None:
    """Follow growing logs: one line (with --json one JSON line) a loop, and alarms at a stated false-alarm rate."""
    from sstl_cli.cli._watch_sources import source_of
    from sstl_cli.cli.origin import refuse
    from sstl_cli.core.errors import UsageError
    from sstl_cli.identification import SegmentOptions
    from sstl_cli.importers import mapping
    from sstl_cli.mapping.weights import load_model
    from sstl_cli.physics.scenario import load
    from sstl_cli.steps.watch import Watcher, WatchOptions

    if asked.once and asked.until_idle is not None:
        raise UsageError("--once and --until-idle exclude one another", fix="give one", code="E250")
    if not asked.diagnose:
        refuse("--no-diagnose", ("--name-after",))
    if asked.once:
        refuse("--once", ("--poll",))
    screen = Screen(asked.as_json, lines=True)
    columns = mapping.read_mapping(asked.mapping) if asked.mapping is not None else mapping.Mapping()
    sources = [source_of(text, columns) for text in asked.logs]
    options = WatchOptions(asked.learn, asked.false_alarms, asked.name_after, SegmentOptions(seed=asked.seed))
    scenario = load(asked.sim) if asked.sim else None
    screen.note_versions(scenario and scenario.package_version, "the simulator")
    watcher = Watcher(options, load_model(asked.model) if asked.model is not None else None, scenario)
    session = _Session(screen, watcher, sources, scenario, asked.diagnose, asked.name_after)
    screen.note(
        f"learning from {asked.learn} loops a stream, then at most one false alarm in {asked.false_alarms:g} loops"
        + ("" if asked.once or asked.until_idle else "; Ctrl-C ends")
    )
    try:
        session.follow(asked.once, asked.until_idle, asked.poll)
    except (KeyboardInterrupt, SystemError) as error:
        if not is_interrupt(error):
            raise
        # the usual end of a watch, after which it sums up
        goes_on()
        screen.note("interrupted")
    session.finish(asked.fail_on_alarm, asked.logs)


class _Session:
    """The loop of looks, and what is shown of it."""

    def __init__(
        self, screen: Screen, watcher: Watcher, sources: list[Source], sim: Scenario | None, diagnose: bool, name_after: int
    ) -> None:
        self.screen, self.watcher, self.sources, self.sim = screen, watcher, sources, sim
        self.diagnose, self.name_after = diagnose, name_after
        self.alarms: list[AlarmDocument] = []
        self._unnamed: list[Alarm] = []
        self._noted = 0
        self._headed = False

    def follow(self, once: bool, until_idle: float | None, poll_s: float) -> None:
        """Look until there is nothing more to come."""
        import time

        quiet_since = time.monotonic()
        while True:
            if self._look(once):
                quiet_since = time.monotonic()
            if once:
                break
            end_if_asked()
            quiet = time.monotonic() - quiet_since
            if until_idle is not None and quiet >= until_idle:
                self._look(True)
                break
            time.sleep(poll_s if until_idle is None else min(poll_s, max(until_idle - quiet, 0.01)))
        for event in self.watcher.end():
            self._show(event)

    def _look(self, last: bool) -> bool:
        """Take what every source has; return whether there was anything."""
        found = False
        for source in self.sources:
            for piece in source.look(last):
                found = True
                for event in self.watcher.feed(piece):
                    self._show(event)
        notes = [n for s in self.sources for n in s.notes]
        for text in notes[self._noted :]:
            self.screen.note(text)
        self._noted = len(notes)
        return found

    def _show(self, event: Loop | Alarm) -> None:
        from sstl_cli.steps.watch import Alarm

        if isinstance(event, Alarm):
            self._unnamed.append(event)
            if event.kind == "range":
                self._raise(event, None)
            else:
                self._line(f"ALARM  {event.stream}: {event.why}")
        else:
            self._loop(event)
        waiting = [a for a in self._unnamed if a.kind == "change"]
        for alarm in waiting:
            if self.watcher.loops_since(alarm) >= self.name_after:
                self._name(alarm)

    def _name(self, alarm: Alarm) -> None:
        from sstl_cli.steps.watch import joined
        from sstl_cli.steps.watch_name import name_change

        naming = None
        if self.diagnose:
            before, since = self.watcher.around(alarm)
            naming = name_change(joined(before), joined(since), self.sim)
        self._raise(alarm, naming)

    def _raise(self, alarm: Alarm, naming: Naming | None) -> None:
        self._unnamed.remove(alarm)
        document = alarm.document(None if naming is None else naming.document())
        self.alarms.append(document)
        if alarm.kind == "range":
            self._line(f"ALARM  {alarm.stream}: {alarm.why}", document)
        elif naming is None:
            self._line("", document)
        else:
            named = " + ".join(naming.effects) or naming.status
            group = f" (not told apart: {', '.join(naming.group)})" if len(naming.group) > 1 else ""
            self._line(f"likely {alarm.stream}: {named}{group}; {naming.why}", document)

    def _loop(self, event: Loop) -> None:
        """Show a loop, below a heading where it is the first."""
        import sys

        if not self._headed:
            self._headed = True
            if not self.screen.as_json:
                self.screen.note(show.heading(event.run.unit_out or "N"))
        for line in [""] if self.screen.as_json else show.loop(event, width_of(sys.stdout)):
            self._line(line, event.document())

    def _line(self, text: str, document: Document | None = None) -> None:
        """Show a line at once: a watch may be read by another program as it goes."""
        import sys

        if self.screen.as_json and document is not None:
            self.screen.document(document)
        elif text:
            self.screen.say(text)
        sys.stdout.flush()

    def finish(self, fail_on_alarm: bool, names: list[str]) -> NoReturn:
        """Name what is still unnamed, sum up, and end with the exit code; ``names`` are the logs, as the call gave them."""
        from sstl_cli.core.documents.watch import WatchDocument
        from sstl_cli.core.errors import SstlError

        for alarm in [a for a in self._unnamed if a.kind == "change"]:
            self._name(alarm)
        aside: dict[str, int] = dict(self.watcher.intake.set_aside)
        for source in self.sources:
            for reason, count in source.set_aside.items():
                aside[reason] = aside.get(reason, 0) + count
        for reason, count in aside.items():
            self.screen.note(f"set aside: {count} ({reason})")
        loops, samples = self.watcher.loops, self.watcher.intake.samples
        learning = self.watcher.not_armed()
        self._line(show.summary(loops, samples, len(self.alarms), learning, self.watcher.options.learn))
        document = WatchDocument(
            schema="sstl.watch/1",
            loops=loops,
            samples=samples,
            breaks=self.watcher.intake.breaks,
            alarms=self.alarms,
            set_aside=aside,
            not_armed=learning,
            learn=self.watcher.options.learn,
        )
        missed = [f"{len(self.alarms)} alarms"] if fail_on_alarm and self.alarms else []
        if samples == 0:
            self.screen.document(document)
            fix = "is the name right, and are there whole lines?"
            raise SstlError("no sample was read", where=", ".join(names[:3]), fix=fix, code="E251")
        self.screen.finish(document, missed=missed, aside=bool(aside))
