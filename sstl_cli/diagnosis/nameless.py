"""What the catalogue has no name for, but its effects look like: the sensing loop does not rub as the actuation tendon does.

Simulator and catalogue have one theta for both. A pulley loses the same in every bend, a gain goes with the tension; without this rival either
would be named for what one number says of all bends.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from sstl_cli.diagnosis import by_run
from sstl_cli.diagnosis.constants import DECIDES_NATS, JOINS_NATS, LEADERS
from sstl_cli.diagnosis.evidence import Weighed, weigh
from sstl_cli.diagnosis.fit import fit, settle
from sstl_cli.diagnosis.found import Search, each
from sstl_cli.diagnosis.free import LOOP, Free
from sstl_cli.diagnosis.hypotheses import Hypothesis

DIFFERS = Free(LOOP, LOOP.parameters[0])
HYPOTHESIS = Hypothesis((LOOP.id,), (DIFFERS,))


def beside(found: Search, most: int, workers: int) -> Search:
    """Return the search with friction of its own for the sensing loop: alone, and beside the leading effects.

    Parameters
    ----------
    most : int
        How many effects may stand together.
    """
    # beside what an accepted model is known to leave a share of its friction is among what that varies by
    if found.sim.scatters or len(found.sim.problem.systems) < 2:
        return found
    alone = _weighed(found, Weighed(found.base, 0.0, 0.0))
    leaders = [w for w in found.ranked() if len(w.ids) == 1 and w.evidence > 0.0 and by_run.kind_of(w.fit) is None][:LEADERS]
    found = replace(found, nameless=(alone,))
    return replace(found, nameless=(alone, *each(lambda w: _weighed(found, w), leaders if most > 1 else [], workers)))


def _weighed(found: Search, on: Weighed) -> Weighed:
    """Return a model with friction of its own for the sensing loop."""
    f = on.fit
    start = fit(found.sim, f.whiten, f.hypothesis.joined(HYPOTHESIS), f.theta, np.append(f.values, DIFFERS.parameter.neutral), 0)
    done = settle(found.sim, found.noise, start)
    return weigh(found.sim, done, found.base, found.parts(done.ids))


def leading(found: Search) -> Weighed | None:
    """Return the likeliest model with friction of its own for the loop, where it is beyond all that has a name; None where it is not."""
    if not found.nameless:
        return None
    named, best = max((w.evidence for w in found.ranked()), default=0.0), _best(found)
    return best if best.evidence > max(named, 0.0) + DECIDES_NATS else None


def _best(found: Search) -> Weighed:
    """Return the most evident model; what joins has to add what any further effect has to."""
    return max(found.nameless, key=lambda w: w.evidence - JOINS_NATS * len(w.ids))


def words(found: Search) -> dict[str, str]:
    """Return what is said instead of an id of what has no name: nothing where it was not asked for."""
    if not found.nameless:
        return {}
    there, more = (100.0 * (found.sim.loop_friction(effects) - 1.0) for effects in ({}, _best(found).fit.effects))
    said = f"friction of the sensing loop that is {abs(more):.1f} % {'above' if more > 0.0 else 'below'} the actuation tendon's"
    return {LOOP.id: said + (f", where the simulator has {there:+.1f} %" if there else "")}
