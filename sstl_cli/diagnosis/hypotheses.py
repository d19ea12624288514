"""The ways in which one effect can be there: which sensor, which system, which of its laws."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from sstl_cli.diagnosis.free import LINE, RUNS, Free, free_parameters
from sstl_cli.physics.effects import get

# effects that differ only in how fast they are, or in when a jump comes: what cannot be told apart stands as one class
FAMILIES = {"lag": ("channel_delay", "channel_lowpass"), "stick-slip": ("dwell_aging", "stick_slip", "stribeck")}

# linear in what is read, whatever theta
GAIN = ("gain_error",)


@dataclass(frozen=True)
class Hypothesis:
    """Effects with the parameters that are free in them; all others stay neutral."""

    ids: tuple[str, ...]
    free: tuple[Free, ...]

    @property
    def strengths(self) -> tuple[Free, ...]:
        """The free parameters that switch an effect on."""
        return tuple(f for f in self.free if not f.parameter.shape)

    @property
    def foretold(self) -> bool:
        """Whether its parameters say what another run will be like."""
        return all(f.effect is not RUNS for f in self.free)

    def joined(self, other: Hypothesis) -> Hypothesis:
        """Return both together; what they share is free once."""
        more = tuple(f for f in other.free if f not in self.free)
        return Hypothesis((*self.ids, *(i for i in other.ids if i not in self.ids)), (*self.free, *more))


def at_known_load(h: Hypothesis) -> Hypothesis:
    """Return a hypothesis under which the load gives way as far as it is known to: another one would change what is there already."""
    return Hypothesis(h.ids, tuple(f for f in h.free if f.effect is not LINE))


def as_changes(h: Hypothesis, there: Mapping[str, Mapping[str, float]]) -> Hypothesis:
    """Return a hypothesis whose effects may be in the simulator already: their strengths change as far as the sum has a meaning, shapes stay.

    Friction that is there may become less: a strength that cannot be negative may be so as a change.
    """
    return Hypothesis(h.ids, tuple(_as_change(f, there) for f in h.free if not (f.parameter.shape and f.effect.id in there)))


def _as_change(f: Free, there: Mapping[str, Mapping[str, float]]) -> Free:
    if f.effect.id not in there:
        return f
    p = f.parameter
    off = f.effect.complete(there[f.effect.id])[p.name] - p.neutral
    least, most = p.least - off, p.most - off
    # what is usual one way is so the other way, as far as there is anything to change
    low, high = (x if x != p.neutral else 2.0 * p.neutral - other for x, other in ((p.low, p.high), (p.high, p.low)))
    return Free(f.effect, replace(p, low=max(low, least), high=min(high, most), limits=(least, most)))


def of_other_laws(effect_id: str) -> set[str]:
    """Return the names of the parameters that laws beside the usual one have."""
    return {n for law in get(effect_id).laws for n in law}


def full(effect_id: str, systems: Sequence[str]) -> Hypothesis:
    """Return an effect with everything free that the recorded systems can show, but for laws beside the usual one."""
    beside = of_other_laws(effect_id)
    return Hypothesis((effect_id,), tuple(f for f in free_parameters((effect_id,), systems) if f.parameter.name not in beside))


def laws(effect_id: str, systems: Sequence[str]) -> list[Hypothesis]:
    """Return the hypotheses by the laws of an effect beside the usual one that the recorded systems can show, the fewest parameters first."""
    free = free_parameters((effect_id,), systems)
    found = {tuple(f for f in free if f.parameter.name in law): None for law in get(effect_id).laws}
    kept = [h for h in (Hypothesis((effect_id,), f) for f in found) if h.strengths]
    return sorted(kept, key=lambda h: len(h.strengths))


def variants(effect_id: str, systems: Sequence[str]) -> list[Hypothesis]:
    """Return the hypotheses of one effect on the recorded systems, the fewest strengths first; those by its usual law before others."""
    return sorted([*by_usual_law(effect_id, systems), *laws(effect_id, systems)], key=lambda h: len(h.strengths))


def by_usual_law(effect_id: str, systems: Sequence[str]) -> list[Hypothesis]:
    """Return the hypotheses of one effect by its usual law, the fewest strengths first."""
    whole = full(effect_id, systems)
    names = [f.parameter.name for f in whole.strengths]
    declared = get(effect_id).variants
    known = [f.parameter.name for f in whole.free]
    if declared:
        chosen = {tuple(n for n in v if n in known) for v in declared} - {()}
    else:
        chosen = {c for size in {1, 2, len(names)} for c in itertools.combinations(names, size)}
    return [_only(whole, c) for c in sorted(chosen, key=lambda c: (len(c), [known.index(n) for n in c]))]


def _only(whole: Hypothesis, names: Sequence[str]) -> Hypothesis:
    claimed = {n for v in get(whole.ids[0]).variants for n in v}

    def stays(f: Free) -> bool:
        # a shape that no variant claims belongs to all of them
        return f.parameter.name in names or (f.parameter.shape and f.parameter.name not in claimed)

    kept = [f for f in whole.free if stays(f)]
    return Hypothesis(whole.ids, tuple(kept))


def apart(ids: Sequence[str]) -> bool:
    """Return whether no two effects are of one family: together they would explain what either does."""
    return all(len(set(members) & set(ids)) < 2 for members in FAMILIES.values())


def title(effect_id: str) -> str:
    """Return the family of an effect, or its own name."""
    return next((name for name, members in FAMILIES.items() if effect_id in members), effect_id)


def with_zeros(effect_id: str) -> str:
    """Return the title of an effect, one for every zero: one that goes with the run joins others as one that goes with the bend."""
    return "zero" if effect_id.startswith("zero_") else title(effect_id)
