"""Name what changed: diagnose the loops since an alarm against the fit to the loops before it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from sstl_cli.core.documents.watch import NamedChange
from sstl_cli.core.errors import SstlError
from sstl_cli.core.runs import Run
from sstl_cli.physics.scenario import Scenario
from sstl_cli.steps.diagnose import DiagnoseOptions, Diagnosis, run

# a theta that moved by less is the same bend
SAME_THETA = 0.02


@dataclass(frozen=True)
class Naming:
    """What changed: the verdict on the loops since, and theta (rad) before and since."""

    status: str
    effects: tuple[str, ...]
    group: tuple[str, ...]
    confidence: float | None
    theta: tuple[float, float] | None
    why: str

    def document(self) -> NamedChange:
        """Return the naming as an alarm tells it."""
        return NamedChange(
            status=self.status,
            effects=list(self.effects),
            ambiguity_group=list(self.group),
            confidence=self.confidence,
            theta_before=None if self.theta is None else self.theta[0],
            theta_now=None if self.theta is None else self.theta[1],
            why=self.why,
        )


def name_change(before: Sequence[Run], since: Sequence[Run], sim: Scenario | None = None) -> Naming:
    """Return what changed between two groups of runs of one configuration.

    The simulator fitted to the loops before is the one that the loops since are compared with, so that only what is
    new has to be explained. An effect that was there before cannot be a candidate again: if nothing new explains the
    loops since, they are diagnosed once more without it, and the same effect is named if it grew.
    """
    if not since:
        return _unknown("no loop is at hand since the change")
    before, since = [_named(r) for r in before], [_named(r) for r in since]
    options = DiagnoseOptions(sim=sim, max_effects=2, workers=2)
    old: Diagnosis | None = None
    why = "no loop is at hand before the change"
    if before:
        try:
            old = run(before, options)
        except SstlError as error:
            why = f"the loops before the change cannot be diagnosed: {error.what}"
    fitted = old.model() if old is not None else sim
    try:
        new = run(since, replace(options, sim=fitted))
    except SstlError as error:
        return _unknown(f"the loops since the change cannot be diagnosed: {error.what}")
    theta = None if old is None else (_theta(old), _theta(new))
    verdict = new.body.verdict
    status, effects = verdict.status, tuple(verdict.effects)
    if old is None:
        return Naming(status, effects, tuple(verdict.ambiguity_group), verdict.confidence, theta, f"{why}; {verdict.why}")
    if status == "none" and theta is not None:
        moved = abs(theta[1] - theta[0]) > SAME_THETA * max(theta[0], 0.05)
        text = (
            f"the bend or its friction changed: theta {theta[0]:.3g} -> {theta[1]:.3g} rad explains the loops since; recalibrate"
            if moved
            else "the simulator fitted before explains the loops since: the change is smaller than it can tell, or a false alarm"
        )
        return Naming("retuned" if moved else "none", (), (), verdict.confidence, theta, text)
    known = set(old.body.verdict.effects)
    if status not in ("identified", "ambiguous") and known:
        again = run(since, options).body.verdict
        if again.status == "identified" and set(again.effects) <= known:
            grown = f"{' + '.join(again.effects)}, there before the change, is stronger since"
            return Naming("identified", tuple(again.effects), (), again.confidence, theta, grown)
    return Naming(status, effects, tuple(verdict.ambiguity_group), verdict.confidence, theta, verdict.why)


def _named(one: Run) -> Run:
    # runs without a configuration would share no theta
    return one if one.config_id is not None else replace(one, config_id="(none)")


def _theta(result: Diagnosis) -> float:
    return float(result.accepted.theta.mean())


def _unknown(why: str) -> Naming:
    return Naming("unknown", (), (), None, None, why)
