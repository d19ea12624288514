"""Block R of Table IV: the elastic rig as the plant, and the paper's pipeline learned from its noisy recordings.

Nothing of the plant is handed to the controller. 150 bends are recorded with both systems, their loops segmented, one
Skip-MLP with L_inv trained on three quarters of them, the biases averaged; then bends that were not among them are
probed, mapped and tracked along the paper's references in full length. What the rig is made of is not known either:
its constants are fitted to the published tables (``paper/rig.py``), so that it stands in for hardware of that kind.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import astuple, dataclass, replace

import numpy as np
from numpy.typing import NDArray

from sstl_cli.control import references
from sstl_cli.control.controller import IDENTITY, Controller, Options, Theta
from sstl_cli.control.plant import Plant, TensionLoop, track
from sstl_cli.control.references import Reference
from sstl_cli.control.scoring import WINDOW_ALL, WINDOW_STEADY, Score, score, windows
from sstl_cli.core.errors import SstlError
from sstl_cli.core.rng import stream
from sstl_cli.identification import segment_run
from sstl_cli.mapping.inference import forward
from sstl_cli.mapping.split import FIT, HELD_OUT, VALIDATION, make_splits
from sstl_cli.mapping.training import fit
from sstl_cli.mapping.variants import VARIANTS
from sstl_cli.paper.bench import Bench, RigBench
from sstl_cli.paper.limit import errors
from sstl_cli.paper.rig import LAG_S, Bend, bends, lines_of, slow_sine, trapezoid
from sstl_cli.paper.scores import Cell, tracking_entries
from sstl_cli.paper.settings import METHODS
from sstl_cli.paper.statistics import line_entries
from sstl_cli.paper.table_iii import require_apart

Array = NDArray[np.float64]
Key = tuple[str, str, str]
BENDS = 50
CYCLES = 3
SHOWN_EVERY = 50
SLOPES = [0, 2]
RIG = RigBench()
NETWORK = "skip-inv"
#: of the calibration bends, how many at least must show both lines of both systems
LEAST_IDENTIFIED = 0.9
NOISE_IN_N = 0.02


@dataclass(frozen=True)
class Learned:
    """What calibration gives: the network, constant biases (N), its held-out errors and the bends it used.

    ``predict`` maps sensing-loop slopes, shape (n, 2), to actuation slopes; ``entries`` holds Tables I and II of the
    bends at CP, and Table III's row on the bends held out of training; ``trained`` and ``held_out`` name the bends
    of either part, ``failed`` those that could not be identified.
    """

    predict: Callable[[Array], Array]
    biases: tuple[float, float]
    entries: Mapping[Key, float]
    trained: tuple[str, ...]
    held_out: tuple[str, ...]
    failed: tuple[str, ...] = ()


@dataclass(frozen=True)
class Drive:
    """What is known of a tracked bend: lines by direct identification and by the mapping."""

    bend: Bend
    direct: Theta
    mapped: Theta

    def lines(self, method: str) -> Theta:
        """Return the lines a method drives with; without compensation they are the identity."""
        return {"none": IDENTITY, "no-bias": self.mapped.without_bias(), "DI": self.direct, "proposed": self.mapped}[method]


@dataclass(frozen=True)
class Tracked:
    """Scores by window and cell; for figures every fiftieth sample of outputs (N), references and the last method's phases."""

    scores: Mapping[str, Mapping[Cell, Score]]
    outputs: Mapping[Cell, Array]
    references: Mapping[tuple[str, str], Reference]
    phases: Mapping[tuple[str, str], NDArray[np.int8]]


@dataclass(frozen=True)
class BlockR:
    """Block R of one data seed: entries by window (Table III's row with the first), what was learned and tracked."""

    seed: int
    entries: Mapping[str, Mapping[Key, float]]
    learned: Learned
    tracked: Tracked


def learn(seed: int, bench: Bench = RIG, per_location: int = BENDS) -> Learned:
    """Record, segment and train on ``per_location`` bends at each location.

    Raises
    ------
    SstlError
        E802 if more than a tenth of the bends could not be identified.
    """
    sets = bends(per_location, stream(seed, "block R", "calibration"))
    found = {b: (_probed(b, "sstl", seed, bench), _probed(b, "act", seed, bench)) for b in sets}
    used = [b for b, (sstl, act) in found.items() if sstl is not None and act is not None]
    failed = tuple(b.name for b in sets if b not in used)
    if len(used) < LEAST_IDENTIFIED * len(sets):
        raise SstlError(f"only {len(used)} of {len(sets)} calibration bends could be identified", code="E802")
    pairs = [(s, a) for s, a in (found[b] for b in used) if s is not None and a is not None]
    sstl, act = (np.array([astuple(pair[i]) for pair in pairs]) for i in (0, 1))
    made = _trained(seed, used, sstl, act)
    centre = [i for i, b in enumerate(used) if b.location == "CP"]
    betas = {(name, d): lines[centre, column] for name, lines in (("act", act), ("sstl", sstl)) for d, column in (("p", 1), ("r", 3))}
    slopes = line_entries(sstl[centre][:, SLOPES], act[centre][:, SLOPES], betas)
    return replace(made, entries={**slopes, **made.entries}, failed=failed)


def _trained(seed: int, used: Sequence[Bend], sstl: Array, act: Array) -> Learned:
    """Return one network trained on three quarters of the bends, and its errors on the rest."""
    network = next(v for v in VARIANTS if v.name == NETWORK)
    names = [b.name for b in used]
    x, y = sstl[:, SLOPES], act[:, SLOPES]
    splits = make_splits({b.name: b.location for b in used}, (seed,), seed)
    require_apart(names, splits)
    held, trained = splits.mask(names, HELD_OUT)[0], splits.mask(names, FIT + VALIDATION)[0]
    group = fit(x, y, names, splits, (network,)).group

    def predict(slopes: Array) -> Array:
        return np.asarray(forward(slopes, group.scaling, group.variants[NETWORK], network.alpha)[0])

    e = errors(predict(x)[held], y[held])
    entries = {("III", NETWORK, c): v for c, v in (("rmse_p", e.rmse_p), ("rmse_r", e.rmse_r), ("total", e.total))}
    parts = [tuple(n for n, inside in zip(names, mask, strict=True) if inside) for mask in (trained, held)]
    biases = act[trained].mean(axis=0)
    return Learned(predict, (float(biases[1]), float(biases[3])), entries, parts[0], parts[1])


def _probed(bend: Bend, system: str, seed: int, bench: Bench) -> Theta | None:
    return lines_of(segment_run(bench.record(bend, system, *trapezoid(system), seed)))


def new_bends(seed: int) -> list[Bend]:
    """Return the bends to be tracked, one a location, none of them a calibration bend."""
    return [replace(b, name=f"{b.location}-test") for b in bends(1, stream(seed, "block R", "test"))]


def drive(bend: Bend, learned: Learned, seed: int, bench: Bench = RIG) -> Drive:
    """Probe a new bend: the sensing loop for the mapping, the actuation tendon for direct identification.

    Raises
    ------
    SstlError
        E807 if the bend was among the calibration bends, E802 if it could not be identified.
    """
    if bend.name in (*learned.trained, *learned.held_out, *learned.failed):
        raise SstlError(
            f"bend {bend.name} is to be tracked, but was among the calibration bends",
            fix="track bends that calibration has not seen",
            code="E807",
        )
    sstl = _probed(bend, "sstl", seed, bench)
    direct = lines_of(segment_run(bench.record(bend, "act", *slow_sine(), seed)))
    if sstl is None or direct is None:
        raise SstlError(f"bend {bend.name} could not be identified", code="E802")
    gp, gr = learned.predict(np.array([[sstl.gamma_p, sstl.gamma_r]]))[0]
    return Drive(bend, direct, Theta(float(gp), learned.biases[0], float(gr), learned.biases[1]))


def paper_references(seed: int, location: str) -> list[Reference]:
    """Return the paper's references in full length: 0.01 Hz, 10 +- 5 N for three cycles; random, 5-30 N, 400 s."""
    return [references.sinusoid(cycles=CYCLES), references.random(stream(seed, "reference", location))]


def tracked(
    drives: Sequence[Drive],
    seed: int,
    bench: Bench = RIG,
    lag_s: float = LAG_S,
    methods: Sequence[str] = METHODS,
    wanted: Callable[[int, str], list[Reference]] = paper_references,
) -> Tracked:
    """Return what every method reaches on every reference at every tracked bend."""
    scores: dict[str, dict[Cell, Score]] = {}
    outputs: dict[Cell, Array] = {}
    shown: dict[tuple[str, str], Reference] = {}
    phases: dict[tuple[str, str], NDArray[np.int8]] = {}
    loop = TensionLoop(lag_s, noise_n=NOISE_IN_N)
    for d in drives:
        place = d.bend.location
        own = Plant(bench.tendon(d.bend), loop)
        for reference in wanted(seed, place):
            shown[reference.name, place] = replace(
                reference, time_s=reference.time_s[::SHOWN_EVERY], tension_n=reference.tension_n[::SHOWN_EVERY]
            )
            for method in methods:
                controller = Controller(d.lines(method), Options(), method != "none")
                rng = stream(seed, "sensor", d.bend.name, reference.name)
                done = track(controller, own, reference.tension_n, rng)
                outputs[reference.name, method, place] = done.tension_out[::SHOWN_EVERY]
                phases[reference.name, place] = done.phase[::SHOWN_EVERY]
                for window, part in windows(reference.time_s, reference.cycle_s).items():
                    cell = score(reference.tension_n[part], done.tension_out[part])
                    scores.setdefault(window, {})[reference.name, method, place] = cell
    return Tracked(scores, outputs, shown, phases)


def draw(made: BlockR) -> dict[str, dict[Key, float]]:
    """Return the entries of a data seed by block: "rig" without the first cycle, "rig, whole" with it."""
    steady, whole = made.entries[WINDOW_STEADY], made.entries[WINDOW_ALL]
    return {"rig": dict(steady), "rig, whole": {k: v for k, v in whole.items() if k not in made.learned.entries}}


def run(seed: int, bench: Bench = RIG, per_location: int = BENDS) -> BlockR:
    """Return block R of one data seed: its own bends, noise and references."""
    learned = learn(seed, bench, per_location)
    drives = [drive(b, learned, seed, bench) for b in new_bends(seed)]
    made = tracked(drives, seed, bench)
    entries = {w: {**tracking_entries(s), **learned.entries} for w, s in made.scores.items()}
    return BlockR(seed, entries, learned, made)
