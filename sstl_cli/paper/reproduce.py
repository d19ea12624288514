"""Rebuild the paper's tables from data and set them beside the published numbers."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

from sstl_cli.paper import (
    better,
    contests,
    data_seeds,
    diagnosed,
    distal,
    gate,
    pace,
    probe,
    table_i_ii,
    table_iii,
    table_iv,
    table_iv_gap,
    tendons,
)
from sstl_cli.paper.better import Calibration, Rung
from sstl_cli.paper.chosen import DEFAULT
from sstl_cli.paper.compare import Compared, compare
from sstl_cli.paper.data_seeds import Drawn
from sstl_cli.paper.diagnosed import Closed
from sstl_cli.paper.distal import Bent
from sstl_cli.paper.gate import Outside
from sstl_cli.paper.probe import Probe
from sstl_cli.paper.published import TABLES as PUBLISHED
from sstl_cli.paper.published import of_table
from sstl_cli.paper.settings import FITTED, STATED
from sstl_cli.paper.spread import Spread, of_draws, stored
from sstl_cli.paper.table_i_ii import Slopes
from sstl_cli.paper.table_iii import Mapping as TableIII
from sstl_cli.paper.table_iv import Block, Prepared
from sstl_cli.paper.table_iv_gap import Gap
from sstl_cli.paper.tendons import Together

Key = tuple[str, str, str]


@dataclass(frozen=True)
class Options:
    """What to rebuild and how.

    ``seeds`` are the training seeds of Table III, ``data_seeds`` the data sets of block R that are recomputed and held
    against the committed spread, ``workers`` the processes.
    """

    tables: tuple[str, ...] = DEFAULT
    seed: int = 0
    seeds: int = table_iii.SEEDS_EACH
    data_seeds: int = 3
    workers: int = 1


@dataclass(frozen=True)
class Reproduction:
    """Everything that was rebuilt; parts that were not asked for are None or empty.

    ``outside`` are the entries of block R whose recomputed mean does not lie within the committed spread.
    """

    compared: tuple[Compared, ...] = ()
    slopes: Slopes | None = None
    mapping: TableIII | None = None
    prepared: Prepared | None = None
    blocks: tuple[Block, ...] = ()
    gap: Gap | None = None
    rig: tuple[Drawn, ...] = ()
    outside: tuple[Outside, ...] = ()
    closed: tuple[Closed, ...] = ()
    calibration: Calibration | None = None
    better: tuple[Rung, ...] = ()
    probes: tuple[Probe, ...] = ()
    tendons: tuple[Together, ...] = ()
    distal: tuple[Bent, ...] = ()
    figures: bool = False


def run(options: Options, report: Callable[[str], None] | None = None, advance: Callable[[float], None] | None = None) -> Reproduction:
    """Return the tables asked for; ``report`` is told what begins, ``advance`` the seconds that parts of it take (:mod:`pace`)."""
    say, told = report or (lambda text: None), _told(options, advance)
    seeds = range(options.seed, options.seed + options.data_seeds) if "R" in options.tables else range(0)
    made = Reproduction(figures="figures" in options.tables)
    with data_seeds.beside("R", seeds, options.workers - 1) as drawn:
        for part in (_lines, _mapping, _tracking):
            made = part(made, options, say, told)
        # beside other processes at block R there is time for the diagnosis, which needs of it but a table at its end
        beside = bool(seeds) and options.workers > 1
        for waiting in (_diagnosis, _block_r) if beside else (_block_r, _diagnosis):
            made = waiting(made, options, say, told, drawn if seeds else None)
    return _beyond(made, options, say, told)


Say = Callable[[str], None]
#: is told a part and which share more of it is done
Told = Callable[[str, float], None]


def _told(o: Options, advance: Callable[[float], None] | None) -> Told:
    seconds = pace.parts(o.tables, o.seeds, o.data_seeds, o.workers)
    return lambda part, share: advance(share * seconds[part]) if advance is not None else None


def _tracks(options: Options) -> bool:
    return bool({"IV", "figures"} & set(options.tables))


def _lines(made: Reproduction, o: Options, say: Say, told: Told) -> Reproduction:
    if not {"I", "II"} & set(o.tables) and not _tracks(o):
        return made
    say("Tables I and II: 40 configurations, simulated and segmented")
    slopes = table_i_ii.run(o.seed)
    told("I", 1.0)
    wanted = [t for t in ("I", "II", "bias") if t in o.tables or (t == "bias" and "II" in o.tables)]
    compared = _judged(wanted, slopes.entries, stored(), STATED.name)
    return replace(made, slopes=slopes, compared=(*made.compared, *compared))


def _mapping(made: Reproduction, o: Options, say: Say, told: Told) -> Reproduction:
    if "III" not in o.tables and not _tracks(o):
        return made
    say(f"Table III: 150 configurations, 5 variants x {o.seeds} seeds")
    held = tuple(c.id for c in table_iv.tracked(o.seed).values())
    mapping = table_iii.run(o.seed, o.seeds, held, advance=lambda share: told("III", pace.TRAINING * share))
    told("III", 1.0 - pace.TRAINING)
    compared: list[Compared] = []
    if "III" in o.tables:
        spread = stored("III")
        compared = compare(of_table("III"), mapping.entries, spread.of(contests.MEAN), STATED.name)
    return replace(made, mapping=mapping, compared=(*made.compared, *compared))


def _tracking(made: Reproduction, o: Options, say: Say, told: Told) -> Reproduction:
    if not _tracks(o) or made.slopes is None or made.mapping is None:
        return made
    say("Table IV: three locations, two references, four methods, two sets of settings")
    prepared = table_iv.prepare(o.seed, made.mapping.predict, table_iv.biases(made.slopes))
    blocks = tuple(table_iv.block(s, prepared, o.seed) for s in (STATED, FITTED))
    told("IV", 1.0)
    made = replace(made, prepared=prepared, blocks=blocks)
    if "IV" not in o.tables:
        return made
    compared = [c for b in blocks for c in _judged(_TRACKED, b.entries, stored(), b.settings.name)]
    say("the difference between the blocks: parts of the fit")
    gap = table_iv_gap.run(prepared, o.seed, lambda share: told("gap", share))
    return replace(made, gap=gap, compared=(*made.compared, *compared))


#: waits for the data seeds of block R (None: it is not asked for)
Awaited = Callable[[], list[Drawn]] | None


def _block_r(made: Reproduction, o: Options, say: Say, told: Told, awaited: Awaited) -> Reproduction:
    if awaited is None:
        return made
    say(f"block R: the rig, 150 bends, one network, four methods; {o.data_seeds} data seeds")
    drawn = awaited()
    told("R", 1.0)
    return _rig(made, drawn)


def _rig(made: Reproduction, drawn: Sequence[Drawn]) -> Reproduction:
    spread = stored("R")
    mean = of_draws([d.entries for d in drawn]).of("rig")
    compared = _judged(PUBLISHED, {k: v for k, (v, _) in mean.items()}, spread, "rig", only=True)
    outside = tuple(gate.outside([d.entries for d in drawn], spread))
    return replace(made, rig=tuple(drawn), outside=outside, compared=(*made.compared, *compared))


def _diagnosis(made: Reproduction, o: Options, say: Say, told: Told, awaited: Awaited) -> Reproduction:
    withheld = "withheld" in o.tables
    if not withheld and "diagnosis" not in o.tables:
        return made
    table = None if awaited is None else partial(_own, awaited, o.seed)
    # one process fewer while others are at block R; those withheld take far longer than it
    workers = o.workers if awaited is None or withheld else max(o.workers - 1, 1)
    closed = diagnosed.run(o.seed, "diagnosis" in o.tables, withheld, table, workers, say)
    for part in {"diagnosis", "withheld"} & set(o.tables):
        told(part, 1.0)
    return replace(made, closed=tuple(closed))


def _own(awaited: Callable[[], list[Drawn]], seed: int) -> Mapping[Key, float]:
    """Return what block R gave for one data seed."""
    return next(d.entries["rig"] for d in awaited() if d.seed == seed)


def _beyond(made: Reproduction, o: Options, say: Say, told: Told) -> Reproduction:
    if "tendons" in o.tables:
        say("several tendons: three that share a tube, tracked at once")
        made = replace(made, tendons=tuple(tendons.run(o.seed)))
        told("tendons", 1.0)
    if not pace.CALIBRATED & set(o.tables):
        return made
    say("the rig: calibration")
    calibration = better.calibrate(o.seed)
    told("calibration", 1.0)
    made = replace(made, calibration=calibration)
    if "better" in o.tables:
        say("better than the paper: the rig, one means after the other")
        made = replace(made, better=tuple(better.run(o.seed, calibration)))
        told("better", 1.0)
    if "probe" in o.tables:
        say("a shorter probe: the rig, faster and partial strokes")
        made = replace(made, probes=tuple(probe.run(o.seed, calibration, lambda share: told("probe", share))))
    if "distal" in o.tables:
        say("a distal joint that bends: the rig with a joint behind it")
        made = replace(made, distal=tuple(distal.run(o.seed, calibration)))
        told("distal", 1.0)
    return made


_TRACKED = ("IV", "summary", "headline")


def _judged(tables: Sequence[str], ours: Mapping[Key, float], spread: Spread, block: str, only: bool = False) -> list[Compared]:
    """Return the entries of some tables beside ours; ``only`` leaves out what we have no value for."""
    published = [e for t in tables for e in of_table(t)]
    found = compare(published, ours, spread.of(block), block)
    return [c for c in found if c.ours is not None] if only else found
