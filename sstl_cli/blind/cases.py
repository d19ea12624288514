"""One case: a bench, what is withheld, its recordings, and the truth that goes under seal."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from sstl_cli.blind import bench as benches
from sstl_cli.blind.record import DISTURBANCE, Source
from sstl_cli.blind.schedule import Entry, two_effects
from sstl_cli.blind.strength import Direction, band, direction, find_scale
from sstl_cli.blind.truth import CaseTruth, Effects
from sstl_cli.core.errors import SstlError
from sstl_cli.core.rng import stream
from sstl_cli.core.runs import Run
from sstl_cli.physics import disturbances, recording
from sstl_cli.physics.effects import catalogue, get
from sstl_cli.physics.recording import Recording
from sstl_cli.physics.scenario import Scenario

ATTEMPTS, PAIR_ATTEMPTS = 6, 8
# each part of a pair carries at least this share of its gap
PAIR_SHARE = 1.0 / 3.0
# quieter sensors than these do not exist (N)
QUIETEST_N = 0.004
RIGID_N = 1e6
# a gap below this share of what was asked is no gap
HIDDEN = 0.02
# a bench of which the re-tuned base leaves more than this share of the noise does not have nothing missing
SILENT = 0.1
# so many are drawn before none is said to reach the gap
DISTURBANCES = 60


@dataclass(frozen=True)
class Case:
    """Recordings to diagnose, one more recording for the score, the simulator as the lab states it, and the truth."""

    runs: list[Run]
    fresh: list[Run]
    sim: Scenario
    exclude: tuple[str, ...]
    truth: CaseTruth


@dataclass(frozen=True)
class _Withheld:
    """What a simulator is to lack: the source with sensors that show it, the effects, their size or a pair's shares of the gap."""

    source: Source
    effects: Effects
    scale: float | None = None
    shares: Mapping[str, float] | None = None


def draw(entry: Entry, seed: int, quick: bool = False, hardware: str = "rig", as_labs: bool = False) -> Case:
    """Return the case that belongs to a schedule entry and a seed; ``as_labs`` draws how it is recorded, too.

    Raises
    ------
    SstlError
        If no bench of several drawn ones could be simulated.
    """
    reason = ""
    for attempt in range(ATTEMPTS):
        rng = stream(seed, "case", attempt)
        lab = recording.draw(rng) if as_labs else None
        try:
            return _draw(entry, rng, seed, quick, hardware, lab, attempt)
        except (SstlError, ValueError) as error:
            # too violent for the solver, or none that asks what was meant: another bench is drawn, by the same rules
            reason = str(error)
    raise SstlError(f"no bench could be simulated in {ATTEMPTS} attempts ({reason})", where=f"seed {seed}", code="E950")


def rebuild(truth: CaseTruth) -> tuple[Source, Effects]:
    """Return the source and the effects of a case from its opened truth, as they were when it was recorded.

    Raises
    ------
    SstlError
        If the truth does not say how it was drawn (sets from before it did).
    """
    if truth.attempt is None:
        raise SstlError("the set is from before distances could be taken", fix="make the set again", code="E960")
    effects = {k: dict(v) for k, v in truth.effects.items()}
    rng = stream(truth.seed, "case", truth.attempt)
    lab = recording.draw(rng) if truth.recording is not None else None
    source = _source(truth.kind, tuple(effects), rng, truth.seed, truth.quick, truth.simulator, lab)
    for _ in range(DISTURBANCES if truth.unlisted else 0):
        drawn = disturbances.draw(rng)
        if truth.unlisted == (drawn.description,):
            source = replace(source, disturbance=drawn)
            break
    return source.with_noise(truth.noise["white_n"] / source.bench.noise.white_n).as_recorded(), effects


def _source(
    kind: str, ids: tuple[str, ...], rng: np.random.Generator, seed: int, quick: bool, hardware: str, lab: Recording | None
) -> Source:
    """Return the bench of a case, before anything is withheld."""
    poor = ("slow", "still")[int(rng.integers(2))] if kind == "poor" else None
    bench = benches.draw(rng, quick, kind == "nominal", poor, hardware, lab)
    channels = {get(e).channel for e in ids if e != DISTURBANCE}
    bench = replace(
        bench,
        position="position" in channels or (bool(rng.random() < 0.3) if lab is None else lab.position),
        reference="loop" in channels or (bool(rng.random() < 0.3) if lab is None else lab.reference),
        poor=poor,
    )
    if bench.position:
        # to judge a position, a lab has to know its stiffnesses; a rigid tendon is the claim that is wrong then
        stiff = {"load_n_per_mm": bench.spec.load_k1_n_per_mm}
        if "tendon_elasticity" in ids:
            bench = replace(bench, spec=replace(bench.spec, ea_n=RIGID_N))
        else:
            stiff["ea_n"] = bench.spec.ea_n
        known = bench.known.model_copy(update=stiff)
        bench = replace(bench, known=known)
    if "slack" in ids:
        bench = benches.with_low_tension(bench)
    return Source(bench, seed)


def _draw(entry: Entry, rng: np.random.Generator, seed: int, quick: bool, hardware: str, lab: Recording | None, attempt: int) -> Case:
    source = _source(entry.kind, entry.effects, rng, seed, quick, hardware, lab)
    bench, channels = source.bench, {get(e).channel for e in entry.effects if e != DISTURBANCE}
    null_n, _ = source.gap({})
    held = _withheld(entry, source, rng, null_n)
    source, effects = held.source.as_recorded(), held.effects
    gap, theta = source.gap(effects)
    own = _beyond(gap, null_n)
    noise = source.noise_n
    if not entry.effects and null_n > SILENT * noise:
        raise SstlError("the bench shows more than the base without any effect", code="E951")
    channel = next((c for c in channels if c != "out"), "out")
    strength = own / noise
    if channel != "out" and effects:
        strength = source.channel_gap(effects, channel) / _channel_noise(source, channel)
    exclude = _exclude(entry, effects, rng)
    claims = {}
    if bench.position and "tendon_elasticity" not in effects:
        claims = {"tendon_elasticity": {"compliance_per_kn": 1000.0 / bench.spec.ea_n}}
    truth = CaseTruth(
        kind=entry.kind,
        effects=effects,
        strength_target=entry.strength,
        strength=strength if effects else 0.0,
        band=band(strength) if effects else None,
        channel=channel,
        gap_n=gap,
        gap_null_n=null_n,
        noise_n=noise,
        excluded=entry.kind == "excluded",
        unlisted=() if source.disturbance is None else (source.disturbance.description,),
        # a reading that sticks or drops out, or friction that differs from run to run, is no news: the catalogue has it (EFFECTS)
        also=() if source.disturbance is None else source.disturbance.listed,
        wrong_nominal=entry.kind == "nominal",
        poor=bench.poor,
        theta=bench.theta,
        theta_retuned=tuple(theta),
        nominal=bench.nominal,
        seed=seed,
        attempt=attempt,
        quick=quick,
        rate_hz=bench.rate_hz,
        recording=None if source.bench.lab is None else source.bench.lab.description,
        noise={k: float(getattr(source.bench.noise, k)) for k in ("white_n", "coloured_n", "correlation_s")},
        nodes=bench.spec.nodes,
        simulator=hardware,
        scale=held.scale,
        shares=held.shares,
    )
    return Case(
        source.record(bench.runs, effects), source.record(bench.fresh, effects, len(bench.runs)), bench.claims(claims), exclude, truth
    )


def _withheld(entry: Entry, source: Source, rng: np.random.Generator, null_n: float) -> _Withheld:
    if not entry.effects:
        return _Withheld(source, {})
    if entry.kind == "pair":
        return _two(entry, source, rng, null_n)
    effect_id = entry.effects[0]
    if effect_id == DISTURBANCE:
        return _disturbed(entry, source, rng, null_n)
    if entry.kind == "poor" and source.bench.runs[0].command_n.min() > 0.8 * source.bench.runs[0].command_n.max():
        # nothing shows in backlash: a strength that would be plain to see on other movements
        return _Withheld(source, {effect_id: _direction(effect_id, rng, source).at(0.3)})
    channel = get(effect_id).channel
    way = _direction(effect_id, rng, source)
    noise = _channel_noise(source, channel) if channel != "out" else source.noise_n
    target = entry.strength * noise
    scale, gap = find_scale(_gap_of(source, way, channel, null_n), target)
    lab = source.bench.lab
    if lab is not None and gap < HIDDEN * target:
        # it sits in a sensor or on a movement that this lab does not record: another lab is drawn
        raise SstlError("the recordings leave out what would show it", code="E951")
    if gap < 0.8 * target:
        # at its physical bound the effect is too small for these sensors: take better ones
        source = source.with_noise(max(gap / target, min(QUIETEST_N / source.noise_n, 1.0)))
    return _Withheld(source, {effect_id: way.at(scale)}, scale)


def _two(entry: Entry, source: Source, rng: np.random.Generator, null_n: float) -> _Withheld:
    """Return two effects of which each carries at least a third of the gap, alone and when the other is left out."""
    ids = entry.effects
    for _ in range(PAIR_ATTEMPTS):
        first = float(rng.uniform(0.55, 0.83))
        effects: Effects = {}
        alone = []
        for effect_id, share in zip(ids, (first, np.sqrt(1.0 - first**2)), strict=True):
            way = _direction(effect_id, rng, source)
            scale, gap = find_scale(_gap_of(source, way, "out", null_n), entry.strength * share * source.noise_n)
            effects[effect_id] = way.at(scale)
            alone.append(gap)
        both = _beyond(source.gap(effects)[0], null_n)
        dropped = [_beyond(both, other) for other in reversed(alone)]
        if both > 0.0 and min(*alone, *dropped) >= PAIR_SHARE * both and both > 0.5 * entry.strength * source.noise_n:
            return _Withheld(source, effects, shares={k: a / both for k, a in zip(ids, alone, strict=True)})
        # these two hide one another, or one reaches its bound: another two
        ids = two_effects([e for e in catalogue() if get(e).channel == "out"], rng)
    raise SstlError("no pair found of which both parts show", code="E951")


def _direction(effect_id: str, rng: np.random.Generator, source: Source) -> Direction:
    runs = source.bench.runs
    top_in = max(float(r.command_n.max()) for r in runs)
    top_out = max(float(source.truth(r, {})[1].max()) for r in runs)
    return direction(effect_id, rng, top_in, top_out)


def _disturbed(entry: Entry, source: Source, rng: np.random.Generator, null_n: float) -> _Withheld:
    """Return a disturbance that no catalogue holds, drawn until one leaves the wanted gap."""

    def gap(drawn: disturbances.Disturbance, amplitude: float) -> float:
        return _beyond(replace(source, disturbance=drawn).gap({DISTURBANCE: {"amplitude": amplitude}})[0], null_n)

    drawn, amplitude, _ = disturbances.draw_at(rng, entry.strength * source.noise_n, gap)
    return _Withheld(replace(source, disturbance=drawn), {DISTURBANCE: {"amplitude": amplitude}}, amplitude)


def _gap_of(source: Source, way: Direction, channel: str, null_n: float) -> Callable[[float], float]:
    def gap(scale: float) -> float:
        effects = {way.id: way.at(scale)}
        if channel != "out":
            return source.channel_gap(effects, channel)
        return _beyond(source.gap(effects)[0], null_n)

    return gap


def _channel_noise(source: Source, channel: str) -> float:
    return source.bench.noise.position_mm if channel == "position" else source.noise_n


def _beyond(rms: float, floor: float) -> float:
    return float(np.sqrt(max(rms**2 - floor**2, 0.0)))


def _exclude(entry: Entry, effects: Effects, rng: np.random.Generator) -> tuple[str, ...]:
    """Return the one effect that is no candidate; half of all other cases name one too, so that it tells nothing."""
    if entry.kind == "excluded":
        return tuple(effects)
    others = [e for e in catalogue() if e not in effects and get(e).channel != "neighbour"]
    return (others[int(rng.integers(len(others)))],) if rng.random() < 0.5 else ()
