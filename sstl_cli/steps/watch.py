"""Watch recordings that grow: Theta of every completed loop, the gap to the model, and alarms when it changes.

The same samples give the same loops and alarms however they arrive.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from sstl_cli.core.documents.watch import AlarmDocument, LoopDocument, NamedChange
from sstl_cli.core.errors import SstlError, UsageError
from sstl_cli.core.runs import Run
from sstl_cli.core.tables import PARAMETERS
from sstl_cli.identification import Segmentation, SegmentOptions, segment_run
from sstl_cli.identification.change import Change, Chart
from sstl_cli.identification.intake import Intake, Pieces
from sstl_cli.mapping.inference import OUTSIDE, MappingModel
from sstl_cli.physics.claims import Reference, gap_n, lines_of, of_simulator
from sstl_cli.physics.scenario import Scenario

Array = NDArray[np.float64]
COMPONENTS = ("ln gamma_p", "ln gamma_r", "pull level", "release level", "ln gap")
# the gap only matters where it grows; Theta may move either way
SIDES = (0, 0, 0, 0, 1)
# no spread from loop to loop is taken to be smaller: slopes and gap as shares, levels in N
LEAST_SPREAD = np.array([1e-3, 1e-3, 2e-3, 2e-3, 1e-2])
# loops of each stream that go into a diagnosis, before the change and since
KEPT = 8
# the limits of the charts are known for these; no more loops than are kept can be waited for
RANGES = {"learn": (10, 100), "false_alarms": (50, 5000), "name_after": (2, KEPT)}


@dataclass(frozen=True)
class WatchOptions:
    """Loops to learn from, loops per false alarm, loops after a change before it is named, and segmentation."""

    learn: int = 20
    false_alarms: float = 500.0
    name_after: int = 4
    segment: SegmentOptions = field(default_factory=SegmentOptions)

    def __post_init__(self) -> None:
        for name, (low, high) in RANGES.items():
            if not low <= getattr(self, name) <= high:
                raise UsageError(f"{name} is {getattr(self, name)}, not {low} to {high}", fix="give a number in that range", code="E252")


@dataclass(frozen=True)
class Loop:
    """One completed loop: its samples, Theta, the gap (N, RMSE) and where the charts stand (share of the limit)."""

    number: int
    run: Run
    segmentation: Segmentation
    against: str
    gap_n: float | None
    mapped: tuple[float, float] | None
    range: str | None
    learning: bool
    level: float
    position: int

    def document(self) -> LoopDocument:
        """Return the loop as one JSON line."""
        run, theta, se = self.run, self.segmentation.theta, self.segmentation.theta_se
        return LoopDocument(
            schema="sstl.watch.loop/1",
            loop=self.number,
            run_id=run.run_id,
            config_id=run.config_id,
            system=run.system,
            tendon=run.tendon,
            start_s=float(run.time_s[0]),
            end_s=float(run.time_s[-1]),
            gamma_p=theta["gamma_p"],
            beta_p=theta["beta_p"],
            gamma_r=theta["gamma_r"],
            beta_r=theta["beta_r"],
            gamma_p_se=se["gamma_p"],
            beta_p_se=se["beta_p"],
            gamma_r_se=se["gamma_r"],
            beta_r_se=se["beta_r"],
            status=self.segmentation.status,
            mapped=None if self.mapped is None else {"gamma_p": self.mapped[0], "gamma_r": self.mapped[1]},
            range=self.range,
            gap_n=self.gap_n,
            gap_against=self.against,
            learning=self.learning,
            chart=self.level,
        )


@dataclass(frozen=True)
class Alarm:
    """Something to act on: inputs outside the trained range (``range``) or a change of Theta or gap (``change``).

    ``began`` is the number of the loop with which the change began, as far as the charts tell.
    """

    kind: str
    loop: int
    began: int
    stream: str
    config_id: str | None
    why: str
    mean: float | None = None
    value: float | None = None

    def document(self, likely: NamedChange | None = None) -> AlarmDocument:
        """Return the alarm as one JSON line, with what a diagnosis makes of it."""
        return AlarmDocument(
            schema="sstl.watch.alarm/1",
            kind=self.kind,
            loop=self.loop,
            began_with_loop=self.began,
            stream=self.stream,
            config_id=self.config_id,
            why=self.why,
            before=self.mean,
            now=self.value,
            likely=likely,
        )


class _Stream:
    """What is known of the loops of one system, configuration and tendon."""

    def __init__(self, name: str, options: WatchOptions) -> None:
        self.name, self.options = name, options
        self.reference: Reference | None = None
        self.centre = math.nan
        self.outside = False
        self.restart()

    def restart(self) -> None:
        """Learn anew."""
        self.chart = Chart(SIDES, self.options.learn, self.options.false_alarms)
        self.numbers: list[int] = []
        self.reference = None


class Watcher:
    """Takes pieces of runs as they come and gives loops and alarms.

    Parameters
    ----------
    options : WatchOptions
        Learning, false alarms and segmentation.
    model : MappingModel, optional
        Maps the sensing loop to the actuation tendons.
    sim : Scenario, optional
        Simulator whose prediction the gap is measured against.
    """

    def __init__(self, options: WatchOptions, model: MappingModel | None = None, sim: Scenario | None = None) -> None:
        self.options, self.model, self.sim = options, model, sim
        self.loops = 0
        self.kept: list[Loop] = []
        self.intake = Intake()
        self._streams: dict[str, _Stream] = {}
        self._sstl: dict[str | None, tuple[float, float]] = {}

    def not_armed(self) -> dict[str, int]:
        """Return the loops learned so far by every stream that cannot raise an alarm yet."""
        return {name: s.chart.learned for name, s in self._streams.items() if s.chart.learning}

    def feed(self, piece: Run) -> Iterator[Loop | Alarm]:
        """Take the next samples of a run (in order) and yield the loops they complete, each followed by its alarms."""
        for whole in self.intake.add(piece):
            yield from self._loop(whole)

    def end(self) -> Iterator[Loop | Alarm]:
        """Yield the loops that end with the recording."""
        for whole in self.intake.end():
            yield from self._loop(whole)

    def _loop(self, whole: Pieces) -> Iterator[Loop | Alarm]:
        run = whole.run
        found = segment_run(run, self.options.segment)
        name = stream_name(run)
        stream = self._streams.setdefault(name, _Stream(name, self.options))
        self.loops += 1
        mapped, where = self._mapped(run, found)
        gap, against = self._gap(stream, run, found)
        change = stream.chart.add(*self._observation(stream, run, found, gap))
        stream.numbers.append(self.loops)
        loop = Loop(self.loops, run, found, against, gap, mapped, where, stream.chart.learning, stream.chart.level, whole.position)
        self._keep(loop)
        yield loop
        if where == OUTSIDE and not stream.outside:
            slopes = f"Gamma_p {found.theta['gamma_p']:.4g}, Gamma_r {found.theta['gamma_r']:.4g}"
            why = f"the mapping's inputs ({slopes}) lie outside its trained range: it extrapolates"
            yield Alarm("range", loop.number, loop.number, name, run.config_id, why)
        if where is not None:
            stream.outside = where == OUTSIDE
        if change is not None:
            yield self._alarm(stream, loop, change)
            stream.restart()

    def _mapped(self, run: Run, found: Segmentation) -> tuple[tuple[float, float] | None, str | None]:
        """Return what the mapping makes of a sensing loop, and where its input lies."""
        gp, gr = found.theta["gamma_p"], found.theta["gamma_r"]
        if run.system != "sstl" or gp is None or gr is None:
            return None, None
        self._sstl[run.config_id] = (gp, gr)
        if self.model is None:
            return None, None
        x = np.array([[gp, gr]])
        se = np.array([[found.theta_se["gamma_p"] or 0.0, found.theta_se["gamma_r"] or 0.0]])
        names = self.model.header.tendons
        predicted = self.model.predict(x, names[0] if names else None)[0]
        return (float(predicted[0]), float(predicted[1])), self.model.place(x, se)

    def _gap(self, stream: _Stream, run: Run, found: Segmentation) -> tuple[float | None, str]:
        """Return the RMSE (N) of the output against what is claimed of it, and by whom."""
        if self.sim is not None:
            if stream.reference is None:
                stream.reference = of_simulator(self.sim, run, found.theta["gamma_p"], found.theta["gamma_r"])
            return gap_n(stream.reference, run), "simulator"
        if run.system == "act" and self.model is not None:
            slopes, known = self._sstl.get(run.config_id), self.model.header.tendons
            if slopes is None or (known and run.tendon not in known):
                return None, "mapping"
            predicted = self.model.predict(np.array([slopes]), run.tendon if known else None)[0]
            beta_p, beta_r = self._biases(run.tendon if known else None)
            return gap_n(lines_of(float(predicted[0]), beta_p, float(predicted[1]), beta_r), run), "mapping"
        if stream.reference is None:
            if any(found.theta[p] is None for p in PARAMETERS):
                return None, "first loop"
            stream.reference = lines_of(*(float(found.theta[p] or 0.0) for p in PARAMETERS))
        return gap_n(stream.reference, run), "first loop"

    def _biases(self, tendon: str | None) -> tuple[float, float]:
        """Return the mapping's biases (N), none where it was trained without."""
        assert self.model is not None
        try:
            return self.model.beta_act_of(tendon)
        except SstlError:
            return 0.0, 0.0

    def _observation(self, stream: _Stream, run: Run, found: Segmentation, gap: float | None) -> tuple[Array, Array]:
        """Return the components of the charts and their standard errors.

        Slopes and the levels (N) of both lines at the middle of the tension: bias and slope go together, a level does not.
        """
        if math.isnan(stream.centre):
            stream.centre = 0.5 * float(run.tension_in_n.min() + run.tension_in_n.max())
        values, errors = np.full(5, np.nan), LEAST_SPREAD.copy()
        for k, s in enumerate("pr"):
            gamma, beta = found.theta[f"gamma_{s}"], found.theta[f"beta_{s}"]
            if gamma is None or beta is None:
                continue
            se = found.theta_se[f"gamma_{s}"] or 0.0
            values[k], errors[k] = math.log(gamma), max(se / gamma, errors[k])
            values[2 + k] = gamma * stream.centre + beta
        if gap is not None and gap > 0.0:
            values[4] = math.log(gap)
        return values, errors

    def _alarm(self, stream: _Stream, loop: Loop, change: Change) -> Alarm:
        began = stream.numbers[min(change.began, len(stream.numbers) - 1)]
        name = COMPONENTS[change.component]
        mean = stream.chart.mean(change.component)
        values = self._observation(stream, loop.run, loop.segmentation, loop.gap_n)[0]
        before, now = mean, float(values[change.component])
        if name.startswith("ln ") and before is not None:
            name, before, now = name[3:], math.exp(before), math.exp(now)
        way = "grows" if change.direction > 0 else "falls"
        unit = "" if name.startswith("gamma") else " N"
        shown = "" if before is None else f" from {before:.4g} to {now:.4g}{unit}"
        why = f"{name} {way}{shown} since loop {began}"
        return Alarm("change", loop.number, began, stream.name, loop.run.config_id, why, before, now)

    def _keep(self, loop: Loop) -> None:
        """Keep the last loops of every stream for a diagnosis."""
        self.kept.append(loop)
        mine = [k for k in self.kept if stream_name(k.run) == stream_name(loop.run)]
        if len(mine) > 3 * KEPT:
            self.kept.remove(mine[0])

    def around(self, alarm: Alarm) -> tuple[list[Loop], list[Loop]]:
        """Return the loops of the alarm's configuration before the change and since, at most ``KEPT`` a stream.

        Of several tendons only one is taken: each has a friction of its own.
        """
        tendon = self._tendon(alarm)
        mine = [k for k in self.kept if k.run.config_id == alarm.config_id and (k.run.system == "sstl" or k.run.tendon == tendon)]
        before, since = ([k for k in mine if k.number < alarm.began], [k for k in mine if k.number >= alarm.began])
        # the loop in which something changed is neither
        whole = [k for k in since if k.number > alarm.began] if self.loops_since(alarm) > 2 else since
        return _last_of_each(before, KEPT), _last_of_each(whole, KEPT)

    def _tendon(self, alarm: Alarm) -> str | None:
        """Return the tendon whose loops go with an alarm: its own, or the one last seen beside a sensing loop."""
        act = [k for k in self.kept if k.run.config_id == alarm.config_id and k.run.system == "act"]
        own = [k for k in act if stream_name(k.run) == alarm.stream]
        return (own or act)[-1].run.tendon if act else None

    def loops_since(self, alarm: Alarm) -> int:
        """Return how many loops of the alarm's own stream there are since the change began."""
        return sum(1 for k in self.kept if k.number >= alarm.began and stream_name(k.run) == alarm.stream)


def stream_name(run: Run) -> str:
    """Return the name of the stream that a run belongs to: system, tendon and configuration."""
    return " ".join([run.system, *([run.tendon] if run.tendon else []), *([run.config_id] if run.config_id else [])])


def _last_of_each(loops: list[Loop], count: int) -> list[Loop]:
    names = {stream_name(k.run) for k in loops}
    kept = [k for n in sorted(names) for k in [m for m in loops if stream_name(m.run) == n][-count:]]
    return sorted(kept, key=lambda k: k.number)


def joined(loops: list[Loop]) -> list[Run]:
    """Return loops as runs: those that follow one another without a gap become one."""
    groups: list[list[Loop]] = []
    for loop in sorted(loops, key=lambda k: (stream_name(k.run), k.number)):
        last = groups[-1][-1] if groups else None
        if last is not None and last.run.run_id == loop.run.run_id and loop.position == last.position + len(last.run) - 1:
            groups[-1].append(loop)
        else:
            groups.append([loop])
    runs = []
    for group in groups:
        first = group[0].run
        # neighbours share the sample of the turn between them
        parts = [first, *(g.run.cut(slice(1, None)) for g in group[1:])]
        runs.append(
            replace(
                first,
                run_id=f"{first.run_id}, loop {group[0].number} on",
                time_s=np.concatenate([p.time_s for p in parts]),
                tension_in_n=np.concatenate([p.tension_in_n for p in parts]),
                tension_out_n=np.concatenate([p.tension_out_n for p in parts]),
                position_in_mm=_in_one([p.position_in_mm for p in parts]),
                tension_ref_n=_in_one([p.tension_ref_n for p in parts]),
            )
        )
    return runs


def _in_one(parts: list[Array | None]) -> Array | None:
    there = [p for p in parts if p is not None]
    return np.concatenate(there) if len(there) == len(parts) else None
