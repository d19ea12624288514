"""One run whose friction fits another configuration: every one is tried for every run, and the one that makes all runs agree is told.

``passes`` and ``labels`` compare slopes. Here friction is that of the law which leaves least, known to some percent only, so that no small difference counts.
Runs that are only pulled show one slope, of friction and gain together; the gain is that of the sensors in all runs of a system, and whatever the law, what is
passed on of the highest input is then a measure of the bend.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from sstl_cli.identification.gate.evidence import Evidence
from sstl_cli.identification.gate.remark import Remark, names
from sstl_cli.identification.gate.rules.two_rigs import second_rig

RULE, RANK = "relabelled", 58
AFTER = ("passes", "exchanged", "labels", "two_rigs")
# of the logarithm: how far a run is from the others of its label at the least, and from those of another one at the most; the largest scatter of all others
ODD, FITS = 0.7, 0.2
# and how far what is known of friction may be from that of the best explanation of its run
SURE = 0.4
# on a nearly straight tube ends and pulleys decide
LEAST = 0.1
# runs that must tell their friction
FEW = 4
# what is passed on of the highest input (logarithm): how far a run must be from those of its label, in it and in the scatter of all others; within how much of
# that scatter it must be of another label, and other bends of several runs that must tell the scatter
PULLED, SCATTERS, WITHIN, BENDS = 0.1, 3.5, 2.0, 2
# as ODD and FITS of n theta by what is passed on, which no law is needed for: gains of sensors, and a pulley, keep it from being known better
PULLED_ODD, PULLED_FITS = 0.35, 0.15


@dataclass(frozen=True)
class _Told:
    """Logarithm of n theta of a run, and its labels."""

    run: Evidence
    size: float
    config: str
    system: str

    @property
    def cell(self) -> tuple[str, str, str | None]:
        return self.config, self.system, self.run.trajectory


def look(log: Sequence[Evidence]) -> Iterator[Remark]:
    """Yield the run of a place that has another label than its own."""
    places: dict[object, list[_Told]] = {}
    for e in log:
        if e.config_id is not None and e.wrap_about > LEAST and _sure(e):
            places.setdefault((e.location, e.tendon), []).append(_Told(e, math.log(e.wrap_about), e.config_id, e.system))
    if second_rig(log)[0]:
        return
    named: set[str] = set()
    for told in places.values():
        # what all agree on needs no other label
        said = list(_relabelled(told)) if len(told) >= FEW and _apart(told) > ODD else []
        yield from said
        named |= {r.run_ids[0] for r in said}
    yield from (r for r in _by_pulls(log) if r.run_ids[0] not in named)


def _by_pulls(log: Sequence[Evidence]) -> Iterator[Remark]:
    """Yield the run of a place that passes on what another configuration does: beside others of its system, or where each bend is pulled once in both."""
    places: dict[object, dict[str, list[Evidence]]] = {}
    for e in log:
        if e.config_id is not None and e.tendon_like and e.wide and math.isfinite(e.passed):
            places.setdefault((e.location, e.tendon), {}).setdefault(e.system, []).append(e)
    for systems in places.values():
        every = [e for runs in systems.values() for e in runs]
        said = [r for runs in systems.values() for r in _pulled(runs, every)]
        if not said and all(e.one_way for e in every):
            told = [_Told(e, math.log(-e.passed), str(e.config_id), e.system) for e in every if -e.passed > LEAST]
            said = list(_relabelled(told, PULLED_FITS)) if len(told) >= FEW and _apart(told) > PULLED_ODD else []
        yield from said


def _sure(e: Evidence) -> bool:
    """Whether the law, alone or with a slip, that leaves least of a run says its friction as well."""
    best = min((c for c in e.causes.slips if math.isfinite(c.rms_n)), key=lambda c: c.rms_n, default=e.causes.friction)
    return best.wrap > 0.0 and abs(math.log(best.wrap / e.wrap_about)) < SURE


def _relabelled(told: list[_Told], within: float = FITS) -> Iterator[Remark]:
    """Yield the one run whose other label makes all runs agree, within so much of the logarithm."""
    configs = sorted({t.config for t in told})
    fits: list[tuple[_Told, _Told]] = []
    for t in told:
        rest = [o for o in told if o is not t]
        # friction that is known to a factor does not tell one pass from two
        others = [replace(t, config=c) for c in configs if c != t.config]
        # a run that is alone with its new label agrees with nothing
        fits += [(t, o) for o in others if any(r.config == o.config for r in rest) and _apart([*rest, o]) < within]
    if not fits:
        return
    # of several labels that fit the likelier one leaves no cell of the series twice
    cells = [t.cell for t in told]
    single = [(t, o) for t, o in fits if cells.count(t.cell) > 1 and o.cell not in cells]
    fits = single or fits
    runs = {t.run.run_id for t, _ in fits}
    if len(runs) > 1:
        return
    t = fits[0][0]
    double = _double(told, t)
    # two passes put on one, as this run has them
    passes = {"act": 0.0, "sstl": double}
    own = [o.size - passes[o.system] + passes[t.system] - t.size for o in told if o is not t and o.config == t.config]
    off = float(np.median(own)) if own else 0.0
    labels = [o.config for _, o in fits]
    yield Remark(
        (t.run.run_id,), RULE, "remark", 100.0 * math.expm1(abs(off)), "%",
        f"{names([t.run.run_id])}: labelled configuration {t.config}, but n theta of {math.exp(t.size):.2g} is {math.exp(-off):.2g} times what the other runs of "
        f"that label tell; as configuration {' or '.join(labels)} it agrees with all others, so that the label of its configuration is probably wrong",
        "file_name = '(pattern that reads config_id from the name)', or a manifest with the right config_id",
    )  # fmt: skip


def _pulled(runs: list[Evidence], every: list[Evidence]) -> Iterator[Remark]:
    """Yield the one run of a system that is only pulled and passes on as much as another configuration does, where all others agree with their own."""
    hit = []
    for e in runs:
        if not e.one_way:
            continue
        bends: dict[str, list[float]] = {}
        for o in runs:
            if o is not e:
                bends.setdefault(str(o.config_id), []).append(o.passed)
        repeated = [float(np.ptp(v)) for v in bends.values() if len(v) > 1]
        if str(e.config_id) not in bends or len(repeated) < BENDS:
            continue
        scatter = max(repeated)
        off = {k: abs(e.passed - float(np.median(v))) for k, v in bends.items()}
        own = off.pop(str(e.config_id))
        fits = max(WITHIN * scatter, PULLED / SCATTERS)
        near = [k for k, v in off.items() if v < fits]
        if own > max(PULLED, SCATTERS * scatter) and near:
            hit.append((e, near, fits, float(np.median(bends[str(e.config_id)]))))
    if len(hit) == 1:
        e, near, fits, level = hit[0]
        apart = abs(e.passed - level)
        # one pass of a bend may pass on what two of another one do
        system = any(o.system != e.system and o.config_id == e.config_id and abs(o.passed - e.passed) < fits for o in every)
        yield Remark(
            (e.run_id,), RULE, "remark", 100.0 * math.expm1(apart), "%",
            f"{names([e.run_id])}: labelled configuration {e.config_id}, but {math.exp(e.passed):.3g} of its highest input is passed on, where the other {e.system} runs of that "
            f"label pass on {math.exp(level):.3g}, and as much as in those of {' or '.join(near)}; the label of its configuration{' or of its system' if system else ''} is probably wrong (or, as the run is only pulled, the output "
            "had another gain)",
            "file_name = '(pattern that reads config_id from the name)', or a manifest with the right config_id",
        )  # fmt: skip


def _double(told: Sequence[_Told], but: _Told | None = None) -> float:
    """Return by how much (logarithm) two passes rub more than one, in bends that show both; twice where none does."""
    bends: dict[str, dict[str, list[float]]] = {}
    for t in told:
        if t is not but:
            bends.setdefault(t.config, {}).setdefault(t.system, []).append(t.size)
    both = [float(np.median(b["sstl"]) - np.median(b["act"])) for b in bends.values() if {"act", "sstl"} <= set(b)]
    return float(np.median(both)) if both else math.log(2.0)


def _apart(told: Sequence[_Told]) -> float:
    """Return how far (logarithm) any run is from the others of its bend, two passes put on one."""
    double = _double(told)
    bends: dict[str, list[float]] = {}
    for t in told:
        bends.setdefault(t.config, []).append(t.size - (double if t.system == "sstl" else 0.0))
    return max((float(np.ptp(sizes)) for sizes in bends.values()), default=0.0)
