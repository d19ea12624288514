"""Rebuild the paper's tables from data and set them beside the published numbers."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

from sstl_cli.core.errors import UsageError, nearest
from sstl_cli.paper.compare import Compared, compare
from sstl_cli.paper.published import of_table
from sstl_cli.paper.settings import EXPLAINED, STATED
from sstl_cli.paper.spread import Spread
from sstl_cli.steps import (
    reproduce_better,
    reproduce_diagnosis,
    reproduce_gap,
    reproduce_mapping,
    reproduce_probe,
    reproduce_slopes,
    reproduce_tracking,
)
from sstl_cli.steps.reproduce_better import Rung
from sstl_cli.steps.reproduce_diagnosis import Named
from sstl_cli.steps.reproduce_gap import Gap
from sstl_cli.steps.reproduce_mapping import Mapping as TableIII
from sstl_cli.steps.reproduce_probe import Probe
from sstl_cli.steps.reproduce_slopes import Slopes
from sstl_cli.steps.reproduce_tracking import Block, Prepared

Key = tuple[str, str, str]
TABLES = ("I", "II", "III", "IV", "R", "diagnosis", "figures", "better", "probe")
#: what ``all`` means: the extensions take longer than the paper's own tables
DEFAULT = ("I", "II", "III", "IV", "diagnosis", "figures")


@dataclass(frozen=True)
class Reproduction:
    """Everything that was rebuilt; parts that were not asked for are None or empty."""

    compared: tuple[Compared, ...] = ()
    slopes: Slopes | None = None
    mapping: TableIII | None = None
    prepared: Prepared | None = None
    blocks: tuple[Block, ...] = ()
    gap: Gap | None = None
    named: Named | None = None
    better: tuple[Rung, ...] = ()
    probes: tuple[Probe, ...] = ()
    figures: bool = False
    spread: Spread = field(default_factory=Spread)


def chosen(text: str) -> tuple[str, ...]:
    """Return the tables that ``--table`` names: one, several with commas, or ``all``.

    Raises
    ------
    UsageError
        E803 for an unknown name.
    """
    names = [n.strip() for n in text.split(",") if n.strip()]
    if names == ["all"]:
        return DEFAULT
    for name in names:
        if name not in TABLES:
            raise UsageError(f"no table '{name}' ({nearest(name, [*TABLES, 'all'])})", where="--table", code="E803")
    if not names:
        raise UsageError("no table named", where="--table", fix=f"use all, or some of {','.join(TABLES)}", code="E803")
    return tuple(t for t in TABLES if t in names)


def run(
    tables: Sequence[str],
    seed: int,
    seeds: int,
    spread: Spread,
    report: Callable[[str], None] | None = None,
    advance: Callable[[float], None] | None = None,
) -> Reproduction:
    """Return the tables asked for.

    Parameters
    ----------
    tables : sequence of str
        Names out of ``TABLES``.
    seeds : int
        Training seeds of Table III.
    spread : Spread
        Stored mean and standard deviation of every entry over data seeds.
    report : callable, optional
        Told what begins.
    """
    say = report or (lambda text: None)
    compared: list[Compared] = []
    slopes = mapping = gap = named = prepared = None
    blocks: tuple[Block, ...] = ()
    wants_tracking = bool({"IV", "diagnosis", "figures"} & set(tables))
    if {"I", "II"} & set(tables) or wants_tracking:
        say("Tables I and II: 40 configurations, simulated and segmented")
        slopes = reproduce_slopes.run(seed)
        for table in ("I", "II", "bias"):
            if table in tables or (table == "bias" and "II" in tables):
                compared += _judged(table, slopes.entries, spread.of("stated"), "stated")
    if "III" in tables or wants_tracking:
        say(f"Table III: 150 configurations, 5 variants x {seeds} seeds")
        held = tuple(c.id for c in reproduce_tracking.tracked(seed).values())
        mapping = reproduce_mapping.run(seed, seeds, held, advance=advance)
        if "III" in tables:
            own = {k: (mapping.entries[k], sd) for k, sd in mapping.spread.items()}
            compared += _judged("III", mapping.entries, own, "stated")
    if wants_tracking and slopes is not None and mapping is not None:
        say("Table IV: three locations, two references, four methods, two sets of settings")
        prepared = reproduce_tracking.prepare(seed, mapping.predict, biases(slopes))
        blocks = tuple(reproduce_tracking.block(s, prepared, seed) for s in (STATED, EXPLAINED))
        if "IV" in tables:
            for made in blocks:
                for table in ("IV", "summary"):
                    compared += _judged(table, made.entries, spread.of(made.settings.name), made.settings.name)
            say("the difference between the blocks: parts of the explanation")
            gap = reproduce_gap.run(prepared, seed)
        if "diagnosis" in tables:
            say("the difference between the blocks: diagnosed")
            named = reproduce_diagnosis.run(prepared, blocks[1], seed)
    calibration = None
    better: tuple[Rung, ...] = ()
    probes: tuple[Probe, ...] = ()
    if {"better", "probe"} & set(tables):
        say("the rig: calibration")
        calibration = reproduce_better.calibrate(seed)
    if "better" in tables:
        say("better than the paper: the rig, one means after the other")
        better = tuple(reproduce_better.run(seed, calibration))
    if "probe" in tables:
        say("a shorter probe: the rig, faster and partial strokes")
        probes = tuple(reproduce_probe.run(seed, calibration))
    return Reproduction(
        tuple(compared), slopes, mapping, prepared, blocks, gap, named, better, probes, "figures" in tables, spread
    )


def biases(slopes: Slopes) -> tuple[float, float]:
    """Return the pre-calibrated biases of the actuation tendon (N): means over Table I's configurations."""
    return slopes.entries["bias", "act_beta_p", "mean"], slopes.entries["bias", "act_beta_r", "mean"]


def _judged(
    table: str, ours: Mapping[Key, float], spread: Mapping[Key, tuple[float, float]], block: str
) -> list[Compared]:
    return compare(of_table(table), ours, spread, block)


def measure_spread(seed: int, seeds: int, advance: Callable[[float], None] | None = None) -> Spread:
    """Return mean and standard deviation of every entry of Tables I, II and IV over ``seeds`` data sets.

    Each seed draws its own configurations, noise and references; the mapping is trained once, on the first.
    """
    first = reproduce_mapping.run(seed, 2, left_out_seeds=1)
    calibration = reproduce_slopes.run(seed)
    draws: dict[str, list[dict[Key, float]]] = {STATED.name: [], EXPLAINED.name: []}
    for one, slopes in zip(range(seed + 1, seed + 1 + seeds), reproduce_slopes.spread(seeds, seed + 1), strict=True):
        prepared = reproduce_tracking.prepare(one, first.predict, biases(calibration))
        for s in (STATED, EXPLAINED):
            found = reproduce_tracking.block(s, prepared, one).entries
            draws[s.name].append({**slopes, **found} if s is STATED else found)
        if advance is not None:
            advance(1)
    return Spread({name: reproduce_slopes.moments(d) for name, d in draws.items()}, seeds)
