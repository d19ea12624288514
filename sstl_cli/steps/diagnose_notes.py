"""What is to be known beside the numbers of a diagnosis, in words."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from sstl_cli.core.documents.diagnosis import Candidate, Gap
from sstl_cli.core.numbers import quantity
from sstl_cli.diagnosis import by_run
from sstl_cli.diagnosis.free import ASIDE, Free
from sstl_cli.diagnosis.reasons import also, without_name
from sstl_cli.diagnosis.verdict import AMBIGUOUS, IDENTIFIED, UNDECIDED
from sstl_cli.physics.effects import get
from sstl_cli.steps.diagnose_given import Given


def of(g: Given) -> list[str]:
    """Return what the record, the models and the verdict leave to be said."""
    p, folds, notes = g.problem, g.search.held_out.folds, []
    if any(r.slip is not None for r in p.records):
        notes.append("driven by the recorded motion: its direction sets the sign of friction, reversals are left out")
    if not folds.honest:
        notes.append(f"held out: {folds.kind}; repeats of one excitation protect little against a wrong name")
    if len(p.configs) == 1:
        notes.append("one configuration: offsets, constant and terminal friction cannot be told apart by their spread")
    if len(p.systems) == 1:
        notes.append(f"only {p.systems[0]} was recorded: effects of the other system cannot show")
    if p.set_aside:
        notes.append(f"{len(p.set_aside)} runs set aside")
    if (differs := by_run.shown(g.search.sim, g.accepted)) is not None:
        notes.append(_by_run(g, *differs))
    if g.verdict.status in (IDENTIFIED, AMBIGUOUS) and (alike := also(g.rows, g.verdict.effects)):
        notes.append(alike)
    if g.verdict.status == UNDECIDED and (own := without_name(g.search, g.rows)) is not None:
        loop = f"loop_friction = {g.search.sim.loop_friction(own.fit.effects):.4g}"
        notes.append(f"friction of the loop is a constant of the rig: with {loop} in [rig] of --sim other effects can be asked for")
    notes += [
        f"{get(i).id}: {x.parameter.name} lies outside its usual range {x.parameter.low:g}..{quantity(f'{x.parameter.high:g}', x.parameter.unit)}"
        for k, x in enumerate(g.accepted.free)
        for i in (x.effect.id,)
        if x.effect.id not in ASIDE and g.accepted.at_bound(k) and not x.parameter.shape
    ]
    return notes


def of_alternatives(found: Sequence[Candidate], effects: Sequence[str]) -> list[str]:
    """Return what the data do not tell of the one effect that is named: which sensor one sits in, or which law it follows.

    Examples
    --------
    >>> from sstl_cli.core.documents.diagnosis import Parameter
    >>> z = Parameter.model_construct(name="z_in_act_n", unit="N", effect="zero_offset", estimate=-1.5)
    >>> own = Candidate.model_construct(id="zero_offset", parameters=[z], alternatives=[{"z_out_act_n": 1.7}])
    >>> of_alternatives([own], ("zero_offset",))
    ['zero_offset: this data does not tell apart z_in_act_n -1.5 N and z_out_act_n 1.7 N']
    >>> of_alternatives([own.model_copy(update={"alternatives": [{"straight_in_act_n": -1.5}]})], ("zero_offset",))
    []
    >>> of_alternatives([own], ())
    []
    """
    # under two names the same where one system alone was recorded: all outputs, and that one
    own = [(c.id, _apart([_strengths(c), *(c.alternatives or ())])) for c in found if [c.id] == list(effects)]
    return [f"{k}: this data does not tell apart {' and '.join(_told(k, x) for x in told)}" for k, told in own if len(told) > 1]


def _apart(told: Sequence[dict[str, float]]) -> list[dict[str, float]]:
    """Return strengths by hypothesis, of those with the same values the first."""
    return list({tuple(f"{v:.3g}" for v in x.values()): x for x in reversed(told)}.values())[::-1]


def of_changes(found: Sequence[Candidate], effects: Sequence[str]) -> list[str]:
    """Return by how much what is named differs from the simulator that contains it already.

    Examples
    --------
    >>> from sstl_cli.core.documents.diagnosis import Parameter
    >>> w = Parameter.model_construct(name="w_end_n", unit="N", effect="const_friction", estimate=-0.289)
    >>> own = Candidate.model_construct(id="const_friction", parameters=[w], change={"w_end_n": -0.289})
    >>> of_changes([own], ("const_friction",))
    ['than in the simulator: w_end_n 0.289 N less']
    """
    own = [c for c in found if effects and sorted(c.id.split("+")) == sorted(effects) and c.change]
    return [f"than in the simulator: {', '.join(_moved(c, k, v) for k, v in (c.change or {}).items() if v)}" for c in own]


def _moved(c: Candidate, parameter: str, by: float) -> str:
    unit = next((p.unit for p in c.parameters if p.name == parameter), None) or "1"
    return f"{parameter} {quantity(f'{abs(by):.3g}', unit)} {'less' if by < 0.0 else 'more'}"


def _strengths(c: Candidate) -> dict[str, float]:
    return {
        p.name: p.estimate for p in c.parameters if p.estimate is not None and p.effect == c.id and not get(c.id).parameter(p.name).shape
    }


def _told(effect_id: str, values: Mapping[str, float]) -> str:
    """Return strengths with their units, in words."""
    return " + ".join(f"{k} {quantity(f'{v:.4g}', get(effect_id).parameter(k).unit)}" for k, v in values.items())


def _by_run(g: Given, kind: Free, parts: Mapping[str, float]) -> str:
    """Return what each run has of its own, in words."""
    friction, unit_n = kind is by_run.FRICTION, g.problem.unit_n
    what = "friction" if friction else f"zero of the {'output' if kind is by_run.OUTPUT else 'input'} sensor"
    told = (f"{run} {100.0 * x:+.1f} %" if friction else f"{run} {x * unit_n:+.3g}" for run, x in parts.items())
    return f"{what} of each run is fitted to it, nobody can foretell that of another: {', '.join(told)}"


def of_units(g: Given) -> list[str]:
    """Return in which units a recording was fitted, where not in those that it has."""
    notes, scale = [], g.scale
    if g.preload_n:
        said = ", ".join(f"{k} {v:.4g} N" for k, v in g.preload_n.items())
        notes.append(
            f"the input goes below zero, where no tendon pulls: taken for a pair stretched by {said}, which is nobody's fault (preload_n in [rig])"
        )
    if scale is not None:
        said = ", ".join(f"{k} {v:.4g} {scale.unit}/N" for k, v in scale.per_n.items())
        notes.append(f"the scale of the output is nobody's fault and was fitted: {said}; parameters are in newtons")
    if g.problem.unit_n != 1.0:
        notes.append(f"fitted in units of {g.problem.unit_n:g} N: the catalogue's ranges are for 3 to 60 N")
    return notes


def beside_floor(gap: Gap, effects: Sequence[str], unit: str) -> list[str]:
    """Return the note on an error that is smaller than the noise floor as it was estimated, or beside it more than noise, if effects are named.

    Examples
    --------
    >>> gap = Gap.model_construct(rmse_with_effect_n=0.0226, noise_floor_n=0.0235, noise_floor_low_n=0.0221, noise_floor_high_n=0.025)
    >>> beside_floor(gap, ("zero_offset",), "N")
    ['the error with the effect is below the noise floor, which is known to 0.0221..0.025 N: nothing above noise is left']
    >>> beside_floor(gap.model_copy(update={"rmse_with_effect_n": 0.05}), ("zero_offset",), "N")
    ['0.05 N are left where noise is 0.025 N at most: zero_offset is not all that is there']
    >>> beside_floor(gap.model_copy(update={"rmse_with_effect_n": 0.05, "accounted_pct": 95.0}), ("stick_slip",), "N")
    []
    >>> beside_floor(gap, (), "N")
    []
    """
    left, floor, low, high = gap.rmse_with_effect_n, gap.noise_floor_n, gap.noise_floor_low_n, gap.noise_floor_high_n
    if not effects or left is None or floor is None:
        return []
    most = floor if high is None else high
    # as much again as noise is, squared; of jumps at moments that nobody can foretell more is left, and accounted for
    if left**2 > 2.0 * most**2 and gap.known_misfit_n is None and gap.accounted_pct is None:
        return [f"{left:.2g} {unit} are left where noise is {most:.2g} {unit} at most: {' + '.join(effects)} is not all that is there"]
    if left >= floor:
        return []
    known = "which is an estimate" if low is None else f"which is known to {low:.3g}..{high:.3g} {unit}"
    return [f"the error with the effect is below the noise floor, {known}: nothing above noise is left"]


def beside_line(left: float, line: float, floor: float, unit: str) -> list[str]:
    """Return the note on a model that leaves more than a straight line does, by more than noise can make of it.

    Parameters
    ----------
    left, line, floor : float
        What the accepted model leaves, and a straight line from input to output, and noise alone (RMS, in ``unit``).

    Examples
    --------
    >>> beside_line(12000.0, 630.0, 570.0, "N")[0]
    'the model leaves 1.2e+04 N, a straight line through input and output 6.3e+02 N: it is no model of this rig; check units, signs and which channel is which'
    >>> beside_line(0.0202, 0.02, 0.02, "N")
    []
    """
    if left**2 <= line**2 + floor**2:
        return []
    beaten = f"the model leaves {left:.2g} {unit}, a straight line through input and output {line:.2g} {unit}"
    return [f"{beaten}: it is no model of this rig; check units, signs and which channel is which"]
