"""A diagnosis as a page shows it: ``sstl.diagnosis/1`` of this version or an older one."""

from __future__ import annotations

from typing import Annotated

from sstl_cli.reporting.documents import NAN, PART, ROWS, Flag, Interval, Matrix, Number, Numbers, Shown, Text, Texts


class Verdict(Shown):
    """What was found; what a later version may add to it is shown as it is."""

    status: Text = ""
    effects: Texts = ()
    confidence: Number = NAN
    confidence_why: Text = ""
    ambiguity_group: Texts = ()
    why: Text = ""
    members: object = None
    would_have_shown: object = None
    leftover: object = None
    odd_runs: object = None

    def group(self) -> tuple[str, ...]:
        """Return the effects of the ambiguity group, classes replaced by their members."""
        known = self.members if isinstance(self.members, dict) else {}
        return tuple(dict.fromkeys(m for e in self.ambiguity_group for m in parts(known.get(e)) or [e]))


class Gap(Shown):
    """The error step by step, in the unit of the output."""

    rmse_base_n: Number = NAN
    rmse_retuned_n: Number = NAN
    rmse_with_effect_n: Number = NAN
    noise_floor_n: Number = NAN
    known_misfit_n: Number = NAN
    shrink_pct: Number = NAN
    shrink_ci95_pct: Interval = None
    shrink_ci95_pct_why: Text = ""
    shrink_why: Text = ""
    why: Text = ""
    explained_of_reducible_pct: Number = NAN
    samples: Text = ""
    held_out: Flag = False


class Place(Shown):
    """One place of the gap and its share of the squared error."""

    system: Text = ""
    phase: Text = ""
    config_id: Text = ""
    share_pct: Number = NAN
    rmse_n: Number = NAN


class Parameter(Shown):
    """An estimated parameter with its 95 % interval, or why there is none."""

    name: Text = ""
    effect: Text = ""
    unit: Text = ""
    estimate: Number = NAN
    ci95: Interval = None
    ci95_why: Text = ""
    why: Text = ""
    at_bound: Flag = False


class Candidate(Shown):
    """One candidate; what is shown only where it is there stays as the document has it."""

    id: Text = "?"
    probability: Number = NAN
    probability_ci95: Interval = None
    rmse_held_out_n: Number = NAN
    shrink_pct: Number = NAN
    samples: Text = ""
    identifiability: Text = ""
    parameters: Annotated[tuple[Parameter, ...], ROWS] = ()
    sensor: object = None
    d2: object = None
    change: object = None
    members: object = None
    why: object = None


class Next(Shown):
    """The recording that would tell the leading candidates apart."""

    separates: Texts = ()
    trajectory: Text = ""
    why: Text = ""


class Loop(Shown):
    """One run, measured and simulated, in the unit of the output; the time where it is known."""

    run_id: Text = "?"
    system: Text = ""
    time_s: Numbers = ()
    tension_in_n: Numbers = ()
    measured_n: Numbers = ()
    base_n: Numbers = ()
    with_effect_n: Numbers = ()


class Residuals(Shown):
    """Measured minus simulated of one run, before and after the effect."""

    run_id: Text = "?"
    system: Text = ""
    time_s: Numbers = ()
    tension_in_n: Numbers = ()
    base_n: Numbers = ()
    effect_n: Numbers = ()


class Isolability(Shown):
    """Cosines between the responses of the effects."""

    ids: Texts = ()
    cosine: Matrix = ()


class Tracked(Shown):
    """What a controller makes of one reference, designed without and with the effect."""

    reference: Text = ""
    rmse_without_n: Number = NAN
    rmse_with_n: Number = NAN


class Downstream(Shown):
    """What the named effect is worth to a controller."""

    tracking: Annotated[tuple[Tracked, ...], ROWS] = ()


class Diagnosed(Shown):
    """A diagnosis; where it judges several tendons, each has a block of its own."""

    file: Text = ""
    package_version: object = None
    unit: Text = ""
    sentence: Text = ""
    tendon: Text = ""
    verdict: Annotated[Verdict, PART] = Verdict()
    gap: Annotated[Gap, PART] = Gap()
    where: Annotated[tuple[Place, ...], ROWS] = ()
    candidates: Annotated[tuple[Candidate, ...], ROWS] = ()
    next_experiment: Annotated[Next, PART] = Next()
    remarks: Texts = ()
    notes: Texts = ()
    loops: Annotated[tuple[Loop, ...], ROWS] = ()
    residuals: Annotated[tuple[Residuals, ...], ROWS] = ()
    isolability: Annotated[Isolability, PART] = Isolability()
    downstream: Annotated[Downstream, PART] = Downstream()
    tendons: Annotated[tuple[Diagnosed, ...], ROWS] = ()

    def by_tendon(self) -> list[tuple[str, Diagnosed]]:
        """Return (name, diagnosis) of every tendon, the leading one first; the diagnosis itself where it has but one.

        The leading tendon's block is the top level too: it has the loops and the isolability, which the others lack.
        """
        if not self.tendons:
            return [("", self)]
        shared = {k: getattr(self, k) for k in ("unit", "package_version", "file")}
        found = []
        for t in sorted(self.tendons, key=lambda t: t.tendon != self.tendon):
            own = {k: getattr(t, k) for k in t.model_fields_set}
            base = self if t.tendon == self.tendon else Diagnosed()
            found.append((t.tendon or "without a name", base.model_copy(update={**shared, **own})))
        return found


def parts(members: object) -> list[str]:
    """Return the effects of a class that this data cannot separate: a list, or lists by the name of the class."""
    found = [m for group in members.values() for m in group] if isinstance(members, dict) else members
    return [str(m) for m in found] if isinstance(found, list) else []
