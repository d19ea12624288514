"""What an accepted model leaves of its own record: known from then on, and no change of the rig.

No model of a real rig is complete. What it left when it was accepted has two parts: a mean that comes again wherever the rig
is in the same state (see state), and a scatter about it (model discrepancy, Kennedy and O'Hagan 2001). A later record is
judged against the mean, what is not known of it, and the scatter (see discrepancy for how they are learned).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from sstl_cli.diagnosis import state
from sstl_cli.diagnosis.constants import UNSEEN_SHARE
from sstl_cli.diagnosis.fit import Fit
from sstl_cli.diagnosis.laid import scatter_rms_n
from sstl_cli.diagnosis.latent import block_mean
from sstl_cli.diagnosis.records import Problem, Record
from sstl_cli.diagnosis.simulator import Simulator
from sstl_cli.diagnosis.wander import Wander, nowhere
from sstl_cli.diagnosis.whitening import Noise, whitener
from sstl_cli.physics.scenario import MisfitSection

Array = NDArray[np.float64]
Key = tuple[str, str]


def applied(problem: Problem, sections: Sequence[MisfitSection], unit_n: float, told: bool = True) -> Problem:
    """Return a problem whose records know what the simulator leaves: the mean joins the prediction, doubt and scatter the noise.

    Parameters
    ----------
    told : bool
        Whether the map itself is known, or only how large such maps are: so it was before it was learned.
    """
    if not sections:
        return problem
    by_key: dict[Key, MisfitSection] = {(s.system, s.config_id): s for s in sections}
    own = {k: _factor(s, [r for r in problem.records if _key(r, problem) == k], unit_n, told) for k, s in by_key.items()}
    width = max((f.shape[1] for f in own.values()), default=0)
    padded = {k: np.pad(f, ((0, 0), (0, width - f.shape[1]))) for k, f in own.items()}
    return replace(problem, records=tuple(_known(r, _key(r, problem), by_key, padded, unit_n, told) for r in problem.records))


def _key(r: Record, problem: Problem) -> Key:
    return r.system, problem.configs[r.config]


def _along(r: Record) -> str:
    return "position" if r.slip is not None else "turning"


def _factor(section: MisfitSection, records: Sequence[Record], unit_n: float, told: bool) -> Array:
    """Return the columns of the doubt about a map (N, shape (knots, k)) that these records show beside the scatter."""
    places = [_place(section, r, unit_n) for r in records if _along(r) == section.along]
    if not places:
        return np.zeros((len(section.mean_n), 0))
    if told:
        factor = np.array(section.doubt_n).T.reshape(len(section.mean_n), -1)
    else:
        factor = section.size_n * np.linalg.cholesky(state.alike(len(section.input_n), len(section.other)))
    information = np.zeros((factor.shape[1],) * 2)
    for r, place in zip([r for r in records if _along(r) == section.along], places, strict=True):
        # slow noise says as much as independent readings two correlation times apart
        apart = 2.0 * state.lasting(r, section.correlation_s, _path(section) / _of_path(r, unit_n)) / (r.dt_s * r.factor)
        scatter = np.maximum(place @ np.array(section.sd_n), np.finfo(float).tiny) * np.sqrt(np.maximum(apart, 1.0))
        columns = (place @ factor / scatter[:, None])[r.weight > 0]
        information += columns.T @ columns
    size, way = np.linalg.eigh(information)
    return np.asarray(factor @ way[:, size > UNSEEN_SHARE]) / unit_n


def _known(r: Record, key: Key, by_key: Mapping[Key, MisfitSection], factors: Mapping[Key, Array], unit_n: float, told: bool) -> Record:
    own = by_key.get(key)
    width = max((f.shape[1] for f in factors.values()), default=0)
    if own is None or own.along != _along(r):
        # a bend that the model has not seen: how much it leaves is known, not where
        others = [s for s in by_key.values() if s.system == r.system]
        if not others:
            return replace(r, wander=_doubted(r, np.zeros((len(r), width))))
        total = float(np.sqrt(np.mean([_total(s) ** 2 for s in others]))) / unit_n
        slow, far = (float(np.median([x(s) for s in others])) for x in (lambda s: s.correlation_s, _path))
        return replace(
            r,
            misfit_n=np.full(len(r), total),
            misfit_s=state.lasting(r, slow, far / _of_path(r, unit_n)),
            wander=_doubted(r, np.zeros((len(r), width))),
        )
    place = _place(own, r, unit_n)
    sd = np.hypot(place @ np.array(own.sd_n), _total(own) * _further(own, r, unit_n)) / unit_n
    known = replace(
        r,
        misfit_n=sd,
        misfit_s=state.lasting(r, own.correlation_s, _path(own) / _of_path(r, unit_n)),
        tail=own.tail or float("inf"),
        wander=_doubted(r, place @ factors[key]),
    )
    return replace(known, known=np.repeat(place @ np.array(own.mean_n) / unit_n, r.factor)) if told else known


def _path(section: MisfitSection) -> float:
    return section.correlation_path or float("inf")


def _of_path(r: Record, unit_n: float) -> float:
    """Return what one unit of a record's path is in the units of a section."""
    return unit_n if r.slip is None else 1.0


def _doubted(r: Record, columns: Array) -> Wander:
    return replace(r.wander or nowhere(len(r)), bend=columns)


def _total(section: MisfitSection) -> float:
    """Return how large (N) what a model leaves is on the whole."""
    return float(np.sqrt(np.mean(np.square(section.mean_n)) + np.mean(np.square(section.sd_n))))


def _further(section: MisfitSection, r: Record, unit_n: float) -> Array:
    """Return how far beyond what the model has seen a record goes, in parts of that, shape (n,): in rate, and in its input.

    What a model misses may grow in proportion to what it has not seen.
    """
    u, rate = block_mean(r.u, r.factor) * unit_n, block_mean(r.rate, r.factor) * unit_n
    span = section.input_n[-1] - section.input_n[0]
    outside = np.maximum(section.input_n[0] - u, u - section.input_n[-1]) / span if span > 0.0 else np.zeros(len(r))
    if section.rate_n_s is None:
        return np.maximum(outside, 0.0)
    seen = np.maximum(np.where(rate > 0.0, *section.rate_n_s), UNSEEN_SHARE * max(section.rate_n_s))
    return np.asarray(np.maximum(np.maximum(np.abs(rate) / seen - 1.0, outside), 0.0))


def _place(section: MisfitSection, r: Record, unit_n: float) -> Array:
    """Return the weights of a section's knots at every sample of a record in units of ``unit_n``, shape (n, 2 knots knots)."""
    second = np.array(section.other) / (unit_n if section.along == "turning" else 1.0)
    return state.design(*state.state(r), np.array(section.input_n) / unit_n, second)


def beyond(sim: Simulator, accepted: Fit, sections: Sequence[MisfitSection], noise: Noise, told: bool) -> tuple[Simulator, Fit]:
    """Return the simulator that knows what it leaves, and its fit whitened by that; for its own record there is no doubt.

    Parameters
    ----------
    told : bool
        Whether it knows the map, or only how large such maps are.
    """
    plain = tuple(replace(r, known=None, misfit_n=None, tail=float("inf"), wander=None) for r in sim.problem.records)
    bare = replace(sim.problem, records=plain)
    sure = [s.model_copy(update={"doubt_n": ()}) for s in sections]
    knowing = Simulator(applied(bare, sure, 1.0, told), sim.mechanics, sim.fixed, behind=sim.behind, zeros_n=sim.zeros_n)
    whiten = whitener(knowing.constants({}, noise), knowing.phases(accepted.theta, accepted.effects, noise))
    left = accepted.residual + known(sim.problem) - known(knowing.problem)
    return knowing, replace(accepted, residual=left, whiten=knowing.jerky(whiten, left))


def known(problem: Problem) -> Array:
    """Return what the simulator is known to leave (N, shape (samples,))."""
    return np.concatenate([np.zeros(len(r)) if r.known is None else block_mean(r.known, r.factor) for r in problem.records])


def rms_n(problem: Problem) -> float:
    """Return the RMS (N) of what the simulator is known to leave of these records, 0 where nothing is known."""
    weight = np.concatenate([r.weight for r in problem.records])
    return float(np.sqrt(np.sum(weight * (known(problem) ** 2 + scatter_rms_n(problem.records) ** 2)) / max(float(weight.sum()), 1.0)))


def rescaled(section: MisfitSection, unit_n: float) -> MisfitSection:
    """Return a section that was learned in units of ``unit_n`` (N) in newtons."""

    def times(values: Sequence[float]) -> tuple[float, ...]:
        return tuple(unit_n * v for v in values)

    return section.model_copy(
        update={
            "input_n": times(section.input_n),
            "mean_n": times(section.mean_n),
            "sd_n": times(section.sd_n),
            "other": times(section.other) if section.along == "turning" else section.other,
            "size_n": unit_n * section.size_n,
            "correlation_path": section.correlation_path and section.correlation_path * (unit_n if section.along == "turning" else 1.0),
            "doubt_n": tuple(times(c) for c in section.doubt_n),
            "rate_n_s": None if section.rate_n_s is None else times(section.rate_n_s),
        }
    )
