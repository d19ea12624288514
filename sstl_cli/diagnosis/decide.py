"""From fitted candidates to a verdict: identified, ambiguous, unknown or none, with probabilities."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from sstl_cli.diagnosis import calibration
from sstl_cli.diagnosis.evidence import advantage, block_scores, errors
from sstl_cli.diagnosis.fit import Fit
from sstl_cli.diagnosis.heldout import Folds, blocks, held_out_residual, make_folds
from sstl_cli.diagnosis.sawtooth import FAMILY, sawtooth
from sstl_cli.diagnosis.search import Search
from sstl_cli.diagnosis.where import phases
from sstl_cli.physics.effect import TRANSITION
from sstl_cli.physics.effects import get

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Rules:
    """Thresholds of the decision; set on rig-made development cases, never on a blind set."""

    # nats are discounted: no more than twice the squared number of standard errors counts
    gain_nats: float = 18.0
    # a gap also has to be this share of the sensor noise (RMS against RMS)
    gap_over_noise: float = 0.25
    # a gain that every block shares may be smaller
    sure_nats: float = 40.0
    sure_over_noise: float = 0.12
    # a gain in few blocks counts where it is large: standard errors, share of the squared error, nats
    large: tuple[float, float, float] = (2.0, 0.3, 100.0)
    # models closer than this explain the data equally well
    margin_nats: float = 20.0
    # where only repeats could be held out, whoever explains this share of what the winner does is a rival
    repeats_share: float = 0.8
    # a further effect must carry this share of the explained gap, and more than noise
    partner_share: float = 0.05
    # ... or, while this much (RMS over noise) is left, this share of what is left
    room_over_noise: float = 0.7
    clears: float = 0.6
    # the winner must explain this share of the reducible squared error
    explained: float = 0.7
    # a small gap of which the winner explains less than this is what noise does, not an effect
    least_share: float = 0.4
    # what is left beyond the noise may be this multiple of the noise, or this share of the gap (RMS)
    leftover_over_noise: float = 1.0
    leftover_share: float = 0.45
    # effects that do not act along the line are simulated exactly: what they leave, beyond this share and this multiple
    # of the noise, is something else
    exact_share: float = 0.975
    exact_over_noise: float = 0.4
    # scale of discounted log-score differences into probabilities, from the calibration library
    temperature: float = field(default_factory=lambda: calibration.temperature(4.0))


@dataclass(frozen=True)
class Candidate:
    """One model that was compared: its fit, held-out score and what it explains."""

    fit: Fit
    score: float
    blocks: Array
    rms_n: float
    white: Array
    raw: Array

    @property
    def ids(self) -> tuple[str, ...]:
        return self.fit.ids


@dataclass(frozen=True)
class Decision:
    """The verdict with everything that led to it."""

    status: str
    winner: Candidate | None
    group: tuple[tuple[str, ...], ...]
    confidence: float
    why: str
    base: Candidate
    candidates: tuple[Candidate, ...]
    probability: dict[tuple[str, ...], float]
    folds: Folds
    noise_n: float
    explained: float
    evidence: str = ""


# two effects that were fitted differ by more than noise where their scores do: there few blocks may decide
RIVAL_FEW = 20.0
# kinds of evidence are told apart at these leads
NEAR_NATS, CLEAR_NATS = 8.0, 80.0
# below this share of the reducible error a named effect has to stand against the shape of stick-slip
DOUBTFUL_SHARE = 0.85
FULL_SHARE = 0.95
# members of the stick-slip family that reach this share of the winner's gain are not told apart from it
FAMILY_SHARE = 0.6
# a member of the family that wins and explains this much is let off the jumps that it misses
FAMILY_LEAD = 0.45
# jumps that a fit misses invite partners: beside a member of the family they have to carry this share of the gap
FAMILY_PARTNER = 0.25


def jumps_instead(search: Search, d: Decision, candidates: Sequence[str], coloured: float) -> Decision:
    """Return an ambiguous verdict for the family of stick-slip effects where an unknown gap has its shape.

    Their waveform is chaotic: no simulation meets its jumps, so fits fail although the cause is plain. Where
    a member of the family is not a candidate the verdict stays unknown.
    """
    # what explains nearly all has no room for jumps, even if something else is left
    doubtful = d.explained < (FULL_SHARE if d.status == "unknown" else DOUBTFUL_SHARE) and d.status != "none"
    clipped = any(r.faults_in.clipped.any() or r.faults_out.clipped.any() for r in search.sim.problem.records)
    # a clipped record jumps too, where it leaves its flat top
    if not doubtful or clipped or not all(e in candidates for e in FAMILY):
        return d
    members = [c for c in d.candidates if len(c.ids) == 1 and c.ids[0] in FAMILY]
    if not members:
        return d
    leads = d.winner is not None and d.winner.ids == members[0].ids and d.explained > FAMILY_LEAD
    shapes = [sawtooth(search.sim, c.fit.residual, phases(search.sim, c.fit.prediction)) for c in (d.base, d.winner) if c]
    # drag and presliding can be met half-way by a member of the family, but they skew the other way
    certain = shapes[0].forward and (leads or any(shape.present(coloured) for shape in shapes))
    if d.status != "unknown":
        certain = certain and shapes[-1].present(coloured)
    if not certain:
        return d
    group = (members[0].ids, *((e,) for e in FAMILY if e != members[0].ids[0]))
    why = "the output lags and jumps along the motion, again and again: friction that falls once it slips"
    probability = {**dict.fromkeys(d.probability, 0.0), **dict.fromkeys(group, 0.9 / len(group))}
    return replace(
        d, status="ambiguous", winner=members[0], group=group, confidence=0.9, why=why, probability=probability,
        evidence="ambiguous/jumps",
    )


def assess(search: Search, f: Fit, folds: Folds, index: NDArray[np.int64]) -> Candidate:
    """Return a fit with its held-out block scores; the charge for its parameters is half a log-sample each."""
    raw, white = held_out_residual(search.sim, search.whiten, f, folds)
    scores = block_scores(white, index)
    w = search.sim.weight
    rms = float(np.sqrt(np.sum(w * raw**2) / max(w.sum(), 1.0)))
    charge = 0.5 * len(f.free) * float(np.log(max(w.sum(), 2.0)))
    return Candidate(f, float(scores.sum()) - charge, scores, rms, white, raw)


def decide(search: Search, noise_n: float, rules: Rules) -> Decision:
    """Return the verdict on a finished search.

    Parameters
    ----------
    noise_n : float
        RMS of the sensor noise at the analysis rate (N), measured where the output is held.
    """
    folds, index = make_folds(search.sim), blocks(search.sim)
    base = assess(search, search.base, folds, index)
    found = [assess(search, f, folds, index) for f in search.fits.values()]
    by_motion = any(r.slip is not None for r in search.sim.problem.records)
    return verdict(base, found, folds, noise_n, rules, search.sim.problem.unit_n, exact=not by_motion)


def verdict(
    base: Candidate, found: Sequence[Candidate], folds: Folds, noise_n: float, rules: Rules, unit_n: float = 1.0,
    exact: bool = True,
) -> Decision:
    """Return the verdict on assessed models; ``unit_n`` is only for the texts (N).

    ``exact`` False lets the noise be less than what the best model must leave (friction that varies along a stroke).
    """
    found = sorted(found, key=lambda c: (-c.score, c.ids))
    singles = [c for c in found if len(c.ids) == 1]
    winner = _grow(singles, found, base, rules, noise_n) if singles else None
    share = _explained(winner, base, noise_n) if winner else 0.0
    small = _leftover(base.rms_n, noise_n) < rules.leftover_over_noise * noise_n and share < rules.least_share
    if winner is None or small or not _matters(winner, base, rules, noise_n):
        leftover = _leftover(base.rms_n, noise_n)
        if leftover > max(rules.leftover_over_noise, 1.0) * noise_n:
            why = f"{leftover * unit_n:.3g} N beyond the noise is left, and no candidate explains it"
            return _decision("unknown", None, (), 1.0, why, base, found, folds, noise_n, share, rules)
        why = "no candidate improves the held-out error by more than noise can"
        return _decision("none", None, (), 1.0, why, base, found, folds, noise_n, share, rules)
    left, gap = _leftover(winner.rms_n, noise_n), _leftover(base.rms_n, noise_n)
    weak = share < rules.explained or left > rules.leftover_share * gap
    along = any(get(e).stage == TRANSITION for e in winner.ids)
    inexact = exact and not along and share < rules.exact_share and left > rules.exact_over_noise * noise_n
    if (left > rules.leftover_over_noise * noise_n and weak) or (left > 0.5 * noise_n and share < 0.6) or inexact:
        why = (
            f"the best candidate, {' + '.join(winner.ids)}, explains {100 * share:.0f} % of the reducible error and leaves "
            f"{left * unit_n:.3g} N beyond the noise"
        )
        return _decision("unknown", winner, (), 0.5, why, base, found, folds, noise_n, share, rules)
    rivals = tuple(
        c.ids
        for c in found
        if len(c.ids) == len(winner.ids) and c is not winner and advantage(winner, c, RIVAL_FEW) < rules.margin_nats
    )
    group = (winner.ids, *rivals)
    status = "identified" if not rivals else "ambiguous"
    why = f"adding {' + '.join(winner.ids)} explains {100 * share:.0f} % of the reducible held-out error" + (
        f"; {', '.join(' + '.join(r) for r in rivals)} explain it as well" if rivals else ""
    )
    return _decision(status, winner, group, 0.0, why, base, found, folds, noise_n, share, rules)


def _same_family(c: Candidate, winner: Candidate, base: Candidate) -> bool:
    """Whether a model differs from the winner only by the member of the stick-slip family, and does nearly as well.

    Which member it is rests on the moments of jumps, which no fit meets.
    """
    swapped = set(c.ids) ^ set(winner.ids)
    gain = winner.score - base.score
    return len(swapped) == 2 and swapped <= set(FAMILY) and c.score - base.score > FAMILY_SHARE * gain


def _grow(singles: list[Candidate], found: list[Candidate], base: Candidate, rules: Rules, noise_n: float) -> Candidate:
    """Return the best model, grown effect by effect while each further one carries its share of the gap."""
    winner = singles[0]
    size = 2
    while True:
        larger = [c for c in found if len(c.ids) == size]
        if not larger:
            return winner
        best = larger[0]
        parts = [c for c in found if len(c.ids) == size - 1 and set(c.ids) < set(best.ids)]
        rival = max(parts, key=lambda c: c.score, default=winner)
        rival = max((rival, winner), key=lambda c: c.score)
        gap = base.rms_n**2 - best.rms_n**2
        added = rival.rms_n**2 - best.rms_n**2
        share = FAMILY_PARTNER if set(best.ids) & set(FAMILY) else rules.partner_share
        left = rival.rms_n**2 - noise_n**2
        # a strong first effect dwarfs the second: what counts then is that it clears up what is left
        clears = left > (rules.room_over_noise * noise_n) ** 2 and added > rules.clears * left
        worth = (
            advantage(best, rival) > rules.gain_nats
            and (added > share * gap or (clears and share < FAMILY_PARTNER))
            and added > (rules.gap_over_noise * noise_n) ** 2
        )
        if not worth:
            return winner
        winner = best
        size += 1


def _matters(c: Candidate, base: Candidate, rules: Rules, noise_n: float) -> bool:
    removed, lead = base.rms_n**2 - c.rms_n**2, advantage(c, base)
    sure = lead > rules.sure_nats and removed > (rules.sure_over_noise * noise_n) ** 2
    if set(c.ids) & set(FAMILY):
        # fits of jumps meet noise by chance more often than others
        return sure
    z, share, nats = rules.large
    large = errors(c, base) > z and removed > share * base.rms_n**2 and c.score - base.score > nats
    return sure or large or (lead > rules.gain_nats and removed > (rules.gap_over_noise * noise_n) ** 2)


def _leftover(rms_n: float, noise_n: float) -> float:
    return float(np.sqrt(max(rms_n**2 - noise_n**2, 0.0)))


def _explained(c: Candidate, base: Candidate, noise_n: float) -> float:
    # a held-out error below the noise shows that the noise was put too high
    reducible = base.rms_n**2 - min(noise_n, base.rms_n, c.rms_n) ** 2
    return float(np.clip((base.rms_n**2 - c.rms_n**2) / reducible, 0.0, 1.0)) if reducible > 0 else 0.0


def _decision(
    status: str,
    winner: Candidate | None,
    group: tuple[tuple[str, ...], ...],
    confidence: float,
    why: str,
    base: Candidate,
    found: list[Candidate],
    folds: Folds,
    noise_n: float,
    explained: float,
    rules: Rules,
) -> Decision:
    size = len(winner.ids) if winner is not None else 1
    rivals = [base, *(c for c in found if len(c.ids) == size)]
    best = winner if winner is not None and status != "none" else base
    behind = np.array([-advantage(best, c) if c is not best else 0.0 for c in rivals])
    weight = np.exp(np.minimum(behind, 0.0) / rules.temperature)
    weight /= weight.sum()
    probability = {c.ids: float(p) for c, p in zip(rivals, weight, strict=True)}
    if status == "none":
        lead = max((advantage(c, base) for c in found), default=0.0)
        confidence = float(1.0 / (1.0 + np.exp(min((lead - rules.gain_nats) / rules.temperature, 50.0))))
        confidence = max(confidence, 0.5)
    elif status != "unknown":
        confidence = float(min(1.0, sum(probability[g] for g in group)))
    evidence = _evidence(status, winner, base, found, folds, explained)
    return Decision(status, winner, group, confidence, why, base, tuple(found), probability, folds, noise_n, explained, evidence)


def _evidence(
    status: str, winner: Candidate | None, base: Candidate, found: Sequence[Candidate], folds: Folds, explained: float
) -> str:
    """Return the kind of evidence behind a verdict: what its confidence is calibrated by."""
    if status == "none":
        lead = max((advantage(c, base) for c in found), default=0.0)
        return "none/near" if lead > NEAR_NATS else "none/quiet"
    if status == "unknown":
        if winner is None:
            return "unknown/left"
        return "unknown/inexact" if explained > FULL_SHARE else "unknown/misfit"
    if not folds.honest:
        return f"{status}/repeats"
    if winner is not None and len(winner.ids) > 1:
        return f"{status}/several"
    clear = winner is not None and advantage(winner, base) > CLEAR_NATS
    return f"{status}/{'clear' if clear else 'close'}"
