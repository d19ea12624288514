"""Fill the table of docs/variant.md: every law of the variant rig, its source, and how far the fast model stays from it.

Usage: python tools/variant_table.py [--effect ID ...]
With ``--effect`` the rows of these effects are printed and the page stays as it is.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np
from effects_table import CASES
from numpy.typing import NDArray
from page_part import put, table
from scipy.optimize import least_squares

from sstl_cli.physics.effect import Effect, Mechanics, Parameter
from sstl_cli.physics.effects import catalogue, get
from sstl_cli.physics.transmission import activate, measure, predict, predict_position
from sstl_cli.physics.transmission.model import Active, drive_of, observed_output, true_input
from sstl_cli.physics.variant import QUIET, VariantRun, VariantSpec, known_laws, parameters, simulate_variant

Array = NDArray[np.float64]
Values = Mapping[str, float]
HZ = 100.0
# two bends, both systems; a slow and a fast movement with minor loops and holds
BENDS = {"NP": 0.46, "ND": 0.60}
SLOW = ([0.0, 4, 7, 11, 13, 15, 17, 21, 23, 26, 30], [0.0, 22, 22, 0, 0, 2, 18, 6, 15, 3, 20])
FAST = ([0.0, 1, 1.5, 2.5, 3, 4, 4.6, 5.2, 6, 8], [0.0, 22, 22, 2, 2, 18, 6, 15, 3, 20])
# compliance of the tendon as built (1/kN): the rig's position always contains its stretch
AS_BUILT = {"tendon_elasticity": {"compliance_per_kn": 0.125}}


@dataclass(frozen=True)
class Record:
    """One run as recorded without noise: what was commanded and what the channels show."""

    system: str
    place: str
    command: Array
    beside: Array
    tension_in: Array
    tension_out: Array
    position: Array


def record(effect_id: str | None, law: str | None = None) -> list[Record]:
    """Return the runs of the variant rig with one effect by one law, or without any."""
    effects = {} if effect_id is None else {effect_id: CASES[effect_id]}
    found = []
    for (place, theta), system, movement in product(BENDS.items(), ("act", "sstl"), (SLOW, FAST)):
        time = np.arange(round(movement[0][-1] * HZ)) / HZ
        command = np.interp(time, *movement)
        beside = np.interp(time - 1.0, *movement)
        spec = VariantSpec(laws={} if effect_id is None or law is None else {effect_id: law}, law_seed=1)
        run = VariantRun(system, theta, place, time, "tension", command, beside)
        seen = simulate_variant(spec, run, effects, QUIET, 3)
        found.append(Record(system, place, command, beside, seen.tension_in_n, seen.tension_out_n, seen.position_in_mm))
    return found


def modelled(runs: Sequence[Record], active: Active, theta: Mapping[str, float]) -> list[Array]:
    """Return the output that the fast model predicts from the measured input of each run."""
    found = []
    for r in runs:
        true_in = true_input(r.system, 1.0 / HZ, r.tension_in, r.tension_out, active)
        drive = drive_of(r.system, r.place, 1.0 / HZ, true_in, Mechanics())
        if any(effect.channel == "neighbour" for effect, _ in active.items):
            drive = replace(drive, neighbour_n=r.beside)
        out = predict(drive, theta[r.place], active, 5.0)
        found.append(observed_output(r.system, 1.0 / HZ, r.tension_in, out, active))
    return found


def rms(parts: Sequence[Array]) -> float:
    """Return the RMS of all parts together."""
    return float(np.sqrt(np.mean(np.concatenate(list(parts)) ** 2)))


def least(residual: Callable[[Array], Array], low: Array, high: Array, starts: Sequence[Array]) -> float:
    """Return the RMS of the smallest residual found from some starts."""
    span = high - low
    found = [least_squares(residual, s, bounds=(low, high), x_scale=span, diff_step=np.full(low.size, 1e-3), max_nfev=25) for s in starts]
    best = min(found, key=lambda f: f.cost)
    return float(np.sqrt(np.mean(best.fun**2)))


def fitted(effect: Effect | None, residual: Callable[[Values | None, Array], Array], thetas: int) -> float:
    """Return what is left of a residual once theta of each bend and the parameters of an effect are refitted, by its best law."""
    known = [] if effect is None else [p for p in effect.parameters if p.name != "k_sh_mm_per_n" or effect.channel == "position"]
    laws = [] if effect is None else [[p for p in known if p.name in v] for v in effect.variants]
    return min(_fitted(effect, free, residual, thetas) for free in [known, *laws])


def _fitted(effect: Effect | None, free: Sequence[Parameter], residual: Callable[[Values | None, Array], Array], thetas: int) -> float:
    """Return what is left of a residual with some parameters of an effect free."""
    low = np.array([0.05] * thetas + [p.low for p in free])
    high = np.array([1.5] * thetas + [p.high for p in free])
    starts = []
    for share in (0.25,) if effect is None else (0.25, -0.25):
        inner = [p.neutral + share * ((p.high if share > 0.0 else 2.0 * p.neutral - p.low) - p.neutral) for p in free]
        # a shape from neutral and from the middle of its range: the way from one to the other may have a valley of its own
        for middle in (False, True) if any(p.shape for p in free) else (False,):
            shapes = [0.5 * (p.low + p.high) if middle else p.neutral for p in free]
            start = np.array([0.5] * thetas + [s if p.shape else v for p, v, s in zip(free, inner, shapes, strict=True)])
            starts.append(np.clip(start, low + 1e-6 * (high - low), high - 1e-6 * (high - low)))
        if effect is None or all(p.low >= p.neutral or p.shape for p in free):
            break

    def of(x: Array) -> Array:
        values = dict(zip((p.name for p in free), x[thetas:].tolist(), strict=True))
        return residual(None if effect is None else values, x[:thetas])

    return least(of, low, high, starts)


def out_row(effect: Effect, runs: Sequence[Record]) -> tuple[float, float]:
    """Return what base and effect leave of the output tension (N), refitted."""

    def residual(values: Values | None, theta: Array) -> Array:
        active = activate({} if values is None else {effect.id: values})
        model = modelled(runs, active, dict(zip(BENDS, theta, strict=True)))
        return np.concatenate([m - r.tension_out for m, r in zip(model, runs, strict=True)])

    return fitted(None, residual, len(BENDS)), fitted(effect, residual, len(BENDS))


def recorder_row(effect: Effect, runs: Sequence[Record], clean: Sequence[Record]) -> tuple[float, float | None]:
    """Return the size of a recorder's effect (N) and its distance from the catalogue's on the same clean record."""
    gap = rms([r.tension_out - c.tension_out for r, c in zip(runs, clean, strict=True)])
    if effect.id == "acquisition_faults":
        return gap, None
    active = activate({effect.id: CASES[effect.id]})
    seen = [measure(c.system, 1.0 / HZ, c.tension_in, c.tension_out, active)[1] for c in clean]
    return gap, rms([s - r.tension_out for s, r in zip(seen, runs, strict=True)])


def loop_row(effect: Effect, runs: Sequence[Record]) -> tuple[float, float]:
    """Return what the command itself and the refitted lag leave of the input tension (N)."""

    def residual(values: Values | None, _theta: Array) -> Array:
        assert effect.loop is not None
        full = effect.neutral() if values is None else effect.complete(values)
        return np.concatenate([effect.loop(r.command, 1.0 / HZ, full) - r.tension_in for r in runs])

    return rms([r.command - r.tension_in for r in runs]), fitted(effect, residual, 0)


def position_row(effect: Effect, runs: Sequence[Record]) -> tuple[float, float]:
    """Return what the tendon as built and the refitted effect leave of the position (mm, origin free)."""

    def residual(values: Values | None, _theta: Array) -> Array:
        active = activate({**AS_BUILT, **({} if values is None else {effect.id: values})})
        parts = []
        for r in runs:
            drive = drive_of(r.system, r.place, 1.0 / HZ, r.tension_in, Mechanics())
            x = predict_position(drive, BENDS[r.place], active, predict(drive, BENDS[r.place], active, 5.0)) - r.position
            parts.append(x - x.mean())
        return np.concatenate(parts)

    return rms([residual(None, np.empty(0))]), fitted(effect, residual, 0)


def rows(effect_id: str, clean: Sequence[Record]) -> list[list[object]]:
    """Return the cells of an effect's rows, one row a law."""
    effect = get(effect_id)
    found: list[list[object]] = []
    for law in known_laws()[effect_id]:
        runs = record(effect_id, law.id)
        left: float | None
        unit = "mm" if effect.channel == "position" else "N"
        if effect.channel == "position":
            gap, left = position_row(effect, runs)
        elif effect.channel == "loop":
            gap, left = loop_row(effect, runs)
        elif not effect.fitted:
            gap, left = recorder_row(effect, runs, clean)
        else:
            gap, left = out_row(effect, [r for r in runs if effect.channel != "neighbour" or r.system == "act"])
        # jumps can keep the search from the neutral values, which are the refitted base
        left = left if left is None or not effect.fitted else min(left, gap)
        shown = "random" if left is None else f"{left:.4f}"
        share = "" if left is None else f"{100.0 * left / gap:.0f} %"
        equation = f"`{law.equation}`".replace("|", "\\|")
        found.append([f"`{effect_id}`", f"`{law.id}`", equation, law.source, f"{gap:.4f} {unit}", shown, share])
    return found


HEAD = ["effect", "law", "equation", "source", "gap of the refitted base", "left, effect refitted", "share"]


def main() -> None:
    """Fill the table of the page, or print some rows."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--effect", nargs="*", default=[])
    asked = parser.parse_args().effect
    clean = record(None)
    text = table(HEAD, [row for e in asked or catalogue() if e in parameters() for row in rows(e, clean)])
    if asked:
        print(text)
    else:
        put("variant.md", "laws", text)


if __name__ == "__main__":
    main()
