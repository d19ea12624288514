"""The noise once more, beside the models that the search has found.

It was first estimated beside single effects as they had been fitted without it: what only several together explain, or what
differs from run to run, it had to take up. Where it had to leave what was measured by more than is usual, and need not beside
the leading models, all models are judged again with what it is then.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from sstl_cli.diagnosis import by_run, hearing
from sstl_cli.diagnosis.constants import ALIVE_NATS, LEADERS, SHORT_ITERATIONS
from sstl_cli.diagnosis.evidence import Weighed, weigh
from sstl_cli.diagnosis.fit import Fit, settle
from sstl_cli.diagnosis.found import Search, deepest, each
from sstl_cli.diagnosis.noise import strain
from sstl_cli.diagnosis.whitening import Noise


def beside_the_best(found: Search, most: int, workers: int) -> Search:
    """Return the search with noise that is as likely as its leading models have it, or as it is where that strains it no less.

    Parameters
    ----------
    most : int
        How many effects may stand together.
    """
    if strain(found.noise, found.measured) <= 1.0:
        return found
    tried = replace(found, singles=dict(found.singles), combined=dict(found.combined))
    by_run.add(tried, most)
    leaders = [w.fit for w in tried.ranked() if w.evidence > 0.0][:LEADERS]
    if not leaders:
        return found
    noise = _noise(found, leaders)
    return judged(found, noise, workers) if strain(noise, found.measured) < strain(found.noise, found.measured) else found


def _noise(found: Search, leaders: Sequence[Fit]) -> Noise:
    """Return the most likely noise beside the leading models; what the smoother was told of an input's sensor stays."""
    return hearing.beside(found.sim, [found.base, *leaders], replace(found.measured, spread=found.noise.spread))


def judged(found: Search, noise: Noise, workers: int) -> Search:
    """Return every model judged with a noise; those that still promise something are fitted again by it."""
    sim, lead = found.sim, found.ranked()[0].gain

    def again(w: Weighed) -> Fit:
        alive = w.gain > lead - ALIVE_NATS or len(w.ids) > 1
        return settle(sim, noise, w.fit, 1 if alive else 0, SHORT_ITERATIONS)

    singles = {k: each(again, v, workers) for k, v in found.singles.items()}
    likeliest = min((f for v in singles.values() for f in v), key=lambda f: f.cost)
    base = deepest(sim, noise, settle(sim, noise, found.base), [likeliest])
    weighed = {k: tuple(sorted((weigh(sim, f, base) for f in v), key=lambda w: -w.evidence)) for k, v in singles.items()}
    done = replace(found, noise=noise, base=base, singles=weighed, combined={})
    for key, f in zip(found.combined, each(again, list(found.combined.values()), workers), strict=True):
        done.combined[key] = weigh(sim, f, base, done.parts(key))
    return done
