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
from sstl_cli.core.workers import goes_on, is_interrupt

if TYPE_CHECKING:
    from sstl_cli.core.documents.base import Document
    from sstl_cli.steps.watch import Loop
    from sstl_cli.steps.watch_follow import Event, Following, Told

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
    from sstl_cli.cli.origin import refuse
    from sstl_cli.identification import SegmentOptions
    from sstl_cli.importers import mapping
    from sstl_cli.mapping.weights import load_model
    from sstl_cli.physics.scenario import load
    from sstl_cli.steps.watch import Watcher, WatchOptions
    from sstl_cli.steps.watch_follow import Following, FollowOptions
    from sstl_cli.steps.watch_sources import source_of

    how = FollowOptions(asked.diagnose, asked.once, asked.until_idle, asked.poll)
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
    following = Following(watcher, sources, how, scenario, screen.note)
    lines = _Lines(screen)
    screen.note(
        f"learning from {asked.learn} loops a stream, then at most one false alarm in {asked.false_alarms:g} loops"
        + ("" if asked.once or asked.until_idle else "; Ctrl-C ends")
    )
    try:
        for event in following.follow():
            lines.show(event)
    except (KeyboardInterrupt, SystemError) as error:
        if not is_interrupt(error):
            raise
        # the usual end of a watch, after which it sums up
        goes_on()
        screen.note("interrupted")
    _finish(following, lines, asked.fail_on_alarm, asked.logs)


class _Lines:
    """What is shown of a watch: a heading, loops, alarms."""

    def __init__(self, screen: Screen) -> None:
        self.screen = screen
        self._headed = False

    def show(self, event: Event) -> None:
        """Show a loop, an alarm as it is raised, or what a diagnosis makes of it."""
        from sstl_cli.steps.watch import Alarm, Loop

        if isinstance(event, Loop):
            self._loop(event)
        elif isinstance(event, Alarm):
            self.line(f"ALARM  {event.stream}: {event.why}")
        else:
            self._told(event)

    def _told(self, told: Told) -> None:
        naming, text = told.naming, ""
        if naming is not None:
            named = " + ".join(naming.effects) or naming.status
            group = f" (not told apart: {', '.join(naming.group)})" if len(naming.group) > 1 else ""
            text = f"likely {told.alarm.stream}: {named}{group}; {naming.why}"
        self.line(text, told.document())

    def _loop(self, event: Loop) -> None:
        """Show a loop, below a heading where it is the first."""
        import sys

        if not self._headed:
            self._headed = True
            if not self.screen.as_json:
                self.screen.note(show.heading(event.run.unit_out or "N"))
        for line in [""] if self.screen.as_json else show.loop(event, width_of(sys.stdout)):
            self.line(line, event.document())

    def line(self, text: str, document: Document | None = None) -> None:
        """Show a line at once: a watch may be read by another program as it goes."""
        import sys

        if self.screen.as_json:
            if document is not None:
                self.screen.document(document)
        elif text:
            self.screen.say(text)
        sys.stdout.flush()


def _finish(following: Following, lines: _Lines, fail_on_alarm: bool, names: list[str]) -> NoReturn:
    """Name what is still unnamed, sum up, and end with the exit code; ``names`` are the logs, as the call gave them."""
    from sstl_cli.steps.watch_follow import require_samples

    for told in following.rest():
        lines.show(told)
    seen, screen = following.summary(), lines.screen
    for reason, count in seen.set_aside.items():
        screen.note(f"set aside: {count} ({reason})")
    lines.line(show.summary(seen.loops, seen.samples, len(seen.alarms), seen.not_armed or {}, following.watcher.options.learn))
    missed = [f"{len(seen.alarms)} alarms"] if fail_on_alarm and seen.alarms else []
    if seen.samples == 0:
        screen.document(seen)
    require_samples(seen, names)
    screen.finish(seen, missed=missed, aside=bool(seen.set_aside))
