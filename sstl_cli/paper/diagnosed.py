"""The gap of the paper, diagnosed: what a simulator of its tables lacks against the rig, found by ``sstl diagnose``.

The hardware is the rig of block R. The simulator is the fast model. Calibration bends are recorded, the diagnosis names
what is missing, it is added as found, and then bends that the diagnosis has not seen are predicted, the mapping is
trained anew on the simulator's recordings, and Table IV is promised by the simulator and tracked on the rig. Where no
name is given for sure, the most probable candidate is added on trial, and said to be that. No list of effects is given:
the candidates are the whole catalogue.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from sstl_cli.control.scoring import WINDOW_STEADY
from sstl_cli.core.errors import SstlError
from sstl_cli.core.processes import processes
from sstl_cli.core.rng import stream
from sstl_cli.core.runs import Run
from sstl_cli.diagnosis import accepted
from sstl_cli.diagnosis.verdict import AMBIGUOUS, IDENTIFIED
from sstl_cli.paper import block_r
from sstl_cli.paper.bench import Bench, Cogging, ModelBench, RigBench
from sstl_cli.paper.rig import GAP, TABLE_II, bends, trapezoid
from sstl_cli.paper.scores import distance, tracking_entries
from sstl_cli.paper.settings import METHODS
from sstl_cli.physics.scenario import Scenario
from sstl_cli.steps import diagnose

Key = tuple[str, str, str]
#: entries of Table IV
Table = Mapping[Key, float]
DIAGNOSED_BENDS = WITHHELD_BENDS = 2
#: the simulator is diagnosed again until nothing more is named, at most so often
ROUNDS = 2
MAX_EFFECTS = 3
#: the probability that nothing is missing from which nothing is put in on trial
HALF = 0.5
UNNAMED = "one without a name"
#: too few bends could be identified, or the mapped lines cross
UNLEARNED = ("E802", "E402")


@dataclass(frozen=True)
class Closed:
    """One gap before and after the diagnosis.

    ``missing`` is what the simulator lacked; ``withheld_n`` the RMSE (N) on bends that the diagnosis has not seen;
    ``promised_n`` how far Table IV as the simulator promises it lies from Table IV on the rig (root mean square over
    every RMSE and STD, N); ``tracked_n`` the RMSE (N) on the rig with the mapping trained in the simulator, mean over
    locations and references. Each is a pair: before, after (None where no mapping can be learned in that simulator).
    ``tried`` is the most probable candidate where none is named for sure: then "after" is with that.
    """

    missing: tuple[str, ...]
    status: str
    named: tuple[str, ...]
    confidence: float | None
    sentence: str
    withheld_n: tuple[float, float]
    promised_n: tuple[float | None, float | None]
    tracked_n: tuple[float | None, float | None]
    tried: tuple[str, ...] = ()

    @property
    def right(self) -> bool:
        """Whether everything named was missing, and something was named exactly where the catalogue has a name."""
        if self.missing == (UNNAMED,):
            return not self.named and self.status != AMBIGUOUS
        return bool(self.named) and set(self.named) <= set(self.missing)


@dataclass(frozen=True)
class _Hardware:
    """The rig with its recordings for the diagnosis and for the judgement, and its own Table IV if one can be learned.

    ``table`` is asked last: other processes may still be at it.
    """

    bench: RigBench
    recorded: list[Run]
    withheld: list[Run]
    table: Callable[[], Table | None]


@dataclass(frozen=True)
class _Known:
    """A Table IV that is at hand, for another process too."""

    table: Table | None

    def __call__(self) -> Table | None:
        return self.table


@dataclass(frozen=True)
class _Judged:
    """A simulator against a rig: RMSE on withheld bends, Table IV as it promises it, RMSE tracked on the rig (N)."""

    withheld_n: float
    promised: Table | None
    tracked_n: float | None

    def distance_n(self, table: Table | None) -> float | None:
        """Return how far the promised Table IV lies from a rig's; None where there is none of either."""
        return None if self.promised is None or table is None else distance(self.promised, table)


@dataclass(frozen=True)
class _Question:
    """A simulator that lacks something of a rig, and how often it may be completed."""

    missing: tuple[str, ...]
    simulator: Scenario
    rig: _Hardware | RigBench
    seed: int
    rounds: int = 1

    @property
    def title(self) -> str:
        return f"a simulator without {' and '.join(self.missing)}: diagnosed, with what is found put in, and Table IV before and after"


def run(
    seed: int,
    gap: bool = True,
    withheld: bool = False,
    table: Callable[[], Table | None] | None = None,
    workers: int = 1,
    say: Callable[[str], None] = lambda _: None,
) -> list[Closed]:
    """Return the gap of the paper, and each effect of the rig withheld from a simulator in turn.

    Parameters
    ----------
    gap : bool
        The gap of the paper: the simulator has Table II's effects.
    withheld : bool
        Simulators that have all of the rig's effects but one, each in turn, then one without a name on the rig.
    table : callable, optional
        Gives Table IV of the rig for this seed, where block R is computed; it is asked for late.
    workers : int
        Processes: of the diagnosis where there is one, else of several simulators at once.
    """
    say("the rig for the diagnosis: recordings")
    rig = _hardware(RigBench(), seed, table)
    if withheld:
        # several simulators are set against it
        rig = replace(rig, table=_Known(rig.table()))
    asked = []
    if gap:
        asked.append(_Question(tuple(e for e in GAP if e not in TABLE_II), Scenario(effects=TABLE_II), rig, seed, ROUNDS))
    if withheld:
        for effect in GAP:
            asked.append(_Question((effect,), Scenario(effects={k: v for k, v in GAP.items() if k != effect}), rig, seed))
        asked.append(_Question((UNNAMED,), Scenario(effects=GAP), RigBench(unnamed=Cogging()), seed))
    if workers < 2 or len(asked) < 2:
        return [_told(_answered(q, workers, say), say) for q in asked]
    with processes(min(workers, len(asked))) as pool:
        done = []
        for q, job in [(q, pool.submit(_answered, q)) for q in asked]:
            say(q.title)
            done.append(_told(job.result(), say))
    return done


def _told(found: Closed, say: Callable[[str], None]) -> Closed:
    """Say at once what one simulator gave: of a run of many minutes that is stopped, what is done is then known."""
    pairs = (("withheld", found.withheld_n), ("promised", found.promised_n), ("tracked", found.tracked_n))
    numbers = ", ".join(f"{name} {' -> '.join('-' if v is None else f'{v:.3f}' for v in pair)} N" for name, pair in pairs)
    trial = f", {' + '.join(found.tried)} put in on trial" if found.tried else ""
    say(f"without {' and '.join(found.missing)}: {' + '.join(found.named) or found.status}{trial}; {numbers}")
    return found


def _answered(q: _Question, workers: int = 1, say: Callable[[str], None] = lambda _: None) -> Closed:
    """Return what the diagnosis of one simulator finds, and how far the gap shrinks with it."""
    say(q.title)
    rig = q.rig if isinstance(q.rig, _Hardware) else _hardware(q.rig, q.seed, None)
    again, found = completed(q.simulator, rig.recorded, workers, q.rounds)
    again, on_trial = _on_trial(again, found)
    return _closed(q.missing, (q.simulator, again), found, on_trial, rig, q.seed)


def _on_trial(scenario: Scenario, found: diagnose.Diagnosis) -> tuple[Scenario, tuple[str, ...]]:
    """Return the simulator, where nothing is named for sure with the most probable candidate put in, and which that is."""
    put_in = () if _named(found) else tuple(found.body.verdict.effects) or likeliest(found)
    if not put_in:
        return scenario, ()
    return _bare(accepted.model(found.evidence, replace(found.verdict, effects=put_in), found.given)), put_in


def _named(found: diagnose.Diagnosis) -> tuple[str, ...]:
    """Return the effects that a diagnosis commits to: what an ambiguous one puts first is not named."""
    verdict = found.body.verdict
    return tuple(verdict.effects) if verdict.status == IDENTIFIED else ()


def likeliest(found: diagnose.Diagnosis) -> tuple[str, ...]:
    """Return the most probable candidate that is fitted to the output, named or not; nothing where no gap is likelier."""
    odds, fits = found.verdict.probabilities, found.evidence.search
    fitted = [ids for ids in odds if ids in fits.combined or (len(ids) == 1 and ids[0] in fits.singles)]
    best = max(fitted, key=lambda ids: odds[ids], default=())
    return best if best and odds.get((), 0.0) < HALF else ()


def _hardware(bench: RigBench, seed: int, table: Callable[[], Table | None] | None) -> _Hardware:
    first, later = (
        [
            bench.record(b, system, *trapezoid(system), seed)
            for b in bends(count, stream(seed, "diagnosis", name))
            for system in ("act", "sstl")
        ]
        for count, name in ((DIAGNOSED_BENDS, "known"), (WITHHELD_BENDS, "withheld"))
    )
    return _Hardware(bench, first, later, table or partial(_own_table, bench, seed))


def _own_table(bench: RigBench, seed: int) -> Table | None:
    """Return Table IV of a rig, None where too many of its bends show no lines to learn from (as a ripple can make them)."""
    try:
        return _table(block_r.learn(seed, bench), bench, seed)
    except SstlError as error:
        if error.code not in UNLEARNED:
            raise
        return None


def completed(scenario: Scenario, recorded: Sequence[Run], workers: int, rounds: int = ROUNDS) -> tuple[Scenario, diagnose.Diagnosis]:
    """Return the simulator with every effect that a diagnosis after the other names, and the first diagnosis."""
    options = diagnose.DiagnoseOptions(max_effects=MAX_EFFECTS, workers=workers)
    first: diagnose.Diagnosis | None = None
    for _ in range(rounds):
        found = diagnose.run(recorded, replace(options, sim=scenario))
        first = first or found
        if not _named(found):
            break
        scenario = _bare(found.model())
    assert first is not None
    return scenario, first


def _bare(scenario: Scenario) -> Scenario:
    """Return the scenario without the bends it was fitted to."""
    return scenario.model_copy(update={"configurations": (), "generator": None})


def _closed(
    missing: tuple[str, ...],
    simulators: tuple[Scenario, Scenario],
    found: diagnose.Diagnosis,
    on_trial: tuple[str, ...],
    rig: _Hardware,
    seed: int,
) -> Closed:
    verdict, (before, after) = found.body.verdict, simulators
    first = _judged(ModelBench(before), rig, seed)
    later = first if after is before else _judged(ModelBench(after), rig, seed)
    table = rig.table()
    return Closed(
        missing,
        verdict.status,
        _named(found),
        verdict.confidence,
        found.body.sentence or verdict.why,
        (first.withheld_n, later.withheld_n),
        (first.distance_n(table), later.distance_n(table)),
        (first.tracked_n, later.tracked_n),
        on_trial,
    )


def _judged(model: ModelBench, rig: _Hardware, seed: int) -> _Judged:
    """Return what a simulator predicts of withheld bends, promises of Table IV, and tracks on the rig."""
    withheld = float(np.sqrt(np.mean([model.rmse(r) ** 2 for r in rig.withheld])))
    try:
        learned = block_r.learn(seed, model)
        return _Judged(withheld, _table(learned, model, seed), _proposed(_table(learned, rig.bench, seed, ("proposed",))))
    except SstlError as error:
        if error.code not in UNLEARNED:
            raise
        return _Judged(withheld, None, None)


def _table(learned: block_r.Learned, bench: Bench, seed: int, methods: tuple[str, ...] = METHODS) -> Table:
    """Return Table IV with a given mapping, probed and tracked on a bench."""
    drives = [block_r.drive(b, learned, seed, bench) for b in block_r.new_bends(seed)]
    return tracking_entries(block_r.tracked(drives, seed, bench, methods=methods).scores[WINDOW_STEADY])


def _proposed(table: Table) -> float:
    return float(np.mean([v for k, v in table.items() if k[0] == "IV" and "proposed" in k[1] and k[2].startswith("rmse")]))
